#include "engine/nurbs/curve_pair.hpp"

#include <algorithm>
#include <cmath>

namespace pantin::detail::nurbs {
namespace {

constexpr int kMostIterations = 24, kMostTries = 40, kMostCuts = 54;
/// rad: tolerance of the angle between parallel straight parts; fraction of a domain: offset at
/// which curvature is looked for.
constexpr Real kFlat = 1e-6, kBeside = 1e-6;
constexpr Real kLongestStep = 0.25, kDone = 1e-9, kNoTangent = 1e-9, kFits = 1e-6, kStray = 1e-3;

CurveDerivatives in_frame(const Wire& wire, Real t, const Pose& pose) {
  CurveDerivatives d = evaluate(wire.curve(), t, 2);
  d[0] = to_world(pose, d[0]), d[1] = pose.rotation * d[1], d[2] = pose.rotation * d[2];
  return d;
}

Vec3 right_of(Vec3 v) { return {v.y, -v.x, 0}; }

// Adds a step; false if the parameter was at that end of the domain already.
bool walk(const Knots& k, Real step, Real& t) {
  const Range domain = k.domain();
  const Real to = t + step;
  const bool is_out = !k.is_periodic && ((to < domain.low && t == domain.low) ||
                                         (to > domain.high && t == domain.high));
  t = k.inside(to);
  return !is_out;
}

/// One equation f + r dt = 0 after b is eliminated, for both kinds of pairs.
struct Reduced {
  Real f, r;
};

// Where the curves fit one another, the steps are rounding errors only.
bool fits(Real curvature, Real step, Real size) {
  return !std::isfinite(step) || (step > kStray && std::abs(curvature) * size < kFits);
}

ContactStatus judged(const CurveContact& c, Real size) {
  return std::abs(c.least_curvature) * size < kFits ? ContactStatus::degenerate
                                                    : ContactStatus::found;
}

std::array<Vec3, 3> jet_of(const Wire& wire, Real t) {
  const CurveDerivatives d = evaluate(wire.curve(), t, 2);
  return {d[0], d[1], d[2]};
}
std::array<Vec3, 3> jet_of(const CurvePieces& curve, Real t) { return curve.at(t); }

template <class C>
bool has_no_way(const C& curve, Vec3 tangent) {
  const Real way = glm::length(tangent) * curve.knots().domain().width();
  return !(way > kNoTangent * curve.size());
}

/// Two curves of a plane, b's in its own frame, and the pose of a there.
template <class C>
struct CurvesInPlane {
  const C &a, &b;
  Mat3 turn;
  Vec3 origin;

