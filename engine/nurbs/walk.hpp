#pragma once
/// Descent over the faces of a skin, from face to face where they join.
#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/nurbs/skin.hpp"
#include "engine/nurbs/trim.hpp"

namespace pantin::detail::nurbs {

/// The end of a walk.
struct WalkEnd {
  Place at;
  Jet jet;
  Real f = 0;
  bool is_on_rim = false;  // at an active end of the domain without a neighbour, or on a trim
};

/// Newton's method for a function of the surface's points: shifted where it is not convex,
/// shortened until it decreases. `slope(jet)` evaluates the function at a surface point. An end off
/// the trim of its face is replaced by one along the loops. No heap.
template <class Function>
class Walk {
 public:
  Walk(const Skin& skin, const Function& slope) : skin_(skin), slope_(slope) {}

  WalkEnd from(Place start) {
    at_ = start, look();
    int crossings = 0;
    for (int round = 0; round < kMostSteps; ++round) {
      const Step step = next();
      if (crossings < kMostCrossings && (step.is_held_u || step.is_held_v) && cross(step)) {
        ++crossings;
        continue;
      }
      const Real longest = std::max(std::abs(step.u), std::abs(step.v));
      if (!(longest > 1e-15) || !go(step, longest)) break;
      if (longest < 1e-11) break;
    }
    if (!skin_.holds(at_)) return end_on_trim();
    const Step last = next();
    const bool is_on_rim = (last.is_held_u && !skin_.neighbour(at_.face, edge_of_u())) ||
                           (last.is_held_v && !skin_.neighbour(at_.face, edge_of_v()));
    return {at_, jet_, slope_here_.f, is_on_rim && !skin_.half_axes()};
  }

 private:
  static constexpr int kMostSteps = 40, kMostCrossings = 8;

  /// In units of the domain. Parameters at an active end do not move.
  struct Step {
    Real u = 0, v = 0;
    bool is_held_u = false, is_held_v = false;
  };

  WalkEnd end_on_trim() const {
    const TrimEnd end = TrimWalk(face(), slope_).from(face().trim()->beside(at_.u, at_.v));
    return {{at_.face, end.u, end.v}, end.jet, end.f, true};
  }

  const Face& face() const { return skin_.face(at_.face); }
  Edge edge_of_u() const { return at_.u <= face().u().low() ? Edge::u_low : Edge::u_high; }
  Edge edge_of_v() const { return at_.v <= face().v().low() ? Edge::v_low : Edge::v_high; }
  void look() {
    jet_ = face().at(at_.u, at_.v);
    slope_here_ = slope_(jet_);
  }
  static bool is_held(const Knots& k, Real t, Real g) {
    return !k.is_periodic && ((t <= k.low() && g > 0) || (t >= k.high() && g < 0));
  }

  Step next() const {
    const Knots &u = face().u(), &v = face().v();
    const Real wu = u.domain().width(), wv = v.domain().width();
    const Slope& s = slope_here_;
    const Real gu = s.gu * wu, gv = s.gv * wv, a = s.huu * wu * wu, b = s.huv * wu * wv,
               c = s.hvv * wv * wv;
    Step step;
    step.is_held_u = is_held(u, at_.u, gu), step.is_held_v = is_held(v, at_.v, gv);
    const Real size = std::abs(a) + 2 * std::abs(b) + std::abs(c);
    const auto single = [&](Real g, Real bend) {
      return size > 0 ? -g / std::max(std::abs(bend), 1e-9 * size) : -g;
    };
    if (step.is_held_u || step.is_held_v) {
      if (!step.is_held_u) step.u = single(gu, a);
      if (!step.is_held_v) step.v = single(gv, c);
      return step;
    }
    const Real least = (a + c) / 2 - std::sqrt((a - c) * (a - c) / 4 + b * b);
    const Real raised = least < 1e-9 * size ? 1e-3 * size - least : 0;
    const Real p = a + raised, q = c + raised, determinant = p * q - b * b;
    if (!(determinant > 0)) {
      const Real g = std::max(std::abs(gu), std::abs(gv));
      if (g > 0) step.u = -0.01 * gu / g, step.v = -0.01 * gv / g;
      return step;
    }
    step.u = (b * gv - q * gu) / determinant, step.v = (b * gu - p * gv) / determinant;
    return step;
  }

  static Real inside(const Knots& k, Real t) {
    return k.is_periodic ? k.inside(t) : k.domain().clamped(t);
  }

  bool go(const Step& step, Real longest) {
    const Place start = at_;
    const Jet jet = jet_;
    const Slope before = slope_here_;
    const Real wu = face().u().domain().width(), wv = face().v().domain().width();
    for (Real part = std::min(1.0, 0.25 / longest); part > 1e-7; part /= 4) {
      at_.u = inside(face().u(), start.u + part * step.u * wu);
      at_.v = inside(face().v(), start.v + part * step.v * wv);
      if (at_.u == start.u && at_.v == start.v) break;
      look();
      if (slope_here_.f < before.f || (longest < 1e-6 && part == 1)) return true;
    }
    at_ = start, jet_ = jet, slope_here_ = before;
    return false;
  }

  /// Crosses to the neighbour, if the function decreases there.
  bool cross(const Step& step) {
    const std::optional<Place> to = skin_.across(at_, step.is_held_u ? edge_of_u() : edge_of_v());
    if (!to) return false;
    const Place start = at_;
    const Jet jet = jet_;
    const Slope before = slope_here_;
    at_ = *to, look();
    const Step there = next();
    const Real longest = std::max(std::abs(there.u), std::abs(there.v));
    if (longest > 1e-12 && go(there, longest) && slope_here_.f < before.f) return true;
    at_ = start, jet_ = jet, slope_here_ = before;
    return false;
  }

  const Skin& skin_;
  const Function& slope_;
  Place at_;
  Jet jet_;
  Slope slope_here_;
};

/// The local support point along a direction near `start`.
inline WalkEnd climb(const Skin& skin, Vec3 direction, Place start) {
  const auto slope = [&](const Jet& j) {
    return Slope{-glm::dot(direction, j.s),  -glm::dot(direction, j.u),
                 -glm::dot(direction, j.v),  -glm::dot(direction, j.uu),
                 -glm::dot(direction, j.uv), -glm::dot(direction, j.vv)};
  };
  return Walk(skin, slope).from(start);
}

/// The local nearest point to p near `start`; f is half the squared distance.
inline WalkEnd approach(const Skin& skin, Vec3 p, Place start) {
  return Walk(skin, [&](const Jet& j) { return distance_slope(j, p); }).from(start);
}

}  // namespace pantin::detail::nurbs
