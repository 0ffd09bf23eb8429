#pragma once
/// THE list of the kinds of paths of kinematic bodies. A new kind is a file in engine/world/paths,
/// included here, and a word in the list: steps, keys of scene files and pictures follow from the
/// file.
#include <variant>

#include "engine/base/fields.hpp"
#include "engine/world/paths/keyframes.hpp"
#include "engine/world/paths/lissajous.hpp"
#include "engine/world/paths/steady.hpp"

#define PANTIN_PATH_KINDS(KIND) \
  KIND(Keyframes)               \
  KIND(Lissajous)               \
  KIND(SteadyMotion)

namespace pantin {
namespace detail {

template <class None, class... Kinds>
struct PathList {
  using Variant = std::variant<Kinds...>;
};
#define PANTIN_NEXT(kind) , kind
using PathKinds = PathList<void PANTIN_PATH_KINDS(PANTIN_NEXT)>::Variant;
#undef PANTIN_NEXT

}  // namespace detail

/// A component of kinematic bodies. Without it the caller moves the body.
struct KinematicPath {
  detail::PathKinds curve;

  static void fields(auto& self, auto&& field) { field("curve", self.curve); }
};

/// The pose on the path at `time` (s). A path without keys stays at the world's origin.
Pose pose_at(const KinematicPath& path, Real time);

/// The path transformed by a rigid motion of the world.
KinematicPath moved(const KinematicPath& path, const Pose& by);

/// The path shifted in time by `ahead` seconds; the rise of a Lissajous curve keeps its time.
KinematicPath shifted(const KinematicPath& path, Real ahead);

namespace detail {

/// The path of a body that starts at `start`; replaces the values that are kLeftOpen.
KinematicPath started(const KinematicPath& path, const Pose& start);

/// An approximate bounding box of its positions.
PathBounds bounds_of(const KinematicPath& path);

/// The number of poses it stores.
std::size_t parts_of(const KinematicPath& path);

/// The rigid motion from the first pose of a periodic path to its last; the identity for others.
Pose seam_of(const KinematicPath& path);

}  // namespace detail
}  // namespace pantin
