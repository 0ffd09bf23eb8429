#pragma once
/// A curve by the powers of its polynomial pieces, for evaluation at every step.
#include <array>
#include <vector>

#include "engine/nurbs/spline.hpp"

namespace pantin::detail::nurbs {

/// Immutable after it is made.
class CurvePieces {
 public:
  /// No curve.
  CurvePieces() = default;
  explicit CurvePieces(const Curve& curve);

  const Knots& knots() const { return curve_.knots; }
  /// Radius of a ball around it, m.
  Real size() const { return size_; }

  /// The point and its first two derivatives; the parameter within the domain. No heap.
  std::array<Vec3, 3> at(Real t) const;

  /// Arc length between two parameters, m; below 0 against the curve's direction. On a periodic
  /// curve the shorter way in the parameter. By quadrature, piece by piece, to rounding where they
  /// are close to one another. No heap.
  Real way(Real from, Real to) const;

 private:
  Real length(Real from, Real to) const;  // from <= to, within the domain

  Curve curve_;
  Real size_ = 0;
  std::vector<Real> starts_, middles_, inverse_;  // of pieces, and of their widths
  std::vector<int> spans_;
  // Of degree 3 at most: for each piece the coefficients of t^i, t from -1/2 to 1/2 over it.
  std::vector<Weighted> coefficients_;
};

}  // namespace pantin::detail::nurbs
