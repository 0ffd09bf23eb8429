#include "engine/nurbs/check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/nurbs/bounds.hpp"
#include "engine/nurbs/plane_curves.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr Real kJump = 1e-9;          // relative; smaller jumps are rounding
constexpr Real kNoNormal = 1e-9;      // of size^2
constexpr Real kLeastSpan = 1e-12;    // between knots, of their domain; and of that itself
constexpr Real kLeastShare = 1e-15;   // likewise, of the knots
constexpr Real kLoopGap = 1e-6;       // of the domain: trims that are open, or leave it
constexpr Real kLeastLoop = 1e-10;    // of the domain's area
constexpr int kLoopLooks = 16;        // at a piece of a trim
constexpr Real kLeastWeight = 1e-12;  // of the largest: smaller ones are lost to rounding

std::string text_of(Real x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", x);
  return text;
}

/// Collects errors that all begin with the same prefix.
struct Complaints {
  std::string place;
  std::vector<Error> errors = {};
  void add(const std::string& what) { errors.push_back({place + ": " + what}); }
};

// False if some knots are so close that a span cannot be halved.
bool are_apart(const Knots& k, Complaints& to) {
  const Real size = std::max(std::abs(k.values.front()), std::abs(k.values.back()));
  const Real least = std::max(kLeastSpan * (k.high() - k.low()), kLeastShare * size);
  for (std::size_t i = 1; i < k.values.size(); ++i) {
    const Real gap = k.values[i] - k.values[i - 1];
    if (gap == 0 || gap >= least) continue;
    to.add("knots " + std::to_string(i - 1) + " and " + std::to_string(i) + " are " + text_of(gap) +
           " apart, expected equal ones, or at least " + text_of(least));
    return false;
  }
  return true;
}

// False if the knots cannot even be counted.
bool look_at_knots(const Knots& k, std::size_t points, Complaints& to) {
  if (k.degree < 1 || k.degree > kMostDegree) {
    to.add("found degree " + std::to_string(k.degree) + ", expected 1 to " +
           std::to_string(kMostDegree));
    return false;
  }
  const std::size_t needed = points + static_cast<std::size_t>(k.degree) + 1;
  if (k.values.size() != needed || points < static_cast<std::size_t>(k.degree) + 1) {
    to.add("found " + std::to_string(k.values.size()) + " knots for " + std::to_string(points) +
           " control points of degree " + std::to_string(k.degree) + ", expected " +
           std::to_string(std::max(needed, static_cast<std::size_t>(2 * k.degree + 2))));
    return false;
  }
  for (std::size_t i = 0; i < k.values.size(); ++i) {
    const Real t = k.values[i];
    if (!std::isfinite(t)) {
      to.add("knot " + std::to_string(i) + " is not a finite number");
      return false;
    }
    if (i > 0 && t < k.values[i - 1]) {
      to.add("knot " + std::to_string(i) + " is " + text_of(t) + " after " +
             text_of(k.values[i - 1]) + ", expected knots that do not decrease");
      return false;
    }
  }
  if (!(k.high() - k.low() > kLeastSpan)) {
    to.add("found a domain from " + text_of(k.low()) + " to " + text_of(k.high()) +
           ", expected a range of more than " + text_of(kLeastSpan));
    return false;
  }
  return are_apart(k, to);
}

void look_at_multiplicities(const Knots& k, Complaints& to) {
  for (std::size_t i = 0; i < k.values.size();) {
    const Real t = k.values[i];
    const int times = k.multiplicity(t),
              most = k.low() < t && t < k.high() ? k.degree : k.degree + 1;
    if (times > most)
      to.add("knot " + text_of(t) + " has multiplicity " + std::to_string(times) +
             ", expected at most " + std::to_string(most));
    i += static_cast<std::size_t>(times);
  }
}

void look_at_points(std::span<const Weighted> points, Complaints& to) {
  Real largest = 0;
  for (const Weighted& p : points) largest = std::max(largest, p.w);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Weighted& p = points[i];
    const std::string which = "control point " + std::to_string(i);
    if (!is_finite(p.product()) || !std::isfinite(p.w))
      to.add(which + " has a number that is not finite");
    else if (!(p.w > 0))
      to.add(which + " has weight " + text_of(p.w) + ", expected one above 0");
    else if (p.w < kLeastWeight * largest)
      to.add(which + " has weight " + text_of(p.w) + ", expected at least " +
             text_of(kLeastWeight * largest) + ": the largest is " + text_of(largest));
  }
}

