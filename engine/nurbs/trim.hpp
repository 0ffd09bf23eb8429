#pragma once
/// Loops that trim a face: what is kept, and the nearest points of its boundary.
///
/// A loop is a closed curve in the plane of (u, v). A place is kept if an odd number of loops winds
/// around it, whatever their directions: the first level is an outline, the next are holes. Places
/// on a loop belong to the face. Neither the test nor the boundary is approximated: the chords of
/// the curve decide where they are farther from the place than from the curve, by the bound of its
/// second derivative; elsewhere the curve is cut.
///
/// Internal (pantin::detail).
#include <span>

#include "engine/nurbs/closest.hpp"

namespace pantin::detail::nurbs {

/// A function of a surface's parameters: value, gradient, second derivatives.
struct Slope {
  Real f = 0, gu = 0, gv = 0, huu = 0, huv = 0, hvv = 0;
};

/// Half the squared distance of p from a point of a surface, with its derivatives.
inline Slope distance_slope(const Jet& j, Vec3 p) {
  const Vec3 d = j.s - p;
  return {glm::dot(d, d) / 2,
          glm::dot(d, j.u),
          glm::dot(d, j.v),
          glm::dot(j.u, j.u) + glm::dot(d, j.uu),
          glm::dot(j.u, j.v) + glm::dot(d, j.uv),
          glm::dot(j.v, j.v) + glm::dot(d, j.vv)};
}

/// A place on a loop: the parameter, and the part of the curve by whose polynomials it is
/// evaluated.
struct OnTrim {
  std::size_t loop = 0, leaf = 0;
  Real t = 0;
};

class Trim {
 public:
  /// Of a face that has loops, all of which pass errors_of().
  explicit Trim(const Face& face);

  /// The loops, with parameters u and v as fractions of the face's domain.
  const std::vector<Wire>& loops() const { return loops_; }
  /// Whether a place is kept.
  bool holds(Real u, Real v) const;
  /// Whether a loop may run through a rectangle of parameters; false is certain.
  bool may_cross(Range u, Range v) const;
  /// The place of the loops that is nearest in the plane of the fractions.
  OnTrim beside(Real u, Real v) const;
  /// The place on a loop at a parameter.
  OnTrim on(std::size_t loop, Real t) const;
  /// The curve at a place of the loops, in u and v, and its derivatives to order 2.
  CurveDerivatives at(const OnTrim& place) const;
  /// The place of the boundary nearest to p, if it is nearer than `limit` (m): from a start on each
  /// part that is not too far away. No heap.
  NearestPoint closest(const Face& face, Vec3 p, Real limit) const;
  /// Area of the face within the loops, m^2.
  Real area(const Face& face) const;

 private:
  /// A part of a loop is within a ball about its middle, in space; guaranteed.
  struct Part {
    std::size_t loop, leaf;
    Vec3 middle;
    Real radius;
  };
  Vec3 fractions(Real u, Real v) const {
    return {(u - corner_.x) / width_.x, (v - corner_.y) / width_.y, 0};
  }
  /// The parts of a loop by their height: those that a horizontal line may meet are in its band.
  class Bands {
   public:
    Bands(const Wire& loop, const std::vector<Vec3>& corners);
    /// The parts in the bands between two heights; a part may be in several of them.
    std::span<const std::uint32_t> between(Real low, Real high) const;

   private:
    std::size_t band_of(Real y) const;

    Real low_ = 0, high_ = 0, rate_ = 0;  // rate_: bands by height
    std::vector<std::uint32_t> begin_, parts_;
  };
  bool surrounds(std::size_t number, Vec3 p, bool& is_on) const;

  Vec3 corner_{0}, width_{1};  // of the domain
  std::vector<Wire> loops_;
  std::vector<Bands> bands_;
  std::vector<std::vector<Vec3>> corners_;  // by loop: where its parts begin, and where it closes
  std::vector<Part> parts_;
};

/// The end of a descent along the loops.
struct TrimEnd {
  Real u = 0, v = 0, f = 0;
  Jet jet;
};

/// Newton's method for a function along the loops of a face, from part to part, shortened until it
/// decreases. `slope(jet)` evaluates the function at a surface point. No heap.
template <class Function>
class TrimWalk {
 public:
  TrimWalk(const Face& face, const Function& slope)
      : face_(face), trim_(*face.trim()), slope_(slope) {}

  TrimEnd from(OnTrim start) {
    at_ = start, here_ = look(at_);
    for (int round = 0; round < kMostSteps; ++round) {
      if (is_pushed_out()) {
        if (!cross()) break;
        continue;
      }
      const Real g = here_.slope, b = here_.bend;
      Real step = b > 0 ? -g / b : g > 0 ? -kFar : kFar;
      if (!(std::abs(step) > 1e-15)) break;
      step = std::abs(step) > kFar ? std::copysign(kFar, step) : step;
      if (!go(step) || std::abs(step) < 1e-12) break;
    }
    return {here_.u, here_.v, here_.f, here_.jet};
  }

 private:
  static constexpr int kMostSteps = 80;
  static constexpr Real kFar = 0.5;  // of a part

  /// Derivatives by the parameter in units of the part.
  struct Here {
    Real u, v, f, slope, bend;
    Jet jet;
  };
  Range range() const { return trim_.loops()[at_.loop].leaves()[at_.leaf].t; }
  Here look(const OnTrim& at) const {
    const CurveDerivatives c = trim_.at(at);
    const Real w = trim_.loops()[at.loop].leaves()[at.leaf].t.width();
    Here h;
    h.u = face_.u().domain().clamped(c[0].x), h.v = face_.v().domain().clamped(c[0].y);
    h.jet = face_.at(h.u, h.v);
    const Slope s = slope_(h.jet);
    const Vec3 d = w * c[1], dd = w * w * c[2];
    h.f = s.f, h.slope = s.gu * d.x + s.gv * d.y;
    h.bend =
        s.huu * d.x * d.x + 2 * s.huv * d.x * d.y + s.hvv * d.y * d.y + s.gu * dd.x + s.gv * dd.y;
    return h;
  }
  bool is_pushed_out() const {
    return (at_.t <= range().low && here_.slope > 0) || (at_.t >= range().high && here_.slope < 0);
  }
  /// To the part beyond; false at a corner, where that leads back.
  bool cross() {
    const bool is_low = at_.t <= range().low;
    const std::size_t count = trim_.loops()[at_.loop].leaves().size();
    OnTrim to = at_;
    to.leaf = (at_.leaf + (is_low ? count - 1 : 1)) % count;
    const Range there = trim_.loops()[to.loop].leaves()[to.leaf].t;
    to.t = is_low ? there.high : there.low;
    const Here beyond = look(to);
    if (is_low ? !(beyond.slope > 0) : !(beyond.slope < 0)) return false;
    at_ = to, here_ = beyond;
    return true;
  }
  bool go(Real step) {
    const Range r = range();
    for (Real part = 1; part > 1e-9; part /= 4) {
      OnTrim to = at_;
      to.t = r.clamped(at_.t + part * step * r.width());
      if (to.t == at_.t) return false;
      const Here there = look(to);
      if (!(there.f < here_.f) && std::abs(step) > 1e-7) continue;
      at_ = to, here_ = there;
      return true;
    }
    return false;
  }

  const Face& face_;
  const Trim& trim_;
  const Function& slope_;
  OnTrim at_;
  Here here_{};
};

}  // namespace pantin::detail::nurbs
