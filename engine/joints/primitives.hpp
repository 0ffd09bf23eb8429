#pragma once
/// Building blocks of joint equations: points, directions and lengths of two bodies.
///
///   f, g    unit directions fixed in a and in b, world axes
///   d       from the point on a to the point on b
///   w       angular velocity of a minus that of b
///
/// Second derivatives are exact away from the solution too. Header only, for the solvers' inner
/// loop. [Nelson & Cohen, sec. 4, in angular velocities; the double cross products of gamma
/// multiplied out, so that a common angular velocity cancels without rounding errors]
#include "engine/joints/rows.hpp"

namespace pantin::detail {

/// Axis 0 to 2 of a rotation.
inline Vec3 axis_of(Quat q, int i) {
  if (i == 0)
    return {1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y + q.w * q.z),
            2 * (q.x * q.z - q.w * q.y)};
  if (i == 1)
    return {2 * (q.x * q.y - q.w * q.z), 1 - 2 * (q.x * q.x + q.z * q.z),
            2 * (q.y * q.z + q.w * q.x)};
  return {2 * (q.x * q.z + q.w * q.y), 2 * (q.y * q.z - q.w * q.x),
          1 - 2 * (q.x * q.x + q.y * q.y)};
}

/// The joint axes on one body, world axes: x is k, y is u, z is v of the method's tables.
struct JointAxes {
  const Mat3& rotation_matrix;
  Quat frame;
  Vec3 x() const { return rotation_matrix * axis_of(frame, 0); }
  Vec3 y() const { return rotation_matrix * axis_of(frame, 1); }
  Vec3 z() const { return rotation_matrix * axis_of(frame, 2); }
};
inline JointAxes axes_on_a(const Joint& joint, const BodyState& a) {
  return {a.rotation_matrix, joint.frames.a()};
}
inline JointAxes axes_on_b(const Joint& joint, const BodyState& b) {
  return {b.rotation_matrix, joint.frames.b()};
}

/// The two anchors: arms from the mass centres, and the vector between them.
struct AnchorSpan {
  Vec3 arm_a, arm_b;
  Vec3 d;                     // from anchor to anchor
  Vec3 rate{0};               // d'
  Vec3 bias_acceleration{0};  // part of d'' that does not depend on accelerations
  Vec3 angular_velocity{0};   // of a
};

/// Fills the terms that depend on velocities only if `out` takes gamma.
inline AnchorSpan span_of(const Joint& joint, const BodyState& a, const BodyState& b,
                          const RowsOut& out) {
  AnchorSpan s;
  s.arm_a = a.rotation_matrix * joint.anchor_a, s.arm_b = b.rotation_matrix * joint.anchor_b;
  s.d = b.position + s.arm_b - a.position - s.arm_a;
  if (out.gamma) {
    const Vec3 velocity_a = glm::cross(a.angular_velocity, s.arm_a),
               velocity_b = glm::cross(b.angular_velocity, s.arm_b);
    s.rate = b.velocity + velocity_b - a.velocity - velocity_a;
    s.bias_acceleration =
        glm::cross(b.angular_velocity, velocity_b) - glm::cross(a.angular_velocity, velocity_a);
    s.angular_velocity = a.angular_velocity;
  }
  return s;
}

/// Rows 0 to 2: coincident anchors, C = -d.
inline void write_point(const AnchorSpan& s, RowsOut out) {
  for (int i = 0; i < 3; ++i) {
    if (out.c) out.c[i] = -s.d[i];
    if (out.gamma) out.gamma[i] = s.bias_acceleration[i];
  }
  if (out.point) out.point[0] = s.arm_a, out.point[1] = s.arm_b;
  if (!out.j) return;
  const Vec3 r = s.arm_a, q = s.arm_b;
  Vec3* j = out.j;
  j[0] = {1, 0, 0}, j[1] = {0, r.z, -r.y}, j[2] = {-1, 0, 0}, j[3] = {0, -q.z, q.y};
  j[4] = {0, 1, 0}, j[5] = {-r.z, 0, r.x}, j[6] = {0, -1, 0}, j[7] = {q.z, 0, -q.x};
  j[8] = {0, 0, 1}, j[9] = {r.y, -r.x, 0}, j[10] = {0, 0, -1}, j[11] = {-q.y, q.x, 0};
}

inline Vec3 relative_angular_velocity(const BodyState& a, const BodyState& b) {
  return a.angular_velocity - b.angular_velocity;
}

/// A scalar that depends on the rotations of both bodies only: J = (0, k, 0, -k).
struct AngularRow {
  Real c;
  Vec3 k;
  Real gamma;
  Real rate(Vec3 w) const { return glm::dot(k, w); }
};
inline AngularRow operator+(const AngularRow& p, const AngularRow& q) {
  return {p.c + q.c, p.k + q.k, p.gamma + q.gamma};
}
inline AngularRow operator-(const AngularRow& p, const AngularRow& q) {
  return {p.c - q.c, p.k - q.k, p.gamma - q.gamma};
}

/// D1: f and g stay perpendicular, C = f.g, gamma = w.w f.g - (w_a.g)(w.f) + (w_b.f)(w.g).
inline AngularRow dot_row(Vec3 f, Vec3 g, const BodyState& a, const BodyState& b) {
  const Vec3 w = relative_angular_velocity(a, b);
  const Real c = glm::dot(f, g);
  return {c, glm::cross(f, g),
          glm::dot(w, w) * c - glm::dot(a.angular_velocity, g) * glm::dot(w, f) +
              glm::dot(b.angular_velocity, f) * glm::dot(w, g)};
}

