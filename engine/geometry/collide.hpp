#pragma once
/// Narrow phase: contact points of two shapes.
#include <vector>

#include "engine/geometry/kinds.hpp"
#include "engine/geometry/manifold.hpp"
#include "engine/geometry/skin_model.hpp"

namespace pantin::detail {

/// Scratch memory of the narrow phase, kept allocated between calls.
struct NarrowPhaseScratch {
  ConvexScratch a, b;
  std::vector<std::uint32_t> triangles;
  SkinScratch skin;
};

/// Appends the points of `a`, a convex shape or a skin, and of `b`, any shape, in world axes.
///
/// At most 8 points for two convex shapes, always including the nearest; every vertex near enough
/// for a plane; at most 16 for a mesh or a height field; at most 8 for a skin that is not convex,
/// 16 for two. Normals separate the shapes: as long as every gap stays open along its normal, the
/// shapes do not overlap. Inside a mesh or below a height field the normal is that of the nearest
/// face. Feature numbers persist while the same vertices and edges face each other.
void collide(const PlacedShape& a, const PlacedShape& b, NarrowPhaseScratch& scratch,
             const PointsOut& out);

}  // namespace pantin::detail
