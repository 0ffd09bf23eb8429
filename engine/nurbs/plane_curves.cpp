#include "engine/nurbs/plane_curves.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/nurbs/check.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr Real kMeets = 1e-6, kSmooth = 1e-6;
constexpr int kMostChords = 64;

Real cross(Vec3 a, Vec3 b) { return a.x * b.y - a.y * b.x; }

std::string shown(Real x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}

/// A corner rounded by an arc.
struct Corner {
  Vec3 at{0}, in{0}, out{0};  // the corner; unit, of the sides before and after
  Real turn = 0;              // rad
  Real cut = 0;               // m, of each side
};

/// A chain of lines and arcs, of degree 2.
class Pen2 {
 public:
  explicit Pen2(Vec3 from) {
    made_.knots.degree = 2, made_.knots.values = {0, 0, 0};
    made_.points.emplace_back(from, 1);
  }
  void line(Vec3 to) {
    const Vec3 from = made_.points.back().point();
    const Real length = glm::distance(from, to);
    if (length > 0) piece((from + to) / 2.0, 1, to, length);
  }
  /// Adds an arc to `to`; the tangents at both its ends meet in `by`.
  void arc(Vec3 by, Real half_turn, Vec3 to) {
    const Vec3 from = made_.points.back().point();
    piece(by, std::cos(half_turn), to, glm::distance(from, to));
  }
  Curve closed() {
    made_.points.back() = made_.points.front();
    made_.knots.values.push_back(made_.knots.values.back());
    made_.knots.is_periodic = true;
    return std::move(made_);
  }

 private:
  void piece(Vec3 by, Real weight, Vec3 to, Real width) {
    std::vector<Real>& knots = made_.knots.values;
    const Real end = knots.back() + width;
    knots.insert(knots.end(), 2, end);
    made_.points.emplace_back(by, weight), made_.points.emplace_back(to, 1);
  }
  Curve made_;
};

}  // namespace

Result<Curve> rounded_polygon(std::span<const Vec3> points, Real radius) {
  const std::size_t n = points.size();
  if (n < 3) return Error{"found " + std::to_string(n) + " points, expected at least 3"};
  std::vector<Corner> corners(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 before = points[(i + n - 1) % n], at = points[i], after = points[(i + 1) % n];
    if (at == after)
      return Error{"found point " + std::to_string(i) + " twice, expected points apart"};
    Corner& c = corners[i];
    c.at = at, c.in = glm::normalize(at - before), c.out = glm::normalize(after - at);
    c.turn = std::atan2(cross(c.in, c.out), glm::dot(c.in, c.out));
    c.cut = radius * std::abs(std::tan(c.turn / 2));
    if (!(std::abs(c.turn) < kPi - 1e-6))
      return Error{"found point " + std::to_string(i) + " where the outline runs back on itself"};
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Corner &c = corners[i], &next = corners[(i + 1) % n];
    const Real side = glm::distance(c.at, next.at);
    if (c.cut + next.cut > side * (1 + 1e-12))
      return Error{"found a side of " + shown(side) + " m after point " + std::to_string(i) +
                   ", expected at least " + shown(c.cut + next.cut) + " m for corners rounded by " +
                   shown(radius) + " m"};
  }
  const Corner& first = corners[0];
  Pen2 pen(first.at + first.cut * first.out);
  for (std::size_t i = 1; i <= n; ++i) {
    const Corner& c = corners[i % n];
    pen.line(c.at - c.cut * c.in);
    if (!(c.cut > 0)) continue;
    // Two arcs, if one would turn too far.
    const Vec3 end = c.at + c.cut * c.out;
    if (std::abs(c.turn) < 2) {
      pen.arc(c.at, c.turn / 2, end);
      continue;
    }
    const Real side = c.turn > 0 ? 1 : -1;
    const Vec3 centre = c.at - c.cut * c.in + side * radius * Vec3(-c.in.y, c.in.x, 0);
    const Vec3 out = glm::normalize(c.at - centre), middle = centre + radius * out;
    const Real reach = radius * std::tan(std::abs(c.turn) / 4);
    pen.arc(c.at - c.cut * c.in + reach * c.in, c.turn / 4, middle);
    pen.arc(end - reach * c.out, c.turn / 4, end);
  }
  return pen.closed();
}

Curve reversed(const Curve& curve) {
  Curve made = curve;
  std::reverse(made.points.begin(), made.points.end());
  const Real ends = curve.knots.low() + curve.knots.high();
  for (Real& knot : made.knots.values) knot = ends - knot;
  std::reverse(made.knots.values.begin(), made.knots.values.end());
  return made;
}