/// The angle theta = atan2(s, c), unwrapped to be nearest to `before`, by the quotient rule:
///
///   theta' = (c s' - s c') / n,  n = s s + c c
///   theta'' = (c s'' - s c'') / n - theta' n' / n
///
/// Where n vanishes the angle is undefined: zeros.
inline AngularRow angle_row(const AngularRow& s, const AngularRow& c, Vec3 w, Real before) {
  const Real n = s.c * s.c + c.c * c.c;
  if (n < 1e-40) return {before, Vec3(0), 0};
  const Real p = c.c / n, q = s.c / n;
  const Vec3 k = p * s.k - q * c.k;
  const Real rs = s.rate(w), rc = c.rate(w);
  const Real angle = std::atan2(s.c, c.c);
  return {angle - 2 * kPi * std::round((angle - before) / (2 * kPi)), k,
          p * s.gamma - q * c.gamma + 2 * (p * rs - q * rc) * (p * rc + q * rs)};
}

/// The twist about x of b relative to a (see swing_twist); the joint angle where the x axes agree.
/// With the axes x_a and x_b, and the relative rotation q:
///
///   theta = 2 atan2(q_x, q_w)
///   theta' = u.(w_b - w_a),  u = (x_a + x_b) / (1 + x_a.x_b),  1 + x_a.x_b = 2 (q_w^2 + q_x^2)
///
/// Where the axes are opposite the angle is undefined: zeros.
inline AngularRow twist_row(const Joint& joint, const BodyState& a, const BodyState& b,
                            Real before) {
  const Quat on_a = a.rotation * joint.frames.a(), on_b = b.rotation * joint.frames.b();
  const Quat q = glm::conjugate(on_a) * on_b;
  const Real n = 2 * (q.w * q.w + q.x * q.x);
  if (n < 1e-20) return {before, Vec3(0), 0};
  const Vec3 xa = axis_of(on_a, 0), xb = axis_of(on_b, 0), w = relative_angular_velocity(a, b);
  const Vec3 u = (xa + xb) / n;
  const Vec3 rate = glm::cross(a.angular_velocity, xa) + glm::cross(b.angular_velocity, xb);
  const Real angle = 2 * std::atan2(q.x, q.w);
  return {angle - 2 * kPi * std::round((angle - before) / (2 * kPi)), -u,
          glm::dot(rate, w) / n - glm::dot(u, w) * glm::dot(w, glm::cross(xa, xb)) / n};
}

inline void write_row(int row, const AngularRow& r, RowsOut out) {
  if (out.c) out.c[row] = r.c;
  if (out.gamma) out.gamma[row] = r.gamma;
  if (out.point) out.point[row - 1] = r.k;
  if (!out.j) return;
  Vec3* j = out.j + 4 * row;
  j[0] = Vec3(0), j[1] = r.k, j[2] = Vec3(0), j[3] = -r.k;
}

/// D2: C = f.d, the travel of b's anchor along f.
inline void write_along(int row, Vec3 f, const AnchorSpan& s, RowsOut out) {
  if (out.c) out.c[row] = glm::dot(f, s.d);
  if (out.gamma) {
    const Vec3 turning = glm::cross(s.angular_velocity, f);
    out.gamma[row] = -(glm::dot(glm::cross(s.angular_velocity, turning), s.d) +
                       2 * glm::dot(turning, s.rate) + glm::dot(f, s.bias_acceleration));
  }
  if (!out.j) return;
  Vec3* j = out.j + 4 * row;
  j[0] = -f, j[1] = glm::cross(f, s.d + s.arm_a), j[2] = f, j[3] = glm::cross(s.arm_b, f);
}

/// DIST: C = (d.d - L L) / (2 L) with L above zero.
inline void write_distance(int row, Real length, const AnchorSpan& s, RowsOut out) {
  if (out.c) out.c[row] = (glm::dot(s.d, s.d) - length * length) / (2 * length);
  if (out.gamma)
    out.gamma[row] = -(glm::dot(s.rate, s.rate) + glm::dot(s.d, s.bias_acceleration)) / length;
  if (!out.j) return;
  const Vec3 n = s.d / length;
  Vec3* j = out.j + 4 * row;
  j[0] = -n, j[1] = glm::cross(n, s.arm_a), j[2] = n, j[3] = glm::cross(s.arm_b, n);
}

/// The length |d|. Where the anchors coincide it has no derivatives: zeros.
inline void write_length(int row, const AnchorSpan& s, RowsOut out) {
  const Real length = glm::length(s.d);
  const Real inverse = length > 1e-150 ? 1 / length : 0;
  const Vec3 n = s.d * inverse;
  if (out.c) out.c[row] = length;
  if (out.gamma) {
    const Vec3 across = s.rate - glm::dot(n, s.rate) * n;
    out.gamma[row] = -(glm::dot(across, across) * inverse + glm::dot(n, s.bias_acceleration));
  }
  if (!out.j) return;
  Vec3* j = out.j + 4 * row;
  j[0] = -n, j[1] = glm::cross(n, s.arm_a), j[2] = n, j[3] = glm::cross(s.arm_b, n);
}

}  // namespace pantin::detail
