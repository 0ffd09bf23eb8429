#pragma once
/// Bounding spheres of all drawn objects.
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

/// Balls whose convex hull contains the shape of a body at `pose`. One for a sphere, two for a
/// capsule, eight points for a box. Other shapes give their corners, or the eight points of a
/// bounding box if they have more than kMostBalls corners or none. Nothing for a shape that lacks
/// its surface.
void add_balls(const Shape& shape, const Pose& pose, std::vector<Ball>& to);

/// Distance of the farthest point of a body's shapes from its mass centre, m; infinite for grounds
/// and without shapes.
Real drawn_reach(const World& world, Entity body);

/// The flat box that represents a plane: its upper side is the plane, and extends `size.x` from the
/// middle to each side.
Shape slab_of(const Shape& plane);

/// A World as drawn: poses by slot of World::bodies; a body without one there has its present pose.
struct PosedWorld {
  const World& world;
  std::span<const Pose> poses = {};
  std::span<const Vec3> colours = {};  // by slot, linear RGB; a body without one has its materials'

  const Pose& pose_of(std::uint32_t slot) const {
    return slot < poses.size() ? poses[slot] : world.bodies.values()[slot].pose;
  }
  /// The position of a body's point, world, m; none if the body is gone or its pose is not finite.
  std::optional<Vec3> position_of(Entity body, Vec3 anchor) const;
};

/// A cable that hangs between two points.
struct HangingCable {
  Vec3 a{0}, b{0};      // its ends, world, m
  Real length = 0;      // m
  Vec3 down{0, -1, 0};  // unit, world
};

/// Appends points from `a` to `b`: a straight segment if the cable is taut, else a parabola of
/// `segments` segments. Its length is accurate to 0.1 %.
void add_curve(const HangingCable& cable, int segments, std::vector<Vec3>& to);

/// The same for a cable of the World; over guides it is drawn taut. Nothing if a body of the cable
/// is gone or a pose is not finite.
void add_cable(const PosedWorld& scene, const Cable& cable, int segments, std::vector<Vec3>& to);

/// The direction of gravity; -y if there is none.
Vec3 down_of(const World& world);

}  // namespace pantin::detail
