#pragma once
/// Sections of shapes with a plane of constant z.
#include <vector>

#include "engine/geometry/shape.hpp"
#include "engine/solvers/planar/plane.hpp"

namespace pantin::detail::planar {

/// Appends the outlines of a shape of a body with pose `body`, in world axes about the body's mass
/// centre, whose z is `height`. Each shape is cut through its own centre, so that a wheel beside
/// its bearing keeps its radius. Shapes without a section append nothing.
void append_section(const Shape& shape, const Pose& body, Plane& out);

}  // namespace pantin::detail::planar
