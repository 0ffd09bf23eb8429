#pragma once
/// Sections of shapes: what a plane of constant z cuts out of them.
#include <vector>

#include "engine/geometry/shape.hpp"
#include "engine/solvers/planar/plane.hpp"

namespace pantin::detail::planar {

/// Appends the outlines of a shape of a body that stands at `rotation`, in axes of the world about
/// the body's mass centre, whose z is `height`. Each shape is cut through its own middle, so that a
/// wheel beside its bearing keeps its radius. Of those without a section: nothing.
void append_section(const Shape& shape, const Pose& body, Plane& out);

}  // namespace pantin::detail::planar
