#pragma once
/// Bounds of a Bezier piece by its control points: where it lies, how it bends, where its normals
/// point. All hold for certain.
#include "engine/nurbs/face.hpp"

namespace pantin::detail::nurbs {

/// The bounds of a piece, and along which way its normals turn more.
struct Bounded {
  Leaf leaf;
  Region region;
  Along turns_along = Along::u;
};
Bounded bounded(const Surface& piece);

/// What holds for both.
Region joined(const Region& a, const Region& b);

}  // namespace pantin::detail::nurbs