Curve closed_up(const Curve& curve) {
  if (curve.knots.is_periodic) return curve;
  const Range domain = curve.knots.domain();
  const Real size = bounding_ball(curve.points).radius;
  const CurveDerivatives from = evaluate(curve, domain.low, 1),
                         to = evaluate(curve, domain.high, 1);
  const Real turn = glm::length(glm::cross(from[1], to[1]));
  if (glm::distance(from[0], to[0]) > 1e-9 * size) return curve;
  if (!(turn < kSmooth * glm::length(from[1]) * glm::length(to[1])) ||
      !(glm::dot(from[1], to[1]) > 0))
    return curve;
  Curve made = part_of(curve, domain);
  made.points.back() = made.points.front(), made.knots.is_periodic = true;
  return made;
}

namespace {

Real gap_between(Vec3 from, Vec3 to) { return glm::distance(from, to); }
Vec3 start_of(const Curve& c) { return evaluate(c, c.knots.low(), 0)[0]; }
Vec3 end_of(const Curve& c) { return evaluate(c, c.knots.high(), 0)[0]; }

/// Reverses curves that run the other way, so that they meet their neighbours.
std::vector<Curve> head_to_tail(std::span<const Curve> curves) {
  std::vector<Curve> all(curves.begin(), curves.end());
  for (std::size_t i = 1; i < all.size(); ++i) {
    const Vec3 start = start_of(all[i]), end = end_of(all[i]);
    const auto nearest = [&](Vec3 p) {
      return std::min(gap_between(p, start), gap_between(p, end));
    };
    if (i == 1 && nearest(start_of(all[0])) < nearest(end_of(all[0]))) all[0] = reversed(all[0]);
    const Vec3 before = end_of(all[i - 1]);
    if (gap_between(before, end) < gap_between(before, start)) all[i] = reversed(all[i]);
  }
  return all;
}

}  // namespace

Result<Curve> joined(std::span<const Curve> given) {
  if (given.empty()) return Error{"found no curves, expected at least one"};
  const std::vector<Curve> curves = head_to_tail(given);
  int degree = 1;
  for (const Curve& c : curves) degree = std::max(degree, c.knots.degree);
  Curve made;
  made.knots.degree = degree;
  Real speed = 0, size = 0;  // at the end of the last one
  for (std::size_t i = 0; i < curves.size(); ++i) {
    Curve next = part_of(curves[i], curves[i].knots.domain());
    next.knots.is_periodic = false;
    while (next.knots.degree < degree) next = elevated(next);
    size = std::max(size, bounding_ball(next.points).radius);
    const Range domain = next.knots.domain();
    const Real starts = glm::length(evaluate(next, domain.low, 1)[1]);
    const Real ends = glm::length(evaluate(next, domain.high, 1)[1]);
    if (!(starts > 0) || !(ends > 0))
      return Error{"found curve " + std::to_string(i) + " without a tangent at an end"};
    if (i == 0) {
      made.knots.values = next.knots.values, made.points = next.points, speed = ends;
      continue;
    }
    const Weighted last = made.points.back();
    const Vec3 gap = next.points.front().point() - last.point();
    if (glm::length(gap) > kMeets * size)
      return Error{"found curve " + std::to_string(i) + " to begin " + shown(glm::length(gap)) +
                   " m from the end of the one before, expected it to begin there"};
    // Scale the parameter to keep the speed, and the weights to continue from the last one's.
    const Real stretch = starts / speed, weight = last.w / next.points.front().w;
    const Real shift = made.knots.values.back();
    made.knots.values.pop_back();
    for (std::size_t k = static_cast<std::size_t>(degree) + 1; k < next.knots.values.size(); ++k)
      made.knots.values.push_back(shift + stretch * (next.knots.values[k] - domain.low));
    for (std::size_t k = 1; k < next.points.size(); ++k)
      made.points.push_back(weight * next.points[k]);
    speed = ends / stretch;
  }
  const Weighted first = made.points.front();
  Weighted& last = made.points.back();
  if (curves.size() > 1 && glm::distance(first.point(), last.point()) <= kMeets * size) {
    last = Weighted(first.point(), last.w);
    made.knots.is_periodic = std::abs(first.w / last.w - 1) < 1e-12;
    if (made.knots.is_periodic) last = first;
  }
  return made;
}

CurvePoints points_along(const Curve& curve, Real chord) {
  CurvePoints along;
  const Knots& knots = curve.knots;
  for (const int span : knots.spans()) {
    const Real low = knots[span], width = knots[span + 1] - low;
    // With n chords the sagitta is bend / (8 n^2).
    Real bend = 0;
    for (const Real x : {0.1, 0.5, 0.9}) {
      const CurveDerivatives d = evaluate_on(curve, span, low + x * width, 2);
      const Real speed = glm::length(d[1]);
      const Vec3 across = speed > 0 ? d[2] - glm::dot(d[2], d[1]) / (speed * speed) * d[1] : d[2];
      bend = std::max(bend, glm::length(across) * width * width);
    }
    const Real wanted = std::ceil(std::sqrt(bend / (8 * chord)));
    const int parts = std::clamp(wanted < kMostChords ? static_cast<int>(wanted) : kMostChords,
                                 knots.degree > 1 ? 2 : 1, kMostChords);
    for (int i = 0; i < parts; ++i) {
      const Real t = low + width * i / parts;
      along.at.push_back(t), along.points.push_back(evaluate_on(curve, span, t, 0)[0]);
    }
  }
  if (knots.is_periodic) return along;
  along.at.push_back(knots.high());
  along.points.push_back(evaluate(curve, knots.high(), 0)[0]);
  return along;
}

