#pragma once
/// Where two solids touch or are about to.
#include <vector>

#include "engine/geometry/kinds.hpp"
#include "engine/geometry/manifold.hpp"

namespace pantin {

/// Room of the narrow search, kept between calls.
struct NarrowRoom {
  ConvexRoom a, b;
  std::vector<std::uint32_t> triangles;
};

/// Appends the points of `a`, a convex shape placed at `at_a`, and of `b`, any shape at `at_b`,
/// whose gap is below `margin` (m). World axes; `Shape::local` is not looked at.
///
/// Of two convex shapes at most 8 points, among them always the nearest; of a plane every corner
/// that is near enough; of a mesh or a height field at most 16. Normals are directions that part
/// the shapes: as long as every gap stays open along its normal, the shapes do not meet. Within a
/// mesh or below a height field the way out is along the nearest face. Features keep their numbers
/// as long as the same corners and edges face each other.
void touch(const Shape& a, const Pose& at_a, const Shape& b, const Pose& at_b, Real margin,
           NarrowRoom& room, std::vector<TouchPoint>& out);

}  // namespace pantin