Real size_of(std::span<const Weighted> points) { return bounding_ball(points).radius; }

}  // namespace

std::vector<Error> errors_of(const Curve& curve, const std::string& name) {
  Complaints all{name};
  look_at_points(curve.points, all);
  if (!look_at_knots(curve.knots, curve.points.size(), all)) return all.errors;
  look_at_multiplicities(curve.knots, all);
  if (!all.errors.empty() || !curve.knots.is_periodic) return all.errors;
  const auto [low, high] = curve.knots.domain();
  const Vec3 begin = evaluate_on(curve, curve.knots.span_at(low), low, 0)[0];
  const Vec3 end = evaluate_on(curve, curve.knots.span_at(high), high, 0)[0];
  if (const Real gap = glm::distance(begin, end); gap > kJump * size_of(curve.points))
    all.add("is periodic, but its ends are " + text_of(gap) + " m apart");
  return all.errors;
}

namespace {

// Upper bound of the distance between the two ends of a periodic direction.
Real seam_gap(const Surface& s, Along way) {
  const Knots& k = knots_of(s, way);
  const Curve begin = isoline(s, way, k.low());
  Curve end = begin;
  // Not wrapped: evaluate the polynomials of the last span.
  Basis basis;
  const int span = k.span_at(k.high());
  write_basis(k, {span, k.high()}, 0, basis);
  for (int i = 0; i < end.knots.count(); ++i) {
    Weighted sum;
    for (int j = 0; j <= k.degree; ++j) {
      const int row = span - k.degree + j;
      sum = sum + basis[0][j] * (way == Along::u ? s.at(row, i) : s.at(i, row));
    }
    end.points[static_cast<std::size_t>(i)] = sum;
  }
  Real most = 0;
  for (std::size_t i = 0; i < begin.points.size(); ++i)
    most = std::max(most, glm::distance(begin.points[i].point(), end.points[i].point()));
  return most;
}

}  // namespace

namespace {

/// A loop that trims a surface is a closed curve without crossings, within the domain.
void look_at_loop(const Surface& surface, std::size_t number, Complaints& to) {
  const std::string name = to.place + ", trim " + std::to_string(number);
  const Curve& loop = surface.trims[number];
  const std::vector<Error> errors = errors_of(loop, name);
  to.errors.insert(to.errors.end(), errors.begin(), errors.end());
  if (!errors.empty()) return;
  Complaints own{name};
  const Range u = surface.u.domain(), v = surface.v.domain();
  const auto fraction = [&](Real t) {
    const Vec3 at = evaluate(loop, t, 0)[0];
    return Vec3((at.x - u.low) / u.width(), (at.y - v.low) / v.width(), at.z);
  };
  const Vec3 begin = fraction(loop.knots.low()), end = fraction(loop.knots.high());
  Real out = 0;
  std::array<Real, 2> where{0, 0};
  const std::vector<Real> breaks = loop.knots.breaks();
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
    for (int k = 0; k <= kLoopLooks; ++k) {
      const Vec3 at = fraction(breaks[i] + (breaks[i + 1] - breaks[i]) * k / kLoopLooks);
      const Real here = std::max({-at.x, at.x - 1, -at.y, at.y - 1});
      if (here > out) out = here, where = {u.low + at.x * u.width(), v.low + at.y * v.width()};
    }
  Curve even =
      transformed(loop, {Mat3(1 / u.width(), 0, 0, 0, 1 / v.width(), 0, 0, 0, 1), Vec3(0)});
  even.knots.is_periodic = true;  // its ends are one place
  const bool is_flat = std::all_of(loop.points.begin(), loop.points.end(),
                                   [](const Weighted& w) { return w.z == 0; });
  if (!is_flat)
    own.add("found points off the plane of (u, v), expected z = 0 of all");
  else if (glm::distance(begin, end) > kLoopGap)
    own.add("is open by " + text_of(glm::distance(begin, end)) +
            " of the domain, expected a closed curve");
  else if (out > kLoopGap)
    own.add("leaves the domain at u = " + text_of(where[0]) + ", v = " + text_of(where[1]) +
            ", expected u from " + text_of(u.low) + " to " + text_of(u.high) + " and v from " +
            text_of(v.low) + " to " + text_of(v.high));
  else if (std::abs(area_around(even)) < kLeastLoop)
    own.add("encloses nothing, expected a curve around an area");
  else if (const auto at = crossing_of(even))
    own.add("crosses itself at t = " + text_of((*at)[0]) + " and " + text_of((*at)[1]) +
            ", expected a curve that does not");
  to.errors.insert(to.errors.end(), own.errors.begin(), own.errors.end());
}

}  // namespace

