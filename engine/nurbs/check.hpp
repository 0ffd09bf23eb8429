#pragma once
/// Validation of curves and surfaces before any computation, and their creases, seams and points
/// without a normal, which contact has to know.
///
/// Internal (pantin::detail); installed because a World holds surfaces.
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/nurbs/spline.hpp"

namespace pantin::detail::nurbs {

/// All errors in a user's input, a line each, which begins with `name`; empty if there are none.
/// Requires degrees 1 to 25; knots finite, not decreasing, none inside more often than the degree,
/// ends at most degree + 1 times; finite points, as many as the knots need; weights above 0; closed
/// periodic directions.
std::vector<Error> errors_of(const Curve& curve, const std::string& name);
std::vector<Error> errors_of(const Surface& surface, const std::string& name);

enum class FlawKind {
  crease,           // the tangent plane jumps: no smooth contact across it
  jump_of_speed,    // first derivatives jump, the tangent plane does not
  jump_of_bend,     // second derivatives jump: integrators lose order
  singular_point,   // u x v vanishes: there is no normal
  degenerate_edge,  // a whole edge is one point
};

struct Flaw {
  FlawKind kind;
  Along way = Along::u;          // whose parameter `knot` is
  Real knot = 0;                 // creases and jumps: at this knot, or seam
  std::array<Real, 2> at{0, 0};  // u, v; of a curve t, 0
  Real size = 0;                 // rad, or the relative jump, or |u x v| / size^2
  std::string text;              // one line: surface, knot, parameters
};

/// Where a surface is not smooth, or has no normal. Jumps are relative; below 1e-9 they are
/// ignored.
std::vector<Flaw> flaws_of(const Surface& surface, const std::string& name);
std::vector<Flaw> flaws_of(const Curve& curve, const std::string& name);

}  // namespace pantin::detail::nurbs
