#include "engine/nurbs/common_normal.hpp"

#include <algorithm>
#include <cmath>

#include "engine/nurbs/pair_descent.hpp"

namespace pantin::detail::nurbs {

const char* word_of(ContactStatus status) {
  switch (status) {
    case ContactStatus::found:
      return "found";
    case ContactStatus::left_patch:
      return "ContactLeftPatch";
    case ContactStatus::singular:
      return "SurfaceSingular";
    case ContactStatus::degenerate:
      return "ContactDegenerate";
    case ContactStatus::lost:
      return "lost";
  }
  return "";
}

Jet in_frame(const Jet& j, const Mat3& r, Vec3 origin) {
  return {r * j.s + origin, r * j.u, r * j.v, r * j.uu, r * j.uv, r * j.vv};
}

namespace {

constexpr int kMostIterations = 24;
constexpr Real kLongestStep = 0.25;  // of a domain
constexpr Real kDone = 1e-9;         // of a domain: the error after such a step is its square
constexpr Real kNoNormal = 1e-9;     // of size^2
constexpr Real kFits = 1e-6;         // curvature, of 1 / size
constexpr Real kStray = 1e-3;        // of a domain: larger steps are tested for fit

/// The 2 x 2 blocks of F and of its derivative [A B; C D] by the parameters of a and b.
struct System {
  Real f[4];
  Real a[2][2], b[2][2], c[2][2], d[2][2];
  Vec3 n{0}, n_u{0}, n_v{0};
  Real gap = 0, normal_length = 0;
};

System system_of(const Jet& p, const Jet& q) {
  System m;
  const Vec3 across = glm::cross(q.u, q.v), d = p.s - q.s;
  m.normal_length = glm::length(across);
  const Real inverse = 1 / m.normal_length;
  const Vec3 n = inverse * across;
  const Vec3 cross_u = glm::cross(q.uu, q.v) + glm::cross(q.u, q.uv);
  const Vec3 cross_v = glm::cross(q.uv, q.v) + glm::cross(q.u, q.vv);
  const Vec3 n_u = inverse * (cross_u - glm::dot(n, cross_u) * n);
  const Vec3 n_v = inverse * (cross_v - glm::dot(n, cross_v) * n);
  m.n = n, m.n_u = n_u, m.n_v = n_v, m.gap = glm::dot(n, d);
  m.f[0] = glm::dot(p.u, n), m.f[1] = glm::dot(p.v, n);
  m.f[2] = glm::dot(d, q.u), m.f[3] = glm::dot(d, q.v);
  m.a[0][0] = glm::dot(p.uu, n), m.a[0][1] = m.a[1][0] = glm::dot(p.uv, n);
  m.a[1][1] = glm::dot(p.vv, n);
  m.b[0][0] = glm::dot(p.u, n_u), m.b[0][1] = glm::dot(p.u, n_v);
  m.b[1][0] = glm::dot(p.v, n_u), m.b[1][1] = glm::dot(p.v, n_v);
  m.c[0][0] = glm::dot(p.u, q.u), m.c[0][1] = glm::dot(p.v, q.u);
  m.c[1][0] = glm::dot(p.u, q.v), m.c[1][1] = glm::dot(p.v, q.v);
  m.d[0][0] = glm::dot(d, q.uu) - glm::dot(q.u, q.u);
  m.d[0][1] = m.d[1][0] = glm::dot(d, q.uv) - glm::dot(q.u, q.v);
  m.d[1][1] = glm::dot(d, q.vv) - glm::dot(q.v, q.v);
  return m;
}

/// The Schur complement for the parameters of a: the second derivative of the gap along a, while b
/// follows.
struct Reduced {
  Real r[2][2];
  Real d_inverse[2][2];
  Real determinant = 0;  // of r
  bool is_regular = false;
};

Reduced reduced(const System& m) {
  Reduced out;
  const Real dd = m.d[0][0] * m.d[1][1] - m.d[0][1] * m.d[1][0];
  const Real inverse = 1 / dd;
  out.d_inverse[0][0] = m.d[1][1] * inverse, out.d_inverse[0][1] = -m.d[0][1] * inverse;
  out.d_inverse[1][0] = -m.d[1][0] * inverse, out.d_inverse[1][1] = m.d[0][0] * inverse;
  for (int i = 0; i < 2; ++i) {
    Real row[2];
    for (int j = 0; j < 2; ++j)
      row[j] = m.b[i][0] * out.d_inverse[0][j] + m.b[i][1] * out.d_inverse[1][j];
    for (int j = 0; j < 2; ++j) out.r[i][j] = m.a[i][j] - row[0] * m.c[0][j] - row[1] * m.c[1][j];
  }
  out.determinant = out.r[0][0] * out.r[1][1] - out.r[0][1] * out.r[1][0];
  out.is_regular = dd != 0 && out.determinant != 0 && std::isfinite(out.determinant);
  return out;
}

// Solves [A B; C D] s = right.
std::array<Real, 4> solved(const System& m, const Reduced& k, const std::array<Real, 4>& right) {
  const Real* const dr[2] = {k.d_inverse[0], k.d_inverse[1]};
  const Real y0 = dr[0][0] * right[2] + dr[0][1] * right[3];
  const Real y1 = dr[1][0] * right[2] + dr[1][1] * right[3];
  const Real g0 = right[0] - m.b[0][0] * y0 - m.b[0][1] * y1;
  const Real g1 = right[1] - m.b[1][0] * y0 - m.b[1][1] * y1;
  const Real inverse = 1 / k.determinant;
  const Real u = (k.r[1][1] * g0 - k.r[0][1] * g1) * inverse;
  const Real v = (k.r[0][0] * g1 - k.r[1][0] * g0) * inverse;
  const Real h0 = right[2] - m.c[0][0] * u - m.c[0][1] * v;
  const Real h1 = right[3] - m.c[1][0] * u - m.c[1][1] * v;
  return {u, v, dr[0][0] * h0 + dr[0][1] * h1, dr[1][0] * h0 + dr[1][1] * h1};
}

// The smaller curvature of the gap: the smaller eigenvalue of r in the metric of a.
Real least_curvature(const Reduced& k, const Jet& p) {
  const Real e = glm::dot(p.u, p.u), f = glm::dot(p.u, p.v), g = glm::dot(p.v, p.v);
  const Real metric = e * g - f * f;
  const Real mean = (k.r[0][0] * g - (k.r[0][1] + k.r[1][0]) * f + k.r[1][1] * e) / (2 * metric);
  const Real product = k.determinant / metric;
  const Real far = mean + std::copysign(std::sqrt(std::max(mean * mean - product, 0.0)), mean);
  return far == 0 ? 0 : std::min(far, product / far);
}

bool is_singular(const Face& face, Real normal_length) {
  const Real area = normal_length * face.u().domain().width() * face.v().domain().width();
  return !(area > kNoNormal * face.size() * face.size());
}

/// One parameter after a step: within its domain, or out across an edge.
struct Walk {
  bool is_out = false, is_high = false;
  Edge edge_if(Edge low, Edge high) const { return is_high ? high : low; }
};

// Moves a parameter. A step out of the domain that starts at its end leaves across the edge `low`
// or the one after it.
void walk(const Knots& k, Real step, Real& t, Walk& out) {
  const Range domain = k.domain();
  const Real to = t + step;
  if (!k.is_periodic) {
    if (to < domain.low && t == domain.low) out.is_out = true;
    if (to > domain.high && t == domain.high) out.is_out = out.is_high = true;
  }
  t = k.inside(to);
}

class Newton {
 public:
  explicit Newton(const Meeting& of)
      : a_(of.a),
        b_(of.b),
        turn_(glm::mat3_cast(of.a_in_b.rotation)),
        origin_(of.a_in_b.position) {}