std::vector<Error> errors_of(const Surface& surface, const std::string& name) {
  Complaints all{name};
  look_at_points(surface.points, all);
  bool is_counted = true;
  for (const Along way : {Along::u, Along::v}) {
    const Knots& k = knots_of(surface, way);
    Complaints own{name + (way == Along::u ? ", u" : ", v")};
    const Knots& other = knots_of(surface, way == Along::u ? Along::v : Along::u);
    const std::ptrdiff_t across =
        static_cast<std::ptrdiff_t>(other.values.size()) - other.degree - 1;
    const std::size_t points =
        across > 0 && surface.points.size() % static_cast<std::size_t>(across) == 0
            ? surface.points.size() / static_cast<std::size_t>(across)
            : surface.points.size();
    if (look_at_knots(k, points, own))
      look_at_multiplicities(k, own);
    else
      is_counted = false;
    all.errors.insert(all.errors.end(), own.errors.begin(), own.errors.end());
  }
  if (!all.errors.empty() || !is_counted) return all.errors;
  for (const Along way : {Along::u, Along::v})
    if (knots_of(surface, way).is_periodic)
      if (const Real gap = seam_gap(surface, way); gap > kJump * size_of(surface.points))
        all.add(std::string("is periodic along ") + (way == Along::u ? "u" : "v") +
                ", but its ends are " + text_of(gap) + " m apart");
  for (std::size_t i = 0; i < surface.trims.size() && all.errors.empty(); ++i)
    look_at_loop(surface, i, all);
  return all.errors;
}

// ---- Smoothness --------------------------------------------------------------------------------

