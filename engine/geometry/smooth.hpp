#pragma once
/// Convex pieces known by their support functions alone: distance, overlap, contact points and rays
/// for kinds that give no corners.
#include <optional>
#include <span>
#include <vector>

#include "engine/geometry/kinds.hpp"
#include "engine/geometry/manifold.hpp"

namespace pantin::detail {

/// How far two cores are apart, overlapping ones too.
struct Separation {
  Vec3 on_a{0}, on_b{0};   // the points that are nearest, or deepest
  Vec3 normal{0, 1, 0};    // unit, from b to a
  Real distance = 0;       // m, below 0: overlap
  bool is_beyond = false;  // farther apart than the limit: only the normal is known
};

/// The separation of two cores, with the normal along which it is largest. Distances by Gilbert,
/// Johnson and Keerthi's walk, deep overlaps by expanding a polytope towards the nearest side, and
/// where the pieces are close or overlap, both from some way apart. The way out that is given
/// suffices always; of several, among which a small turn does not lead from one to the other, it
/// may be another than the least. [Gilbert, Johnson & Keerthi 1988; Bergen 2001]
Separation separate(const Convex& a, const Convex& b, Real limit);

/// Points of a core, and their numbers where those are not their places in the list.
struct Corners {
  std::span<const Vec3> points;
  std::span<const std::uint32_t> numbers = {};

  std::uint32_t number(std::uint32_t i) const { return numbers.empty() ? i : numbers[i]; }
};

/// The points of a core; of a smooth one those that may come within `margin` (m) of a plane that it
/// faces along `direction`: what it turns there, and the farthest.
Corners corners_towards(const Convex& c, Vec3 direction, Real margin, Patch& scratch);

/// As collide_convex(), where one of the pieces or both are smooth.
void touch_smooth(const Convex& a, const Convex& b, const Facing* facing, const PointsOut& out);

/// As cast() and closest() of kinds.hpp, for any convex piece.
std::optional<RayEntry> cast_at(const Convex& piece, Vec3 from, Vec3 way, Real limit);
std::optional<SurfacePoint> closest_of(const Convex& piece, Vec3 p, Real limit);

}  // namespace pantin::detail