  CommonNormal from(const PlacePair& start);
  Moving moving_at(const PlacePair& at, const Twist& twist) const;

 private:
  Jet jet_a(const Place& at) const {
    return in_frame(a_.face(at.face).at(at.u, at.v), turn_, origin_);
  }
  Jet jet_b(const Place& at) const { return b_.face(at.face).at(at.u, at.v); }
  Real longest(const std::array<Real, 4>& step, const PlacePair& at) const;
  bool move(const std::array<Real, 4>& step, PlacePair& at) const;
  void finish(const Jet& p, const Jet& q, const std::array<Real, 4>& step, CommonNormal& out) const;

  const Skin &a_, &b_;
  Mat3 turn_;
  Vec3 origin_;
};

// Largest component of a step, in units of the domains.
Real Newton::longest(const std::array<Real, 4>& step, const PlacePair& at) const {
  const Face &fa = a_.face(at.a.face), &fb = b_.face(at.b.face);
  return std::max(std::max(std::abs(step[0]) / fa.u().domain().width(),
                           std::abs(step[1]) / fa.v().domain().width()),
                  std::max(std::abs(step[2]) / fb.u().domain().width(),
                           std::abs(step[3]) / fb.v().domain().width()));
}

// Applies a step; false if the pair leaves across a rim.
bool Newton::move(const std::array<Real, 4>& step, PlacePair& at) const {
  const auto go = [](const Skin& skin, Place& place, Real du, Real dv) {
    const Face& face = skin.face(place.face);
    Walk by_u, by_v;
    walk(face.u(), du, place.u, by_u), walk(face.v(), dv, place.v, by_v);
    if (!by_u.is_out && !by_v.is_out) return true;
    const Edge edge = by_v.is_out ? by_v.edge_if(Edge::v_low, Edge::v_high)
                                  : by_u.edge_if(Edge::u_low, Edge::u_high);
    const auto to = skin.across(place, edge);
    if (to) place = *to;
    return to.has_value();
  };
  return go(a_, at.a, step[0], step[1]) && go(b_, at.b, step[2], step[3]);
}

// Points after a last step, to first order: it is so short that its square is negligible.
void Newton::finish(const Jet& p, const Jet& q, const std::array<Real, 4>& step,
                    CommonNormal& out) const {
  out.on_a = p.s + step[0] * p.u + step[1] * p.v;
  out.on_b = q.s + step[2] * q.u + step[3] * q.v;
  const bool faces = glm::dot(glm::cross(p.u, p.v), out.normal) < 0;
  out.status = faces ? ContactStatus::found : ContactStatus::lost;
  const Real size = std::min(a_.size(), b_.size());
  if (faces && std::abs(out.least_curvature) * size < kFits) out.status = ContactStatus::degenerate;
  if (faces && !(a_.holds(out.at.a) && b_.holds(out.at.b))) out.status = ContactStatus::left_patch;
}

CommonNormal Newton::from(const PlacePair& start) {
  CommonNormal out;
  out.at = start;
  for (; out.iterations < kMostIterations;) {
    const Jet p = jet_a(out.at.a), q = jet_b(out.at.b);
    ++out.iterations;
    const System m = system_of(p, q);
    if (is_singular(b_.face(out.at.b.face), m.normal_length) ||
        is_singular(a_.face(out.at.a.face), glm::length(glm::cross(p.u, p.v)))) {
      out.status = ContactStatus::singular;
      return out;
    }
    const Reduced k = reduced(m);
    out.gap = m.gap, out.normal = m.n;
    if (!k.is_regular) {
      out.status = ContactStatus::degenerate;
      return out;
    }
    std::array<Real, 4> step = solved(m, k, {-m.f[0], -m.f[1], -m.f[2], -m.f[3]});
    const Real length = longest(step, out.at);
    if (!std::isfinite(length)) return out;
    // Where the surfaces fit one another, the steps are rounding errors only.
    const Real size = std::min(a_.size(), b_.size());
    if (length > kStray && std::abs(least_curvature(k, p)) * size < kFits) {
      out.status = ContactStatus::degenerate;
      return out;
    }
    if (length > kLongestStep)
      for (Real& x : step) x *= kLongestStep / length;
    const PlacePair before = out.at;
    if (!move(step, out.at)) {
      out.status = ContactStatus::left_patch;
      return out;
    }
    if (length > kDone) continue;
    // A step that crossed an edge is repeated on the next face.
    const bool is_cut = out.at.a.face != before.a.face || out.at.b.face != before.b.face;
    if (is_cut) continue;
    out.least_curvature = least_curvature(k, p);
    out.normal += step[2] * m.n_u + step[3] * m.n_v;
    finish(p, q, step, out);
    return out;
  }
  return out;
}

// The time derivative of F at fixed parameters.
Moving Newton::moving_at(const PlacePair& at, const Twist& twist) const {
  const Jet p = jet_a(at.a), q = jet_b(at.b);
  const System m = system_of(p, q);
  const Reduced k = reduced(m);
  if (!k.is_regular) return {};
  const Vec3 velocity = twist.linear + glm::cross(twist.angular, p.s - origin_);
  const auto rates = solved(m, k,
                            {-glm::dot(glm::cross(twist.angular, p.u), m.n),
                             -glm::dot(glm::cross(twist.angular, p.v), m.n),
                             -glm::dot(velocity, q.u), -glm::dot(velocity, q.v)});
  return {rates, rates[0] * p.u + rates[1] * p.v, rates[2] * q.u + rates[3] * q.v,
          rates[2] * m.n_u + rates[3] * m.n_v};
}

}  // namespace

CommonNormal track_newton(const Meeting& of, const PlacePair& from) {
  return Newton(of).from(from);
}

CommonNormal track(const Meeting& of, const PlacePair& from) {
  const CommonNormal direct = track_newton(of, from);
  if (direct.status != ContactStatus::lost) return direct;
  CommonNormal again = track_newton(of, descend(of, from).at);
  again.iterations += direct.iterations;
  return again;
}

std::array<Real, 4> rates(const Meeting& of, const PlacePair& at, const Twist& twist) {
  return Newton(of).moving_at(at, twist).rates;
}

Moving moving(const Meeting& of, const PlacePair& at, const Twist& twist) {
  return Newton(of).moving_at(at, twist);
}

PlacePair predicted(const Meeting& of, const PlacePair& at, std::array<Real, 4> rates, Real time) {
  PlacePair to = at;
  const Face &fa = of.a.face(at.a.face), &fb = of.b.face(at.b.face);
  to.a.u = fa.u().inside(at.a.u + rates[0] * time);
  to.a.v = fa.v().inside(at.a.v + rates[1] * time);
  to.b.u = fb.u().inside(at.b.u + rates[2] * time);
  to.b.v = fb.v().inside(at.b.v + rates[3] * time);
  return to;
}

}  // namespace pantin::detail::nurbs
