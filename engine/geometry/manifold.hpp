#pragma once
/// Contact manifold of two convex pieces in one frame.
#include <cstdint>
#include <vector>

#include "engine/geometry/convex.hpp"

namespace pantin::detail {

/// One contact point of two shapes that touch or may touch.
struct ContactPoint {
  Vec3 on_a{0}, on_b{0};      // m
  Vec3 normal{0, 1, 0};       // unit, from b to a
  Real gap = 0;               // m, normal . (on_a - on_b); below 0: overlap
  std::uint64_t feature = 0;  // identifies vertices, edges and triangles; equal in the next step
};

/// Destination of the contact points of two shapes: those whose gap is at most `margin` are
/// appended.
struct PointsOut {
  Real margin;  // m
  std::vector<ContactPoint>& points;
};

/// A triangle of a solid surface with its neighbours, which determine its valid contact normals.
struct Facing {
  Vec3 normal{0, 1, 0};
  Vec3 outward[3];  // in its plane, across edge 0-1, 1-2, 2-0
  Vec3 beyond[3];   // normal of the neighbour there
};

/// Whether `normal` is a valid contact normal of this triangle: within the Voronoi wedge at each
/// edge, so that bodies do not catch on internal edges.
bool allows(const Facing& facing, Vec3 normal);

/// Whether the edge is convex.
bool sticks_out(const Facing& facing, int edge);

/// Appends the points of a and b that are near enough: at most 8, always with the nearest one.
/// `facing` belongs to b where that is a triangle of a surface, else null.
void collide_convex(const Convex& a, const Convex& b, const Facing* facing, const PointsOut& out);

/// All vertices of a near enough to the plane normal . x = offset, a's radius included.
void collide_plane(const Convex& a, Vec3 normal, Real offset, const PointsOut& out);

/// Of points from `first` on with equal normals and positions within `near` (m), keeps the deepest.
void drop_duplicates(std::vector<ContactPoint>& points, std::size_t first, Real near);

/// Reduces the points from `first` on to `most`: the deepest, then those farthest from the ones
/// kept. Of points whose gaps differ by less than `same` (m) the first is chosen, so that the
/// choice persists.
void reduce_points(std::vector<ContactPoint>& points, std::size_t first, std::size_t most,
                   Real same = 0);

/// The same for different normals, as in a slot. Distances include those of the normals, times
/// `size` (m). Of points whose normals agree within 0.1 rad at most half are kept.
void reduce_directed(std::vector<ContactPoint>& points, std::size_t first, std::size_t most,
                     Real size);

}  // namespace pantin::detail