  struct At {
    std::array<Vec3, 3> p, q;
    Vec3 n{0}, n_t{0};  // b's outward normal and its rate along b
    Real c = 0, e = 0, g = 0, across = 0;
    Real bend = 0, tilt = 0;  // of the gap along a: its curvature, 1/m, and slope
    Reduced k{};
  };
  At at(Real t, Real u) const {
    At x{jet_of(a, t), jet_of(b, u)};
    x.p = {origin + turn * x.p[0], turn * x.p[1], turn * x.p[2]};
    const std::array<Vec3, 3>&p = x.p, &q = x.q;
    const Real inverse = 1 / glm::length(q[1]);
    x.n = inverse * right_of(q[1]);
    const Vec3 d = p[0] - q[0], bend = right_of(q[2]);
    x.n_t = inverse * (bend - glm::dot(x.n, bend) * x.n);
    x.c = glm::dot(p[1], q[1]), x.e = glm::dot(d, q[2]) - glm::dot(q[1], q[1]);
    x.across = glm::dot(p[1], x.n_t), x.g = glm::dot(d, q[1]);
    x.k = {glm::dot(p[1], x.n) - x.across * x.g / x.e, glm::dot(p[2], x.n) - x.across * x.c / x.e};
    x.bend = x.k.r / glm::dot(p[1], p[1]), x.tilt = x.k.f / glm::length(p[1]);
    return x;
  }
  Real size() const { return std::min(a.size(), b.size()); }
  bool is_bent(const At& x) const { return !(std::abs(x.bend) * size() < kFits); }
};

/// The parameters of a pair, and the slope of the gap there.
struct BendPlace {
  Real t = 0, u = 0, slope = 0;
  bool is_known = false;
};

/// The parameter of a periodic curve that is closest to `to`.
Real beside(const Knots& k, Real t, Real to) {
  return k.is_periodic ? to + std::remainder(t - to, k.domain().width()) : t;
}

/// A straight part of one curve that is parallel to one of the other has no isolated pair. The
/// contact is put where the curvature begins, next to `to`. `bent` is a point beyond that, if one
/// is known.
template <class C>
CurveContact rest_on_end(const CurvesInPlane<C>& of, BendPlace bent, const BendPlace& to) {
  CurveContact out;
  out.status = ContactStatus::degenerate, out.t = to.t, out.b.u = to.u;
  const Knots &by_t = of.a.knots(), &by_u = of.b.knots();
  const auto bends_at = [&](Real t, Real u) {
    return of.is_bent(of.at(by_t.inside(t), by_u.inside(u)));
  };
  for (const Real way : {-kBeside, kBeside}) {
    if (bent.is_known) break;
    const Real t = to.t + way * by_t.domain().width();
    bent = {t, to.u, 0, bends_at(t, to.u)};
  }
  const auto x = of.at(to.t, to.u);
  if (!bent.is_known || !(std::abs(x.tilt) <= kFlat)) return out;
  BendPlace flat = to;
  bent.t = beside(by_t, bent.t, to.t), bent.u = beside(by_u, bent.u, to.u);
  for (int n = 0; n < kMostCuts; ++n) {
    const Real t = (bent.t + flat.t) / 2, u = (bent.u + flat.u) / 2;
    BendPlace& moved = bends_at(t, u) ? bent : flat;
    moved.t = t, moved.u = u;
  }
  bent.t = by_t.inside(bent.t), bent.u = by_u.inside(bent.u);
  auto end = of.at(bent.t, bent.u);
  for (int n = 0; n < 3; ++n) {
    bent.u = by_u.inside(bent.u - end.g / end.e);
    end = of.at(bent.t, bent.u);
  }
  if (!of.is_bent(end) || !(end.bend > 0) || !(std::abs(end.tilt) <= 2 * kFlat) || !(end.c < 0))
    return out;
  out.t = bent.t, out.b.u = bent.u, out.status = ContactStatus::found;
  out.on_a = end.p[0], out.on_b = end.q[0], out.normal = end.n;
  out.gap = glm::dot(end.n, end.p[0] - end.q[0]), out.least_curvature = end.bend;
  return out;
}

template <class C>
CurveContact track_in_plane(const C& a, const C& b, const Pose& a_in_b, std::array<Real, 2> from) {
  CurveContact out;
  out.t = from[0], out.b.u = from[1];
  const CurvesInPlane<C> of{a, b, glm::mat3_cast(a_in_b.rotation), a_in_b.position};
  const Real width_a = a.knots().domain().width(), width_b = b.knots().domain().width();
  const Real size = of.size();
  // At the transition from a round to a straight piece steps overshoot: this is the last point from
  // which one did.
  BendPlace round;
  int tries = 0;
  while (out.iterations < kMostIterations) {
    const auto x = of.at(out.t, out.b.u);
    const std::array<Vec3, 3>&p = x.p, &q = x.q;
    ++out.iterations;
    if (has_no_way(a, p[1]) || has_no_way(b, q[1])) {
      out.status = ContactStatus::singular;
      return out;
    }
    const Reduced k = x.k;
    const Real step = -k.f / k.r, step_b = -(x.g + x.c * step) / x.e;
    out.normal = x.n, out.gap = glm::dot(x.n, p[0] - q[0]);
    const Real length = std::max(std::abs(step) / width_a, std::abs(step_b) / width_b);
    out.least_curvature = x.bend;
    if (fits(out.least_curvature, length, size)) {
      if (k.f * round.slope < 0 && ++tries < kMostTries) {
        out.t = a.knots().inside((out.t + beside(a.knots(), round.t, out.t)) / 2);
        out.b.u = b.knots().inside((out.b.u + beside(b.knots(), round.u, out.b.u)) / 2);
        --out.iterations;
        continue;
      }
      return rest_on_end(of, round, {out.t, out.b.u});
    }
    round = {out.t, out.b.u, k.f, true};
    const Real part = length > kLongestStep ? kLongestStep / length : 1;
    if (!walk(a.knots(), part * step, out.t) || !walk(b.knots(), part * step_b, out.b.u)) {
      out.status = ContactStatus::left_patch;
      return out;
    }
    if (length > kDone) continue;
    out.on_a = p[0] + step * p[1], out.on_b = q[0] + step_b * q[1], out.normal += step_b * x.n_t;
    if (x.c < 0) out.status = judged(out, size);
    return out;
  }
  return out;
}

}  // namespace

CurveContact track_planar(const Wire& a, const Wire& b, const Pose& a_in_b,
                          std::array<Real, 2> from) {
  return track_in_plane(a, b, a_in_b, from);
}

CurveContact track_planar(const CurvePieces& a, const CurvePieces& b, const Pose& a_in_b,
                          std::array<Real, 2> from) {
  return track_in_plane(a, b, a_in_b, from);
}

CurveContact track_on_face(const Wire& a, const Skin& b, const Pose& a_in_b, const OnCurve& from) {
  CurveContact out;
  out.t = from.t, out.b = from.b;
  while (out.iterations < kMostIterations) {
    const Face& face = b.face(out.b.face);
    const CurveDerivatives p = in_frame(a, out.t, a_in_b);
    const Jet q = face.at(out.b.u, out.b.v);
    ++out.iterations;
    const Vec3 across = glm::cross(q.u, q.v), d = p[0] - q.s;
    const Real length_n = glm::length(across), inverse = 1 / length_n;
    const Range u = face.u().domain(), v = face.v().domain();
    if (has_no_way(a, p[1]) ||
        !(length_n * u.width() * v.width() > kNoTangent * face.size() * face.size())) {
      out.status = ContactStatus::singular;
      return out;
    }
    const Vec3 n = inverse * across;
    const Vec3 cross_u = glm::cross(q.uu, q.v) + glm::cross(q.u, q.uv);
    const Vec3 cross_v = glm::cross(q.uv, q.v) + glm::cross(q.u, q.vv);
    const Vec3 n_u = inverse * (cross_u - glm::dot(n, cross_u) * n);
    const Vec3 n_v = inverse * (cross_v - glm::dot(n, cross_v) * n);
    const Real b0 = glm::dot(p[1], n_u), b1 = glm::dot(p[1], n_v);
    const Real d00 = glm::dot(d, q.uu) - glm::dot(q.u, q.u),
               d11 = glm::dot(d, q.vv) - glm::dot(q.v, q.v);
    const Real d01 = glm::dot(d, q.uv) - glm::dot(q.u, q.v), det = d00 * d11 - d01 * d01;
    const Real f0 = glm::dot(d, q.u), f1 = glm::dot(d, q.v);
    const Real c0 = glm::dot(p[1], q.u), c1 = glm::dot(p[1], q.v);
    const auto u_of = [&](Real x, Real y) { return (d11 * x - d01 * y) / det; };
    const auto v_of = [&](Real x, Real y) { return (d00 * y - d01 * x) / det; };
    const Reduced k{glm::dot(p[1], n) - b0 * u_of(f0, f1) - b1 * v_of(f0, f1),
                    glm::dot(p[2], n) - b0 * u_of(c0, c1) - b1 * v_of(c0, c1)};
    const Real step = -k.f / k.r, x = -f0 - c0 * step, y = -f1 - c1 * step;
    const Real du = u_of(x, y), dv = v_of(x, y);
    out.normal = n, out.gap = glm::dot(n, d);
    const Real length = std::max({std::abs(step) / a.knots().domain().width(),
                                  std::abs(du) / u.width(), std::abs(dv) / v.width()});
    out.least_curvature = k.r / glm::dot(p[1], p[1]);
    if (fits(out.least_curvature, length, std::min(a.size(), b.size()))) {
      out.status = ContactStatus::degenerate;
      return out;
    }
    const Real part = length > kLongestStep ? kLongestStep / length : 1;
    const Place before = out.b;
    bool stays = walk(a.knots(), part * step, out.t);
    const auto over = [&](const Knots& knots, Real way, Real& at, Edge low) {
      const bool is_low = way < 0;
      if (!stays || walk(knots, way, at)) return;
      const Edge edge = is_low ? low : static_cast<Edge>(static_cast<int>(low) + 1);
      const auto next = b.across(out.b, edge);
      stays = next.has_value();
      if (next) out.b = *next;
    };
    over(face.u(), part * du, out.b.u, Edge::u_low);
    if (out.b.face == before.face) over(face.v(), part * dv, out.b.v, Edge::v_low);
    if (!stays) {
      out.status = ContactStatus::left_patch;
      return out;
    }
    if (length > kDone || out.b.face != before.face) continue;
    out.on_a = p[0] + step * p[1], out.on_b = q.s + du * q.u + dv * q.v;
    out.normal += du * n_u + dv * n_v;
    out.status =
        b.holds(out.b) ? judged(out, std::min(a.size(), b.size())) : ContactStatus::left_patch;
    return out;
  }
  return out;
}

namespace {

/// A point of curve a in the frame of b, with the velocities of the point and of its tangent.
struct CurvePoint {
  CurveDerivatives p;
  Vec3 velocity{0}, turning{0};  // of the point, and of the tangent
};
CurvePoint moved_point(const Wire& a, Real t, const Pose& a_in_b, const Twist& twist) {
  CurvePoint m{in_frame(a, t, a_in_b)};
  m.velocity = twist.linear + glm::cross(twist.angular, m.p[0] - a_in_b.position);
  m.turning = glm::cross(twist.angular, m.p[1]);
  return m;
}

}  // namespace

Moving moving_planar(const Wire& a, const Wire& b, const CurveMotion& of) {
  const CurvePoint m = moved_point(a, of.at.a.u, of.a_in_b, of.twist);
  const CurveDerivatives &p = m.p, q = evaluate(b.curve(), of.at.b.u, 2);
  const Real inverse = 1 / glm::length(q[1]);
  const Vec3 n = inverse * right_of(q[1]), d = p[0] - q[0], bend = right_of(q[2]);
  const Vec3 n_t = inverse * (bend - glm::dot(n, bend) * n);
  const Real m00 = glm::dot(p[2], n), m01 = glm::dot(p[1], n_t), m10 = glm::dot(p[1], q[1]),
             m11 = glm::dot(d, q[2]) - glm::dot(q[1], q[1]);
  const Real f0 = -glm::dot(m.turning, n), f1 = -glm::dot(m.velocity, q[1]);
  const Real det = m00 * m11 - m01 * m10;
  if (det == 0 || !std::isfinite(det)) return {};
  const Real t = (m11 * f0 - m01 * f1) / det, s = (m00 * f1 - m10 * f0) / det;
  return {{t, 0, s, 0}, t * p[1], s * q[1], s * n_t};
}

Moving moving_on_face(const Wire& a, const Skin& b, const CurveMotion& of) {
  const CurvePoint m = moved_point(a, of.at.a.u, of.a_in_b, of.twist);
  const Jet q = b.face(of.at.b.face).at(of.at.b.u, of.at.b.v);
  const CurveDerivatives& p = m.p;
  const Vec3 across = glm::cross(q.u, q.v), d = p[0] - q.s;
  const Real inverse = 1 / glm::length(across);
  const Vec3 n = inverse * across;
  const Vec3 cross_u = glm::cross(q.uu, q.v) + glm::cross(q.u, q.uv);
  const Vec3 cross_v = glm::cross(q.uv, q.v) + glm::cross(q.u, q.vv);
  const Vec3 n_u = inverse * (cross_u - glm::dot(n, cross_u) * n);
  const Vec3 n_v = inverse * (cross_v - glm::dot(n, cross_v) * n);
  const Real mixed = glm::dot(d, q.uv) - glm::dot(q.u, q.v);
  const Mat3 by(glm::dot(p[2], n), glm::dot(p[1], q.u), glm::dot(p[1], q.v), glm::dot(p[1], n_u),
                glm::dot(d, q.uu) - glm::dot(q.u, q.u), mixed, glm::dot(p[1], n_v), mixed,
                glm::dot(d, q.vv) - glm::dot(q.v, q.v));
  const Real det = glm::determinant(by);
  if (det == 0 || !std::isfinite(det)) return {};
  const Vec3 x = glm::inverse(by) * Vec3(-glm::dot(m.turning, n), -glm::dot(m.velocity, q.u),
                                         -glm::dot(m.velocity, q.v));
  return {{x[0], 0, x[1], x[2]}, x[0] * p[1], x[1] * q.u + x[2] * q.v, x[1] * n_u + x[2] * n_v};
}

}  // namespace pantin::detail::nurbs
