#pragma once
/// Bounding spheres of everything that is drawn.
#include <span>
#include <vector>

#include "engine/geometry/kinds.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

struct Ball {
  Vec3 centre{0};   // world, m
  Real radius = 0;  // m
};

/// Balls whose hull holds the shape of a body at `pose`: one for a sphere, two for a capsule, eight
/// points for a box and for what has many corners or none, else its corners. None for a shape that
/// lacks its surface.
void add_balls(const Shape& shape, const Pose& pose, std::vector<Ball>& to);

/// The flat box that a plane is drawn as: its upper side is the plane, as far as `size.x` from the
/// middle to each side.
Shape slab_of(const Shape& plane);

/// The pose of a body by its slot: from `poses`, or its own where `poses` is empty or too short.
inline const Pose& pose_of(const World& world, std::span<const Pose> poses, std::uint32_t slot) {
  return slot < poses.size() ? poses[slot] : world.bodies.values()[slot].pose;
}

/// The ends of a cable; false if a body is gone or a pose is not finite.
bool string_ends(const World& world, std::span<const Pose> poses, const Cable& string, Vec3& a,
                 Vec3& b);

/// Points from `a` to `b` along a cable of `length` (m): straight when taut, else a parabola of
/// that length which hangs along `down`. `segments` pieces when slack, one when taut; the points
/// are added to `to`. The length is met to 0.1 %.
void add_string_curve(Vec3 a, Vec3 b, Real length, Vec3 down, int segments, std::vector<Vec3>& to);

/// The way gravity points; -y where there is none.
Vec3 down_of(const World& world);

}  // namespace pantin::detail