namespace {

/// Both sides of a knot: spans and parameters. The parameters differ at a seam only.
struct Sides {
  Real knot;
  int span[2];
  Real at[2];
};

// Knots whose multiplicity allows a jump of the first or second derivative, and the seam.
std::vector<Sides> doubtful_knots(const Knots& k) {
  std::vector<Sides> found;
  const std::vector<int> spans = k.spans();
  for (std::size_t i = 1; i < spans.size(); ++i) {
    const Real t = k[spans[i]];
    if (k.degree - k.multiplicity(t) < 2) found.push_back({t, {spans[i - 1], spans[i]}, {t, t}});
  }
  if (k.is_periodic)
    found.push_back({k.high(), {spans.back(), spans.front()}, {k.high(), k.low()}});
  return found;
}

// Relative to the longer of two vectors, or to the usual length where both are shorter.
Real relative_jump(Vec3 a, Vec3 b, Real usual) {
  return glm::distance(a, b) / std::max({glm::length(a), glm::length(b), usual});
}

const char* word_of(FlawKind kind) {
  switch (kind) {
    case FlawKind::crease:
      return "the tangent plane jumps";
    case FlawKind::jump_of_speed:
      return "first derivatives jump";
    case FlawKind::jump_of_bend:
      return "second derivatives jump";
    case FlawKind::singular_point:
      return "has no normal";
    case FlawKind::degenerate_edge:
      return "is one point";
  }
  return "";
}

struct Jumps {
  Real turn = 0, speed = 0, bend = 0;
};

// The largest jump, if there is one.
void add_jump(const Jumps& j, Flaw flaw, const std::string& place, std::vector<Flaw>& to) {
  if (j.turn > kJump)
    flaw.kind = FlawKind::crease, flaw.size = j.turn;
  else if (j.speed > kJump)
    flaw.kind = FlawKind::jump_of_speed, flaw.size = j.speed;
  else if (j.bend > 100 * kJump)
    flaw.kind = FlawKind::jump_of_bend, flaw.size = j.bend;
  else
    return;
  flaw.text = place + ": " + word_of(flaw.kind) + " by " + text_of(flaw.size);
  to.push_back(std::move(flaw));
}

std::vector<Real> samples_of(const Knots& k, int each) {
  std::vector<Real> at;
  const std::vector<Real> breaks = k.breaks();
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
    for (int j = 0; j < each; ++j)
      at.push_back(breaks[i] + (breaks[i + 1] - breaks[i]) * (j + 0.5) / each);
  return at;
}

void look_across(const Surface& s, Along way, const std::string& name, std::vector<Flaw>& to) {
  const bool is_u = way == Along::u;
  const Knots& other = is_u ? s.v : s.u;
  const Real width = knots_of(s, way).domain().width(), usual = size_of(s.points) / width;
  for (const Sides& sides : doubtful_knots(knots_of(s, way))) {
    Jumps worst;
    Flaw flaw{.kind = FlawKind::crease, .way = way, .knot = sides.knot, .text = {}};
    for (Real t : samples_of(other, 3)) {
      SurfaceDerivatives d[2];
      for (int i = 0; i < 2; ++i) {
        const Cell cell =
            is_u ? Cell{sides.span[i], other.span_at(t)} : Cell{other.span_at(t), sides.span[i]};
        const Real own = sides.at[i];
        d[i] = evaluate_on(s, cell, is_u ? std::array{own, t} : std::array{t, own}, 2);
      }
      const auto first = [&](int i) { return is_u ? d[i][1][0] : d[i][0][1]; };
      const auto second = [&](int i) { return is_u ? d[i][2][0] : d[i][0][2]; };
      const Vec3 n0 = glm::cross(d[0][1][0], d[0][0][1]), n1 = glm::cross(d[1][1][0], d[1][0][1]);
      const Real lengths = glm::length(n0) * glm::length(n1);
      const Real turn =
          lengths > 0 ? std::atan2(glm::length(glm::cross(n0, n1)), glm::dot(n0, n1)) : 0;
      if (turn > worst.turn) flaw.at = is_u ? std::array{sides.knot, t} : std::array{t, sides.knot};
      worst.turn = std::max(worst.turn, turn);
      worst.speed = std::max(worst.speed, relative_jump(first(0), first(1), usual));
      worst.bend = std::max(worst.bend, relative_jump(second(0), second(1), usual / width));
    }
    const std::string place = name + ", " + (is_u ? "u" : "v") + ", knot " + text_of(sides.knot);
    add_jump(worst, std::move(flaw), place, to);
  }
}

/// Measure of singularity: |u x v| in parameters that run from 0 to 1, divided by size^2.
Real normal_share(const Surface& s, std::array<Real, 2> at, Real size) {
  const SurfaceDerivatives d = evaluate(s, at[0], at[1], 1);
  const Real scale = s.u.domain().width() * s.v.domain().width() / (size * size);
  return glm::length(glm::cross(d[1][0], d[0][1])) * scale;
}

// Descends from a point by halved steps.
std::array<Real, 2> least_near(const Surface& s, std::array<Real, 2> at, Real size) {
  std::array<Real, 2> step{s.u.domain().width() / 16, s.v.domain().width() / 16};
  Real least = normal_share(s, at, size);
  for (int round = 0; round < 60; ++round) {
    bool is_better = false;
    for (std::size_t i = 0; i < 2; ++i)
      for (const Real sign : {1.0, -1.0}) {
        std::array<Real, 2> to = at;
        to[i] += sign * step[i];
        to = {s.u.domain().clamped(to[0]), s.v.domain().clamped(to[1])};
        if (const Real here = normal_share(s, to, size); here < least)
          least = here, at = to, is_better = true;
      }
    if (!is_better) step[0] /= 2, step[1] /= 2;
  }
  return at;
}

// Edges first: points on a degenerate edge are not reported again.
void look_at_edges(const Surface& s, const std::string& name, std::vector<Flaw>& to) {
  const Real size = size_of(s.points);
  for (const Along way : {Along::u, Along::v})
    for (const Real t : {knots_of(s, way).low(), knots_of(s, way).high()}) {
      if (knots_of(s, way).is_periodic) continue;
      const Curve edge = isoline(s, way, t);
      if (const Real length = size_of(edge.points); length <= kJump * size) {
        Flaw flaw{
            .kind = FlawKind::degenerate_edge, .way = way, .knot = t, .size = length, .text = {}};
        flaw.at = way == Along::u ? std::array{t, s.v.low()} : std::array{s.u.low(), t};
        flaw.text = name + ": edge " + (way == Along::u ? "u" : "v") + " = " + text_of(t) + " " +
                    word_of(flaw.kind);
        to.push_back(std::move(flaw));
      }
    }
}

// Whether the polynomial piece at a point certainly has a normal everywhere.
bool has_normals(const Surface& s, std::array<Real, 2> at) {
  const auto range = [](const Knots& k, Real t) {
    const int span = k.span_at(t);
    return Range{k[span], k[span + 1]};
  };
  const Surface strip = part_of(s, Along::u, range(s.u, at[0]));
  return bounded(part_of(strip, Along::v, range(s.v, at[1]))).leaf.turn < kPi / 2;
}

// Descends from samples that are local minima among their neighbours.
void look_for_singular(const Surface& s, const std::string& name, std::vector<Flaw>& to) {
  const Real size = size_of(s.points);
  const std::vector<Real> us = samples_of(s.u, 4), vs = samples_of(s.v, 4);
  std::vector<Real> shares;
  for (Real u : us)
    for (Real v : vs) shares.push_back(normal_share(s, {u, v}, size));
  const auto is_least = [&](std::size_t i, std::size_t j) {
    for (std::size_t k = std::max<std::size_t>(i, 1) - 1; k < std::min(i + 2, us.size()); ++k)
      for (std::size_t l = std::max<std::size_t>(j, 1) - 1; l < std::min(j + 2, vs.size()); ++l)
        if (shares[k * vs.size() + l] < shares[i * vs.size() + j]) return false;
    return true;
  };
  const auto point = [&](const std::array<Real, 2>& at) {
    return evaluate(s, at[0], at[1], 0)[0][0];
  };
  std::vector<std::array<Real, 2>> found;
  for (std::size_t i = 0; i < us.size(); ++i)
    for (std::size_t j = 0; j < vs.size(); ++j) {
      if (!is_least(i, j) || has_normals(s, {us[i], vs[j]})) continue;
      const auto at = least_near(s, {us[i], vs[j]}, size);
      const Real share = normal_share(s, at, size);
      const auto is_same = [&](const std::array<Real, 2>& other) {
        return glm::distance(point(other), point(at)) < 1e-3 * size;
      };
      if (share > kNoNormal || std::any_of(found.begin(), found.end(), is_same)) continue;
      found.push_back(at);
      Flaw flaw{.kind = FlawKind::singular_point, .at = at, .size = share, .text = {}};
      flaw.text =
          name + ", u = " + text_of(at[0]) + ", v = " + text_of(at[1]) + ": " + word_of(flaw.kind);
      to.push_back(std::move(flaw));
    }
}

}  // namespace

