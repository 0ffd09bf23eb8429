#pragma once
/// Saves a running World to a file; a loaded World continues bit for bit.
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/world/world.hpp"

namespace pantin {

/// What save_world had to leave out.
struct Saved {
  std::vector<std::string> left_out;  // user component types without `fields`
};

/// Writes the whole World: components, names, materials and solver memory. The file replaces an
/// older one only once it is complete. Step settings and systems are not saved. A joint of a kind
/// of your own (CustomJoint) cannot be saved: an error.
///
/// Only this version on this kind of machine can load the file.
Result<Saved> save_world(const World& world, const std::string& path);

/// Loads a World. `like` has a store, made by `like.store<T>()`, for each of your component types
/// in the file; nothing else of it is used. A file of another version, and one that is truncated or
/// was changed, is an error of one line.
Result<World> load_world(const std::string& path, World like = {});

/// load_world<Wind, Glow>("run.world"): with your component types.
template <class First, class... Rest>
Result<World> load_world(const std::string& path) {
  World like;
  like.store<First>();
  (like.store<Rest>(), ...);
  return load_world(path, std::move(like));
}

/// The same to and from memory; errors name `stage`.
Result<std::string> world_to_bytes(const World& world, Saved* saved = nullptr);
Result<World> world_from_bytes(std::string_view bytes, World like = {},
                               std::string_view stage = "saved World");

}  // namespace pantin
