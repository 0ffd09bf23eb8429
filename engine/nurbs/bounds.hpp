#pragma once
/// Guaranteed bounds of a Bezier piece by its control points: extent, curvature, cone of normals.
#include "engine/nurbs/face.hpp"

namespace pantin::detail::nurbs {

/// The bounds of a piece, and the direction along which its normals turn more.
struct Bounded {
  Leaf leaf;
  Region region;
  Along turns_along = Along::u;
};
Bounded bounded(const Surface& piece);

/// A region that contains both.
Region joined(const Region& a, const Region& b);

}  // namespace pantin::detail::nurbs
