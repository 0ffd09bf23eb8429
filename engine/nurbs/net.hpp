#pragma once
/// Control points of splines that change: their share in a point of the spline, and the spline with
/// other ones.
///
/// Internal (pantin::detail).
#include <vector>

#include "engine/nurbs/spline.hpp"

namespace pantin::detail::nurbs {

/// A control point by its number: of a curve in its list, of a surface i * v.count() + j. Periodic
/// splines repeat control points: all images change together.
std::vector<std::uint32_t> images_of(const Curve& curve, std::uint32_t point);
std::vector<std::uint32_t> images_of(const Surface& surface, std::uint32_t point);

/// The rational basis function of a control point with its images at a parameter, the derivative of
/// the spline's point by the control point. The derivative by its weight w is share (P - S) / w.
/// [Piegl & Tiller 1997, Eqs. 4.2, 4.12, 11.2]
Real share_of(const Curve& curve, std::span<const std::uint32_t> images, Real t);
Real share_of(const Surface& surface, std::span<const std::uint32_t> images,
              std::array<Real, 2> at);

/// The spline with another control point and weight.
template <class Spline>
Spline with_point(const Spline& spline, std::span<const std::uint32_t> images, Weighted to) {
  Spline made = spline;
  for (const std::uint32_t i : images) made.points[i] = to;
  return made;
}

}  // namespace pantin::detail::nurbs
