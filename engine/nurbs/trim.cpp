#include "engine/nurbs/trim.hpp"

#include <algorithm>
#include <cmath>

namespace pantin::detail::nurbs {
namespace {

constexpr Real kOn = 1e-10;    // of the domain: places this near to a loop are on it
constexpr int kDeepest = 40;   // cuts of a part, each of which quarters its distance from the chord
constexpr int kMostCuts = 24;  // of a part of a loop, where it crosses the knots of its face
constexpr Real kAgree = 1e-13;  // of the face's size squared: halves of a part that add up
constexpr Real kNear = 1e-9;    // relative: parts are not searched for a gain below this

/// Gauss-Legendre's rule of eight points on [-1, 1]: half of it.
constexpr Real kGauss[4][2] = {{0.18343464249564980, 0.36268378337836198},
                               {0.52553240991632899, 0.31370664587788729},
                               {0.79666647741362674, 0.22238103445337447},
                               {0.96028985649753623, 0.10122853629037626}};

template <class At>
Real integral(Range range, const At& at) {
  Real sum = 0;
  for (const auto& [x, weight] : kGauss)
    for (const Real sign : {-1.0, 1.0})
      sum += weight * at(range.middle() + sign * x * range.width() / 2);
  return sum * range.width() / 2;
}

/// The same, halved where the halves do not add up to the whole.
template <class At>
Real adaptive_integral(Range range, Real tolerance, const At& at, int depth = 0) {
  const Range halves[2] = {{range.low, range.middle()}, {range.middle(), range.high}};
  const Real whole = integral(range, at);
  const Real sum = integral(halves[0], at) + integral(halves[1], at);
  if (std::abs(sum - whole) <= tolerance || depth == kMostCuts) return sum;
  return adaptive_integral(halves[0], tolerance, at, depth + 1) +
         adaptive_integral(halves[1], tolerance, at, depth + 1);
}

/// How often a chord winds around p, as crossings of the ray from p along x.
int crossing(Vec3 a, Vec3 b, Vec3 p) {
  const bool is_up = a.y <= p.y && b.y > p.y, is_down = b.y <= p.y && a.y > p.y;
  if (!is_up && !is_down) return 0;
  const Real side = (b.x - a.x) * (p.y - a.y) - (p.x - a.x) * (b.y - a.y);
  return is_up ? (side > 0 ? 1 : 0) : (side < 0 ? -1 : 0);
}

Real distance_from_chord(Vec3 a, Vec3 b, Vec3 p) {
  const Vec3 way = b - a;
  const Real square = glm::dot(way, way);
  const Real share = square > 0 ? std::clamp(glm::dot(p - a, way) / square, 0.0, 1.0) : 0;
  return glm::distance(a + share * way, p);
}

/// A part of a curve between two ends, and a bound of its distance from its chord.
struct Arc {
  Range t;
  std::array<Vec3, 2> ends;
  Real sag;
};

/// One part of a loop against a place.
struct PartTest {
  const Curve& curve;
  int span;
  Vec3 p;
  bool is_on = false;  // whether p is on the curve

