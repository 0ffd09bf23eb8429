#pragma once
/// Bounding spheres of everything that is drawn.
#include <optional>
#include <span>
#include <vector>

#include "engine/geometry/kinds.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

struct Ball {
  Vec3 centre{0};   // world, m
  Real radius = 0;  // m
};

inline constexpr std::size_t kMostBalls = 64;  // of one shape

/// Balls whose hull holds the shape of a body at `pose`: one for a sphere, two for a capsule, eight
/// points for a box and for what has many corners or none, else its corners; of more corners than
/// kMostBalls a box stands for them. None for a shape that lacks its surface.
void add_balls(const Shape& shape, const Pose& pose, std::vector<Ball>& to);

/// The flat box that a plane is drawn as: its upper side is the plane, as far as `size.x` from the
/// middle to each side.
Shape slab_of(const Shape& plane);

/// A World as it is drawn: poses by slot of World::bodies; a body that has none there is where it
/// is.
struct PosedWorld {
  const World& world;
  std::span<const Pose> poses = {};

  const Pose& pose_of(std::uint32_t slot) const {
    return slot < poses.size() ? poses[slot] : world.bodies.values()[slot].pose;
  }
  /// The position of a point of a body, world, m; none if the body is gone or its pose not finite.
  std::optional<Vec3> position_of(Entity body, Vec3 anchor) const;
};

/// A cable as it hangs between two points.
struct HangingCable {
  Vec3 a{0}, b{0};      // its ends, world, m
  Real length = 0;      // m
  Vec3 down{0, -1, 0};  // unit, world
};

/// Adds points from `a` to `b` to `to`: one straight piece when the cable is taut, else a parabola
/// of `segments` pieces. It meets the length to 0.1 %.
void add_curve(const HangingCable& cable, int segments, std::vector<Vec3>& to);

/// The same of a cable; over guides as if it were taut. Nothing if a body of the cable is gone or a
/// pose is not finite.
void add_cable(const PosedWorld& scene, const Cable& cable, int segments, std::vector<Vec3>& to);

/// The way gravity points; -y where there is none.
Vec3 down_of(const World& world);

}  // namespace pantin::detail
