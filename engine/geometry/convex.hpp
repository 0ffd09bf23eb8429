#pragma once
/// Convex pieces for collision detection, all in one frame: a polyhedral core and a radius around
/// it.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/math.hpp"
#include "engine/geometry/aabb_tree.hpp"
#include "engine/geometry/shape.hpp"
#include "engine/geometry/surface.hpp"

namespace pantin::detail {

/// A sphere has one point, a capsule two and an edge; only boxes, hulls and triangles have faces.
struct Convex {
  std::span<const Vec3> points;
  std::span<const Face> faces;
  std::span<const std::uint32_t> corners;               // of the faces
  std::span<const std::array<std::uint32_t, 2>> edges;  // points
  std::span<const std::array<std::uint32_t, 2>> sides;  // faces left and right of each edge
  Real radius = 0;                                      // m
  Vec3 centre{0};                                       // a point inside the core
  Real size = 0;                                        // m, about half of its widest extent
  // A smooth piece has no points but the support function of its kind. Its flat faces are known as
  // planes only.
  const Shape* smooth = nullptr;
  Mat3 rotation{1};  // of a smooth piece, whose origin is at `origin`
  Vec3 origin{0};

  /// Support point: the point of the core farthest along `direction`; of several the first.
  std::uint32_t farthest(Vec3 direction) const {
    std::uint32_t best = 0;
    Real most = glm::dot(points[0], direction);
    for (std::uint32_t i = 1; i < points.size(); ++i)
      if (const Real way = glm::dot(points[i], direction); way > most) most = way, best = i;
    return best;
  }
  /// The farthest point of the core itself, of smooth pieces too.
  Vec3 extreme(Vec3 direction) const {
    return smooth ? smooth_extreme(direction) : points[farthest(direction)];
  }
  Vec3 smooth_extreme(Vec3 direction) const;
};

/// Scratch memory for the transformed points and faces of one piece.
struct ConvexScratch {
  std::vector<Vec3> points;
  std::vector<Face> faces;
};

/// A shape at a pose; `Shape::local` is ignored.
struct PlacedShape {
  const Shape& shape;
  const Pose& at;
};

/// A convex shape at the pose `at`; valid as long as `scratch` and the shape are unchanged.
Convex convex_piece(const Shape& shape, const Pose& at, ConvexScratch& scratch);

/// Bounds of a shape at `at`; of a hull, mesh or height field those of its transformed box. A plane
/// is unbounded.
Aabb bounds_of(const Shape& shape, const Pose& at);

/// Closest points of the cores of two pieces.
struct Nearest {
  Vec3 on_a{0}, on_b{0};
  Vec3 normal{0};     // unit, from b to a
  Real distance = 0;  // of the cores, m
  enum class State : std::uint8_t {
    apart,    // as above
    beyond,   // farther apart than the limit; `normal` separates them, the rest is undefined
    overlap,  // or too close for a well-defined direction
  } state = State::apart;
};

/// Distance of two cores with points by the GJK algorithm, stopped when it is certain to exceed
/// `limit`. [Gilbert, Johnson & Keerthi 1988]
Nearest nearest(const Convex& a, const Convex& b, Real limit);

}  // namespace pantin::detail
