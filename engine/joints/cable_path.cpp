#include "engine/joints/cable_path.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/invariants.hpp"

namespace pantin::detail {
namespace {

/// Limit on how far consecutive pulleys may be askew, rad, and its sine.
constexpr Real kAskew = 0.02;

/// Least length of a straight part between circles, as a fraction of their shift.
constexpr Real kLeastPart = 1e-3;

/// A number that changes with time: value, first and second derivative.
struct Jet {
  Real x = 0, rate = 0, second = 0;
};
Jet operator+(Jet a, Jet b) { return {a.x + b.x, a.rate + b.rate, a.second + b.second}; }
Jet operator-(Jet a, Jet b) { return {a.x - b.x, a.rate - b.rate, a.second - b.second}; }
Jet operator*(Jet a, Jet b) {
  return {a.x * b.x, a.rate * b.x + a.x * b.rate,
          a.second * b.x + 2 * a.rate * b.rate + a.x * b.second};
}
Jet operator*(Real k, Jet a) { return {k * a.x, k * a.rate, k * a.second}; }

/// f(u), given f, f' and f''.
struct Taylor {
  Real value, first, second;
};
Jet chain(Jet u, Taylor f) {
  return {f.value, f.first * u.rate, f.first * u.second + f.second * u.rate * u.rate};
}
Jet root(Jet u) {
  const Real r = std::sqrt(u.x);
  return chain(u, {r, 0.5 / r, -0.25 / (r * u.x)});
}
Jet inverse(Jet u) { return chain(u, {1 / u.x, -1 / (u.x * u.x), 2 / (u.x * u.x * u.x)}); }
Jet arc_cosine(Jet u) {
  const Real s = 1 / std::sqrt(1 - u.x * u.x);
  return chain(u, {std::acos(u.x), -s, -u.x * s * s * s});
}
/// The angle of (x, y).
Jet angle_of(Jet x, Jet y) {
  const Real r = x.x * x.x + y.x * y.x;
  const Real rate = (x.x * y.rate - y.x * x.rate) / r;
  const Real second =
      (x.x * y.second - y.x * x.second) / r - 2 * rate * (x.x * x.rate + y.x * y.rate) / r;
  return {std::atan2(y.x, x.x), rate, second};
}

/// The same for a vector.
struct JetVec {
  Vec3 x, rate, second;
};
JetVec operator-(const JetVec& a, const JetVec& b) {
  return {a.x - b.x, a.rate - b.rate, a.second - b.second};
}
Jet dot(const JetVec& a, const JetVec& b) {
  return {glm::dot(a.x, b.x), glm::dot(a.rate, b.x) + glm::dot(a.x, b.rate),
          glm::dot(a.second, b.x) + 2 * glm::dot(a.rate, b.rate) + glm::dot(a.x, b.second)};
}
JetVec cross(const JetVec& a, const JetVec& b) {
  return {glm::cross(a.x, b.x), glm::cross(a.rate, b.x) + glm::cross(a.x, b.rate),
          glm::cross(a.second, b.x) + 2.0 * glm::cross(a.rate, b.rate) + glm::cross(a.x, b.second)};
}

JetVec centre_of(const PathPoint& p) { return {p.centre, p.velocity, p.acceleration}; }
JetVec axis_of(const PathPoint& p) { return {p.axis, p.axis_rate, p.axis_acceleration}; }

/// The shift of a straight part between two circles: the radius of `one` minus that of `other`, or
/// their sum where the cable crosses over.
Real shift_of(const PathPoint& one, const PathPoint& other) {
  const bool crosses = other.radius > 0 && one.radius > 0 && glm::dot(one.axis, other.axis) < 0;
  return crosses ? one.radius + other.radius : one.radius - other.radius;
}

/// Points inside a circle count as on it.
Real least_square(const PathPoint& one, const PathPoint& other) {
  const Real size = std::max({one.radius, other.radius, Real(1e-6)});
  return 1e-12 * size * size;
}

/// A neighbour of a pulley along the cable, seen from the pulley.
struct Neighbour {
  JetVec arm;            // from the pulley's centre to that of the neighbour
  Jet height, distance;  // along the pulley's axis, and from it
  Real shift = 0;
  Jet free_angle;  // at the pulley's centre, from the neighbour to where the cable touches
};

Neighbour neighbour_of(const PathPoint& pulley, const PathPoint& other) {
  Neighbour n;
  n.arm = centre_of(other) - centre_of(pulley);
  n.height = dot(n.arm, axis_of(pulley));
  n.shift = shift_of(pulley, other);
  Jet square = dot(n.arm, n.arm) - n.height * n.height;
  const Real least = n.shift * n.shift + least_square(pulley, other);
  if (square.x < least) square = {least};
  n.distance = root(square);
  n.free_angle = arc_cosine(n.shift * inverse(n.distance));
  return n;
}

/// A pulley with its neighbours along the cable.
struct Wrap {
  Neighbour from, to;
  Jet angle;  // of wrap
};

Wrap wrap_at(const PathPoint& before, const PathPoint& pulley, const PathPoint& after) {
  Wrap w{neighbour_of(pulley, before), neighbour_of(pulley, after), {}};
  const Jet along = dot(w.from.arm, w.to.arm) - w.from.height * w.to.height;
  const Jet across = dot(axis_of(pulley), cross(w.from.arm, w.to.arm));
  w.angle = angle_of(along, across) - w.from.free_angle - w.to.free_angle;
  w.angle.x += 2 * kPi * std::round((pulley.wrap - w.angle.x) / (2 * kPi));
  return w;
}

/// The points that a cable touches, by their indices, and its wraps there.
struct Touched {
  std::size_t count = 0, at[kMostPathPoints];
  Wrap wraps[kMostPathPoints];  // of those with a radius
};

/// Removes pulleys with a negative angle of wrap, the worst first. Their angles go to `passed`, by
/// index, where there is room.
Touched touched_by(std::span<const PathPoint> path, std::span<Real> passed = {}) {
  PANTIN_ASSERT(path.size() >= 2 && path.size() <= kMostPathPoints);
  Touched t;
  for (std::size_t i = 0; i < path.size(); ++i) t.at[t.count++] = i;
  const auto find = [&](std::size_t k) {
    if (k == 0 || k + 1 >= t.count || !(path[t.at[k]].radius > 0)) return;
    t.wraps[k] = wrap_at(path[t.at[k - 1]], path[t.at[k]], path[t.at[k + 1]]);
  };
  for (std::size_t k = 1; k + 1 < t.count; ++k) find(k);
  for (;;) {
    Real least = 0;
    std::size_t worst = 0;
    for (std::size_t k = 1; k + 1 < t.count; ++k) {
      if (!(path[t.at[k]].radius > 0)) continue;
      if (t.wraps[k].angle.x < least) least = t.wraps[k].angle.x, worst = k;
    }
    if (worst == 0) return t;
    if (!passed.empty()) passed[t.at[worst]] = least;
    std::copy(t.at + worst + 1, t.at + t.count, t.at + worst);
    std::copy(t.wraps + worst + 1, t.wraps + t.count, t.wraps + worst);
    --t.count;
    find(worst - 1), find(worst);
  }
}

/// Gradient of a pulley's arc by the centre of a neighbour, in the pulley's frame. `sense` is -1
/// for the neighbour before it, 1 for the one after it.
Vec3 arc_gradient(const PathPoint& pulley, const Neighbour& n, Real sense) {
  const Vec3 out = n.arm.x - n.height.x * pulley.axis;
  const Real r = n.distance.x, tangent = std::sqrt(r * r - n.shift * n.shift);
  return pulley.radius / (r * r) * (sense * glm::cross(pulley.axis, out) - n.shift / tangent * out);
}

}  // namespace

PathPoint path_point(const BodyState& body, Vec3 anchor, Vec3 axis, Real radius) {
  const Vec3 w = body.angular_velocity, arm = body.rotation_matrix * anchor;
  const Vec3 turned = body.rotation_matrix * axis;
  const Vec3 by_turn = glm::cross(w, arm), axis_rate = glm::cross(w, turned);
  return {body.position + arm,
          body.velocity + by_turn,
          glm::cross(w, by_turn),
          turned,
          axis_rate,
          glm::cross(w, axis_rate),
          radius};
}

PathLength path_length(std::span<const PathPoint> path, std::span<PathGradient> gradients) {
  const Touched t = touched_by(path);
  const bool wanted = gradients.size() >= path.size();
  if (wanted) std::fill(gradients.begin(), gradients.end(), PathGradient{});
  Jet length;
  for (std::size_t k = 0; k + 1 < t.count; ++k) {
    const PathPoint &a = path[t.at[k]], &b = path[t.at[k + 1]];
    const JetVec d = centre_of(b) - centre_of(a);
    const Real shift = shift_of(a, b), least = least_square(a, b);
    Jet square = dot(d, d) - Jet{shift * shift};
    if (square.x < least) square.x = least;
    const Jet part = root(square);
    length = length + part;
    if (!wanted) continue;
    gradients[t.at[k]].by_centre -= d.x / part.x, gradients[t.at[k + 1]].by_centre += d.x / part.x;
  }
  for (std::size_t k = 1; k + 1 < t.count; ++k) {
    const PathPoint& pulley = path[t.at[k]];
    if (!(pulley.radius > 0)) continue;
    const Wrap& w = t.wraps[k];
    length = length + pulley.radius * w.angle;
    if (!wanted) continue;
    const auto pull = [&](std::size_t at, const Neighbour& n, Real sense) {
      const Vec3 g = arc_gradient(pulley, n, sense);
      PathGradient& own = gradients[t.at[k]];
      gradients[at].by_centre += g;
      own.by_centre -= g, own.by_turn -= glm::cross(n.arm.x, g);
    };
    pull(t.at[k - 1], w.from, -1), pull(t.at[k + 1], w.to, 1);
  }
  return {length.x, length.second};
}

Real follow_path(std::span<const PathPoint> path, Real time, std::span<Real> wraps) {
  PANTIN_ASSERT(wraps.size() >= path.size());
  std::fill(wraps.begin(), wraps.end(), 0.0);
  const Touched t = touched_by(path, wraps);
  Real most = 0;
  for (std::size_t k = 0; k + 1 < t.count; ++k) {
    const PathPoint &a = path[t.at[k]], &b = path[t.at[k + 1]];
    if (k > 0 && a.radius > 0) wraps[t.at[k]] = t.wraps[k].angle.x;
    const Vec3 d = b.centre - a.centre;
    const Real shift = shift_of(a, b), least = kLeastPart * std::abs(shift);
    const Real part = std::sqrt(std::max(glm::dot(d, d) - shift * shift, Real(0)));
    const Real way = -time * glm::dot(d, b.velocity - a.velocity);
    most = std::max(most, part > least ? way / part - part : std::max(least - part, Real(1e-12)));
  }
  return most;
}

std::optional<PathFault> fault_of(std::span<const PathPoint> path) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const PathPoint &a = path[i], &b = path[i + 1];
    const Vec3 d = b.centre - a.centre;
    const Real distance = glm::length(d), least = std::abs(shift_of(a, b));
    if (!(distance > least)) return PathFault{i, false, distance, least};
    if (!(a.radius > 0 && b.radius > 0)) continue;
    const bool leans = glm::length(glm::cross(a.axis, b.axis)) > kAskew;
    if (leans || std::abs(glm::dot(d, a.axis)) > kAskew * distance)
      return PathFault{i, true, distance, least};
  }
  return std::nullopt;
}

void trace_path(std::span<const PathPoint> path, Real turn, std::vector<Vec3>& to) {
  const Touched t = touched_by(path);
  to.push_back(path[t.at[0]].centre);
  for (std::size_t k = 1; k < t.count; ++k) {
    const PathPoint& p = path[t.at[k]];
    if (k + 1 == t.count || !(p.radius > 0)) {
      to.push_back(p.centre);
      continue;
    }
    const Wrap& w = t.wraps[k];
    const Vec3 out = (w.from.arm.x - w.from.height.x * p.axis) / w.from.distance.x;
    const Vec3 across = glm::cross(p.axis, out);
    const int parts = std::max(1, static_cast<int>(std::ceil(w.angle.x / turn)));
    for (int i = 0; i <= parts; ++i) {
      const Real angle = w.from.free_angle.x + w.angle.x * i / parts;
      to.push_back(p.centre + p.radius * (std::cos(angle) * out + std::sin(angle) * across));
    }
  }
}

}  // namespace pantin::detail
