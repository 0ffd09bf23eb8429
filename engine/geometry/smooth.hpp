#pragma once
/// Convex pieces known by their support functions alone: distance, overlap, contact points and rays
/// for kinds without corners.
#include <optional>
#include <span>
#include <vector>

#include "engine/geometry/kinds.hpp"
#include "engine/geometry/manifold.hpp"

namespace pantin::detail {

/// Distance of two cores, negative where they overlap.
struct Separation {
  Vec3 on_a{0}, on_b{0};   // the nearest, or deepest, points
  Vec3 normal{0, 1, 0};    // unit, from b to a
  Real distance = 0;       // m, below 0: overlap
  bool is_beyond = false;  // farther apart than the limit: only the normal is known
};

/// The separation of two cores along the normal where it is largest. Distances by GJK, deep
/// overlaps by EPA (expanding polytope). Pieces that are close or overlap are moved apart for the
/// distance query. The result always separates the pieces; it may be a local optimum rather than
/// the least. [Gilbert, Johnson & Keerthi 1988; Bergen 2001]
Separation separate(const Convex& a, const Convex& b, Real limit);

/// Points of a core, and their numbers where these differ from the indices.
struct Corners {
  std::span<const Vec3> points;
  std::span<const std::uint32_t> numbers = {};

  std::uint32_t number(std::uint32_t i) const { return numbers.empty() ? i : numbers[i]; }
};

/// The points of a core; of a smooth one those that may come within `margin` (m) of a plane that it
/// faces along `direction`: its patch there, and the support point.
Corners corners_towards(const Convex& c, Vec3 direction, Real margin, Patch& scratch);

/// As collide_convex(), where one of the pieces or both are smooth.
void touch_smooth(const Convex& a, const Convex& b, const Facing* facing, const PointsOut& out);

/// As cast() and closest() of kinds.hpp, for any convex piece.
std::optional<RayEntry> cast_at(const Convex& piece, Vec3 from, Vec3 way, Real limit);
std::optional<SurfacePoint> closest_of(const Convex& piece, Vec3 p, Real limit);

}  // namespace pantin::detail
