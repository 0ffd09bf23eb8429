#pragma once
/// The points of contact of two convex pieces in one frame.
#include <cstdint>
#include <vector>

#include "engine/geometry/convex.hpp"

namespace pantin {

/// One point where two solids touch or are about to.
struct TouchPoint {
  Vec3 on_a{0}, on_b{0};      // m
  Vec3 normal{0, 1, 0};       // unit, from b to a
  Real gap = 0;               // m, normal . (on_a - on_b); below 0: overlap
  std::uint64_t feature = 0;  // the corners, edges and triangles concerned: the same next step
};

/// Triangle of a surface, solid below: what lies beyond its edges says which normals are its own.
struct Facing {
  Vec3 normal{0, 1, 0};
  Vec3 outward[3];  // in its plane, across edge 0-1, 1-2, 2-0
  Vec3 beyond[3];   // normal of the neighbour there
};

/// Whether a body may be pushed from this triangle along `normal`: from within the wedge between
/// the faces at each edge, so that nothing catches on an edge that does not stick out.
bool allows(const Facing& facing, Vec3 normal);

/// Whether the surface sticks out at the edge.
bool sticks_out(const Facing& facing, int edge);

/// Appends the points of a and b that are nearer than `margin`: at most 8, always with the nearest
/// one. `facing` belongs to b where that is a triangle of a surface, else null.
void touch_convex(const Convex& a, const Convex& b, Real margin, const Facing* facing,
                  std::vector<TouchPoint>& out);

/// The points of a's side towards `normal` that are nearer than `margin` to the plane
/// normal . x = offset, with a's radius: all of its corners.
void touch_plane(const Convex& a, Vec3 normal, Real offset, Real margin,
                 std::vector<TouchPoint>& out);

/// Of points from `first` on with the same normal and, within `near` (m), the same place on either
/// side, keeps the deepest.
void drop_doubles(std::vector<TouchPoint>& points, std::size_t first, Real near);

/// Keeps `most` of the points from `first` on: the deepest, then those that lie far from the kept.
void spread_out(std::vector<TouchPoint>& points, std::size_t first, std::size_t most);

}  // namespace pantin
