#include "engine/nurbs/curve_pieces.hpp"

#include <algorithm>
#include <cmath>

#include "engine/nurbs/pieces.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr int kFastDegree = 3;

// Gauss points and weights on [-1, 1], the half above 0.
constexpr Real kAt[4] = {0.18343464249564980494, 0.52553240991632898582, 0.79666647741362673959,
                         0.96028985649753623168};
constexpr Real kWeight[4] = {0.36268378337836198297, 0.31370664587788728734, 0.22238103445337447054,
                             0.10122853629037625915};
constexpr Real kOut = 0.77459666924148337704;  // of the rule of three points
// The longest part of a piece for one rule, and for a rule of three points.
constexpr Real kPart = 1.0 / 8, kShort = 1.0 / 128;

}  // namespace

CurvePieces::CurvePieces(const Curve& curve)
    : curve_(curve), size_(bounding_ball(curve.points).radius) {
  for (const int i : curve_.knots.spans()) {
    const Real low = curve_.knots[i], high = curve_.knots[i + 1];
    starts_.push_back(low), spans_.push_back(i);
    middles_.push_back((low + high) / 2), inverse_.push_back(1 / (high - low));
  }
  if (curve_.knots.degree > kFastDegree) return;
  for (Curve& piece : bezier_pieces(curve_)) {
    to_powers(piece.points);
    coefficients_.insert(coefficients_.end(), piece.points.begin(), piece.points.end());
  }
}

std::array<Vec3, 3> CurvePieces::at(Real t) const {
  const std::size_t i = piece_at(starts_, t);
  if (coefficients_.empty()) {
    const CurveDerivatives d = evaluate_on(curve_, spans_[i], t, 2);
    return {d[0], d[1], d[2]};
  }
  const auto p = static_cast<std::size_t>(curve_.knots.degree);
  const Weighted* c = &coefficients_[i * (p + 1)];
  const Real per = inverse_[i], x = (t - middles_[i]) * per;
  Weighted value = c[p], slope, half_bend;
  for (std::size_t k = p; k-- > 0;) {
    half_bend = slope + x * half_bend, slope = value + x * slope, value = c[k] + x * value;
  }
  const Real inverse = 1 / value.w;
  const Vec3 s = inverse * value.product();
  const Vec3 d = inverse * (slope.product() - slope.w * s);
  const Vec3 dd = inverse * (half_bend.product() - slope.w * d - half_bend.w * s);
  return {s, per * d, 2 * per * per * dd};
}

Real CurvePieces::length(Real from, Real to) const {
  Real sum = 0;
  while (from < to) {
    const std::size_t i = piece_at(starts_, from);
    Real end = std::min(to, from + kPart / inverse_[i]);
    if (i + 1 < starts_.size()) end = std::min(end, starts_[i + 1]);
    const Real middle = (from + end) / 2, half = (end - from) / 2;
    const auto speed = [&](Real t) { return glm::length(at(t)[1]); };
    if (end - from < kShort / inverse_[i])
      sum += half / 9 *
             (8 * speed(middle) + 5 * (speed(middle - half * kOut) + speed(middle + half * kOut)));
    else
      for (int k = 0; k < 4; ++k)
        sum += half * kWeight[k] * (speed(middle - half * kAt[k]) + speed(middle + half * kAt[k]));
    from = end;
  }
  return sum;
}

Real CurvePieces::way(Real from, Real to) const {
  const Range domain = curve_.knots.domain();
  const Real straight = std::abs(to - from);
  const bool is_round = curve_.knots.is_periodic && straight > domain.width() / 2;
  if (!is_round) return from <= to ? length(from, to) : -length(to, from);
  return from > to ? length(from, domain.high) + length(domain.low, to)
                   : -(length(to, domain.high) + length(domain.low, from));
}

}  // namespace pantin::detail::nurbs