Real area_around(const Curve& curve) {
  const std::vector<Vec3> p = points_along(curve, 1e-3 * bounding_ball(curve.points).radius).points;
  Real twice = 0;
  for (std::size_t i = 0; i < p.size(); ++i)
    twice += cross(p[i] - p[0], p[(i + 1) % p.size()] - p[0]);
  return twice / 2;
}

namespace {

/// A tree of boxes over ranges of chords of a plane curve, halved down to one chord.
class ChordBoxes {
 public:
  /// Chord i runs from points[i] to the next one, cyclically.
  ChordBoxes(std::span<const Vec3> points, std::size_t chords) : chords_(chords) {
    while (leaves_ < chords) leaves_ *= 2;
    boxes_.resize(2 * leaves_);
    for (std::size_t i = 0; i < chords; ++i) {
      const Vec3 a = points[i], b = points[(i + 1) % points.size()];
      boxes_[leaves_ + i] = {glm::min(a, b), glm::max(a, b)};
    }
    for (std::size_t i = leaves_; i-- > 1;)
      boxes_[i] = {glm::min(boxes_[2 * i].low, boxes_[2 * i + 1].low),
                   glm::max(boxes_[2 * i].high, boxes_[2 * i + 1].high)};
  }

  /// The first chord from `from` on whose box overlaps that of chord i and for which `crosses` is
  /// true; the number of chords if there is none.
  template <class Crosses>
  std::size_t first(std::size_t i, std::size_t from, const Crosses& crosses) const {
    return first_in({1, 0, leaves_}, {i, from}, crosses);
  }

 private:
  struct Box {
    Vec3 low{1e300}, high{-1e300};
  };
  struct Branch {
    std::size_t node, begin, count;
  };
  struct Asked {
    std::size_t chord, from;
  };
  bool meets(const Box& a, const Box& b) const {
    return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y;
  }
  template <class Crosses>
  std::size_t first_in(const Branch& in, const Asked& of, const Crosses& crosses) const {
    if (in.begin + in.count <= of.from || in.begin >= chords_) return chords_;
    if (!meets(boxes_[in.node], boxes_[leaves_ + of.chord])) return chords_;
    if (in.count == 1) return crosses(in.begin) ? in.begin : chords_;
    const std::size_t half = in.count / 2;
    const std::size_t found = first_in({2 * in.node, in.begin, half}, of, crosses);
    return found < chords_ ? found
                           : first_in({2 * in.node + 1, in.begin + half, half}, of, crosses);
  }

  std::size_t chords_, leaves_ = 1;
  std::vector<Box> boxes_;
};

}  // namespace

std::optional<std::array<Real, 2>> crossing_of(const Curve& curve) {
  const CurvePoints along = points_along(curve, 1e-3 * bounding_ball(curve.points).radius);
  const std::vector<Vec3>& p = along.points;
  const std::size_t n = p.size();
  const std::size_t sides = curve.knots.is_periodic ? n : n - 1;
  const ChordBoxes boxes(p, sides);
  for (std::size_t i = 0; i < sides; ++i) {
    const Vec3 a = p[i], b = p[(i + 1) % n];
    const auto sides_of = [&](std::size_t k) {
      const Vec3 c = p[k], d = p[(k + 1) % n];
      return std::array{cross(b - a, c - a), cross(b - a, d - a), cross(d - c, a - c),
                        cross(d - c, b - c)};
    };
    const auto crosses = [&](std::size_t k) {
      if (i == 0 && k + 1 == n && curve.knots.is_periodic) return false;
      const auto [of_c, of_d, of_a, of_b] = sides_of(k);
      return !(of_c * of_d > 0 || of_a * of_b > 0);
    };
    const std::size_t k = boxes.first(i, i + 2, crosses);
    if (k >= sides) continue;
    const auto [of_c, of_d, of_a, of_b] = sides_of(k);
    const auto between = [&](std::size_t side, Real before, Real after) {
      const Real end = side + 1 < n ? along.at[side + 1] : curve.knots.high();
      const Real part = before != after ? before / (before - after) : 0;
      return along.at[side] + part * (end - along.at[side]);
    };
    return std::array{between(i, of_a, of_b), between(k, of_c, of_d)};
  }
  return std::nullopt;
}

}  // namespace pantin::detail::nurbs
