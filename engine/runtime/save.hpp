#pragma once
/// A running World in a file: what goes on from it does so with the same bits.
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/world/world.hpp"

namespace pantin {

/// What save_world had to leave behind.
struct Saved {
  std::vector<std::string> left_out;  // components of your own without `fields`: looks, remarks
};

/// Writes all of a World: components, names, materials, and what the solvers remember. The file
/// replaces an older one only once it is whole. Settings of the steps and systems are no part of
/// it; joints of a kind of your own (CustomJoint) cannot be saved and are refused.
///
/// The file is for this version on this kind of machine: another one refuses it.
Result<Saved> save_world(const World& world, const std::string& path);

/// The World of a file. `like` has a store of each component type of yours that the file holds,
/// made by `like.store<T>()`; nothing else of it is used. A file of another version, one that was
/// cut off or changed is refused with one line.
Result<World> load_world(const std::string& path, World like = {});

/// load_world<Wind, Glow>("run.world"): with the component types of yours.
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