std::vector<Flaw> flaws_of(const Surface& surface, const std::string& name) {
  std::vector<Flaw> all;
  look_across(surface, Along::u, name, all);
  look_across(surface, Along::v, name, all);
  look_at_edges(surface, name, all);
  look_for_singular(surface, name, all);
  return all;
}

std::vector<Flaw> flaws_of(const Curve& curve, const std::string& name) {
  std::vector<Flaw> all;
  const Real width = curve.knots.domain().width(), size = size_of(curve.points);
  const Real usual = size / width;
  for (const Sides& sides : doubtful_knots(curve.knots)) {
    const CurveDerivatives a = evaluate_on(curve, sides.span[0], sides.at[0], 2);
    const CurveDerivatives b = evaluate_on(curve, sides.span[1], sides.at[1], 2);
    const Jumps jumps{std::atan2(glm::length(glm::cross(a[1], b[1])), glm::dot(a[1], b[1])),
                      relative_jump(a[1], b[1], usual), relative_jump(a[2], b[2], usual / width)};
    Flaw flaw{.kind = FlawKind::crease, .knot = sides.knot, .at = {sides.knot, 0}, .text = {}};
    add_jump(jumps, std::move(flaw), name + ", knot " + text_of(sides.knot), all);
  }
  for (Real t : curve.knots.breaks()) {
    const Real speed = glm::length(evaluate(curve, t, 1)[1]) * width / size;
    if (speed > kNoNormal) continue;
    Flaw flaw{.kind = FlawKind::singular_point, .knot = t, .at = {t, 0}, .size = speed, .text = {}};
    flaw.text = name + ", t = " + text_of(t) + ": has no tangent";
    all.push_back(std::move(flaw));
  }
  return all;
}

}  // namespace pantin::detail::nurbs