  int winding(const Arc& arc, int depth = 0) {
    const auto& [t, ends, sag] = arc;
    const Real apart = distance_from_chord(ends[0], ends[1], p);
    if (apart > sag + kOn) return crossing(ends[0], ends[1], p);
    if (sag <= kOn || depth == kDeepest) {
      is_on = true;
      return 0;
    }
    const Vec3 middle = evaluate_on(curve, span, t.middle(), 0)[0];
    const int first = winding({{t.low, t.middle()}, {ends[0], middle}, sag / 4}, depth + 1);
    if (is_on) return 0;
    return first + winding({{t.middle(), t.high}, {middle, ends[1]}, sag / 4}, depth + 1);
  }
};

Real sag_of(const Wire::Leaf& leaf) { return leaf.second / 2; }

/// Upper bounds of |S_u| and |S_v| over the cells of a face that a box of parameters meets.
std::array<Real, 2> speeds_in(const Face& face, Range u, Range v) {
  std::array<Real, 2> most{0, 0};
  for (const Leaf& cell : face.leaves()) {
    if (cell.u.high < u.low || cell.u.low > u.high || cell.v.high < v.low || cell.v.low > v.high)
      continue;
    most[0] = std::max(most[0], 2 * cell.first[0] / cell.u.width());
    most[1] = std::max(most[1], 2 * cell.first[1] / cell.v.width());
  }
  return most;
}

}  // namespace

Trim::Trim(const Face& face) {
  const Range us = face.u().domain(), vs = face.v().domain();
  corner_ = {us.low, vs.low, 0}, width_ = {us.width(), vs.width(), 1};
  const Affine to_fractions{Mat3(1 / width_.x, 0, 0, 0, 1 / width_.y, 0, 0, 0, 1),
                            -corner_ / width_};
  for (const Curve& loop : face.surface().trims) {
    const Wire& wire = loops_.emplace_back(transformed(loop, to_fractions));
    std::vector<Vec3>& corners = corners_.emplace_back();
    for (const Wire::Leaf& leaf : wire.leaves())
      corners.push_back(evaluate(wire.curve(), leaf.t.low, 0)[0]);
    corners.push_back(corners.front());
    bands_.emplace_back(wire, corners);
    for (std::size_t i = 0; i < wire.leaves().size(); ++i) {
      const OnTrim middle{loops_.size() - 1, i, wire.leaves()[i].t.middle()};
      const Vec3 at = this->at(middle)[0];
      const Real u = us.clamped(at.x), v = vs.clamped(at.y);
      const Real wide = wire.leaves()[i].radius, wide_u = wide * width_.x, wide_v = wide * width_.y;
      const auto speed = speeds_in(face, {u - wide_u, u + wide_u}, {v - wide_v, v + wide_v});
      parts_.push_back({middle.loop, i, face.at(u, v).s, speed[0] * wide_u + speed[1] * wide_v});
    }
  }
}

Trim::Bands::Bands(const Wire& loop, const std::vector<Vec3>& corners) {
  const auto heights = [&](std::size_t i) {
    const Real sag = sag_of(loop.leaves()[i]) + kOn;
    return Range{std::min(corners[i].y, corners[i + 1].y) - sag,
                 std::max(corners[i].y, corners[i + 1].y) + sag};
  };
  Real sum = 0;
  low_ = 1e300, high_ = -1e300;
  for (std::size_t i = 0; i < loop.leaves().size(); ++i) {
    const Range y = heights(i);
    sum += y.width(), low_ = std::min(low_, y.low), high_ = std::max(high_, y.high);
  }
  // Few enough that all lists together have some five entries a part.
  const Real parts = static_cast<Real>(loop.leaves().size());
  const Real bands = std::clamp(std::floor(4 * parts * (high_ - low_) / sum), 1.0, parts);
  rate_ = bands / (high_ - low_);
  std::vector<std::vector<std::uint32_t>> lists(static_cast<std::size_t>(bands));
  begin_.assign(lists.size() + 1, 0);
  for (std::size_t i = 0; i < loop.leaves().size(); ++i) {
    const Range y = heights(i);
    const std::size_t last = band_of(y.high);
    for (std::size_t k = band_of(y.low); k <= last; ++k)
      lists[k].push_back(static_cast<std::uint32_t>(i));
  }
  for (std::size_t k = 0; k < lists.size(); ++k) {
    parts_.insert(parts_.end(), lists[k].begin(), lists[k].end());
    begin_[k + 1] = static_cast<std::uint32_t>(parts_.size());
  }
}

std::size_t Trim::Bands::band_of(Real y) const {
  const Real last = static_cast<Real>(begin_.size() - 2);
  return static_cast<std::size_t>(std::clamp((y - low_) * rate_, 0.0, last));
}

std::span<const std::uint32_t> Trim::Bands::between(Real low, Real high) const {
  if (!(high >= low_ && low <= high_)) return {};
  const std::uint32_t first = begin_[band_of(low)];
  return std::span(parts_).subspan(first, begin_[band_of(high) + 1] - first);
}

bool Trim::surrounds(std::size_t number, Vec3 p, bool& is_on) const {
  int winding = 0;
  const Wire& loop = loops_[number];
  const std::vector<Vec3>& corners = corners_[number];
  for (const std::uint32_t i : bands_[number].between(p.y, p.y)) {
    const Wire::Leaf& leaf = loop.leaves()[i];
    const Vec3 &a = corners[i], &b = corners[i + 1];
    const Real sag = sag_of(leaf);
    // The ray from p along x does not meet it.
    if (std::max(a.x, b.x) + sag + kOn < p.x || std::max(a.y, b.y) + sag + kOn < p.y ||
        std::min(a.y, b.y) - sag - kOn > p.y)
      continue;
    if (std::min(a.x, b.x) - sag - kOn > p.x) {  // so it is farther from its chord than its curve
      winding += crossing(a, b, p);
      continue;
    }
    PartTest test{loop.curve(), leaf.span, p};
    winding += test.winding({leaf.t, {a, b}, sag});
    if (test.is_on) return is_on = true;
  }
  return winding != 0;
}

bool Trim::holds(Real u, Real v) const {
  const Vec3 p = fractions(u, v);
  bool is_within = false, is_on = false;
  for (std::size_t i = 0; i < loops_.size(); ++i) {
    if (surrounds(i, p, is_on)) is_within = !is_within;
    if (is_on) return true;
  }
  return is_within;
}

bool Trim::may_cross(Range u, Range v) const {
  const Vec3 low = fractions(u.low, v.low), high = fractions(u.high, v.high);
  for (std::size_t k = 0; k < loops_.size(); ++k)
    for (const std::uint32_t i : bands_[k].between(low.y, high.y)) {
      const Vec3 a = corners_[k][i], b = corners_[k][i + 1];
      const Real sag = sag_of(loops_[k].leaves()[i]) + kOn;
      const bool is_apart = std::min(a.x, b.x) - sag > high.x || std::max(a.x, b.x) + sag < low.x ||
                            std::min(a.y, b.y) - sag > high.y || std::max(a.y, b.y) + sag < low.y;
      if (!is_apart) return true;
    }
  return false;
}

OnTrim Trim::beside(Real u, Real v) const {
  const Vec3 p = fractions(u, v);
  OnTrim best;
  Real least = 1e300;
  for (std::size_t k = 0; k < loops_.size(); ++k) {
    const NearestPoint near = closest_point(loops_[k], p);
    if (!(near.distance < least)) continue;
    least = near.distance, best = {k, 0, near.u};
  }
  return on(best.loop, best.t);
}

OnTrim Trim::on(std::size_t loop, Real t) const {
  const std::vector<Wire::Leaf>& leaves = loops_[loop].leaves();
  const auto at = std::lower_bound(leaves.begin(), leaves.end() - 1, t,
                                   [](const Wire::Leaf& leaf, Real x) { return leaf.t.high < x; });
  return {loop, static_cast<std::size_t>(at - leaves.begin()), t};
}

CurveDerivatives Trim::at(const OnTrim& place) const {
  const Wire& loop = loops_[place.loop];
  CurveDerivatives c = evaluate_on(loop.curve(), loop.leaves()[place.leaf].span, place.t, 2);
  for (Vec3& d : c) d *= width_;
  c[0] += corner_;
  return c;
}

NearestPoint Trim::closest(const Face& face, Vec3 p, Real limit) const {
  NearestPoint best{.distance = limit, .is_on_edge = true};
  const auto slope = [&](const Jet& j) { return distance_slope(j, p); };
  const auto descend = [&](const Part& part) {
    const Real t = loops_[part.loop].leaves()[part.leaf].t.middle();
    const TrimEnd end = TrimWalk(face, slope).from({part.loop, part.leaf, t});
    const Real distance = glm::distance(end.jet.s, p);
    if (!(distance < best.distance)) return;
    best.u = end.u, best.v = end.v, best.point = end.jet.s, best.distance = distance;
  };
  const auto nearest =
      std::min_element(parts_.begin(), parts_.end(), [&](const Part& a, const Part& b) {
        return glm::distance(a.middle, p) < glm::distance(b.middle, p);
      });
  descend(*nearest);
  for (const Part& part : parts_)
    if (glm::distance(part.middle, p) - part.radius < best.distance * (1 - kNear)) descend(part);
  return best;
}

/// By Green's theorem: along a loop, dv times the integral of |S_u x S_v| from the low end of u.
Real Trim::area(const Face& face) const {
  const std::vector<Real> breaks = face.u().breaks();
  const auto to_the_left = [&](Real u, Real v) {
    Real sum = 0;
    for (std::size_t i = 0; i + 1 < breaks.size() && breaks[i] < u; ++i)
      sum += integral({breaks[i], std::min(breaks[i + 1], u)}, [&](Real x) {
        const Jet j = face.at(x, v);
        return glm::length(glm::cross(j.u, j.v));
      });
    return sum;
  };
  Real area = 0;
  for (std::size_t k = 0; k < loops_.size(); ++k) {
    Real own = 0;
    for (std::size_t i = 0; i < loops_[k].leaves().size(); ++i)
      own += adaptive_integral(loops_[k].leaves()[i].t, kAgree * face.size() * face.size(),
                               [&](Real x) {
                                 const CurveDerivatives c = at({k, i, x});
                                 const Real u = face.u().domain().clamped(c[0].x);
                                 return c[1].y * to_the_left(u, face.v().domain().clamped(c[0].y));
                               });
    int around = 0;
    for (std::size_t other = 0; other < loops_.size(); ++other) {
      bool is_on = false;
      if (other != k && surrounds(other, corners_[k].front(), is_on)) ++around;
    }
    area += (around % 2 == 0 ? 1 : -1) * std::abs(own);
  }
  return area;
}

}  // namespace pantin::detail::nurbs
