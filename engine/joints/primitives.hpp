#pragma once
/// What the equations of joints are made of: points, directions, and lengths of two bodies.
///
///   f, g    unit directions fixed in a and in b, world axes
///   d       from the point on a to the point on b
///   w       spin of a less that of b
///
/// Second derivatives hold away from the solution too. Header only: the solvers' inner loop.
/// [Nelson & Cohen, sec. 4, in angular velocities; the double cross products of gamma multiplied
/// out, so that a spin which both bodies share drops out and leaves no rounding behind]
#include "engine/joints/rows.hpp"

namespace pantin {

/// Axis 0 to 2 of a turn.
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
  const Mat3& turn;
  Quat frame;
  Vec3 x() const { return turn * axis_of(frame, 0); }
  Vec3 y() const { return turn * axis_of(frame, 1); }
  Vec3 z() const { return turn * axis_of(frame, 2); }
};
inline JointAxes axes_on_a(const Joint& joint, const Placed& a) {
  return {a.turn, joint.frames.a()};
}
inline JointAxes axes_on_b(const Joint& joint, const Placed& b) {
  return {b.turn, joint.frames.b()};
}

/// The two anchors: arms from the mass centres, and what lies between them.
struct AnchorSpan {
  Vec3 arm_a, arm_b;
  Vec3 d;        // from anchor to anchor
  Vec3 rate{0};  // d'
  Vec3 bend{0};  // what of d'' does not come from accelerations
};

/// `moving`: rate and bend are wanted too.
inline AnchorSpan span_of(const Joint& joint, const Placed& a, const Placed& b, bool moving) {
  AnchorSpan s;
  s.arm_a = a.turn * joint.anchor_a, s.arm_b = b.turn * joint.anchor_b;
  s.d = b.position + s.arm_b - a.position - s.arm_a;
  if (moving) {
    const Vec3 turn_a = glm::cross(a.spin, s.arm_a), turn_b = glm::cross(b.spin, s.arm_b);
    s.rate = b.velocity + turn_b - a.velocity - turn_a;
    s.bend = glm::cross(b.spin, turn_b) - glm::cross(a.spin, turn_a);
  }
  return s;
}

/// PT, rows 0 to 2: both anchors at one place, C = -d.
inline void write_point(const AnchorSpan& s, RowsOut out) {
  for (int i = 0; i < 3; ++i) {
    if (out.c) out.c[i] = -s.d[i];
    if (out.gamma) out.gamma[i] = s.bend[i];
  }
  if (out.point) out.point[0] = s.arm_a, out.point[1] = s.arm_b;
  if (!out.j) return;
  const Vec3 r = s.arm_a, q = s.arm_b;
  Vec3* j = out.j;
  j[0] = {1, 0, 0}, j[1] = {0, r.z, -r.y}, j[2] = {-1, 0, 0}, j[3] = {0, -q.z, q.y};
  j[4] = {0, 1, 0}, j[5] = {-r.z, 0, r.x}, j[6] = {0, -1, 0}, j[7] = {q.z, 0, -q.x};
  j[8] = {0, 0, 1}, j[9] = {r.y, -r.x, 0}, j[10] = {0, 0, -1}, j[11] = {-q.y, q.x, 0};
}

/// A scalar that depends on nothing but how both bodies are turned: J = (0, k, 0, -k).
struct TurnRow {
  Real c;
  Vec3 k;
  Real gamma;
  Real rate(const Placed& a, const Placed& b) const { return glm::dot(k, a.spin - b.spin); }
};
inline TurnRow operator+(const TurnRow& p, const TurnRow& q) {
  return {p.c + q.c, p.k + q.k, p.gamma + q.gamma};
}
inline TurnRow operator-(const TurnRow& p, const TurnRow& q) {
  return {p.c - q.c, p.k - q.k, p.gamma - q.gamma};
}

/// D1: C = f.g, gamma = w.w f.g - (w_a.g)(w.f) + (w_b.f)(w.g).
inline TurnRow dot_row(Vec3 f, Vec3 g, const Placed& a, const Placed& b) {
  const Vec3 w = a.spin - b.spin;
  const Real c = glm::dot(f, g);
  return {c, glm::cross(f, g),
          glm::dot(w, w) * c - glm::dot(a.spin, g) * glm::dot(w, f) +
              glm::dot(b.spin, f) * glm::dot(w, g)};
}

/// The angle theta = atan2(s, c), nearest on the circle to `before`, by the quotient rule:
///
///   theta' = (c s' - s c') / n,  n = s s + c c
///   theta'' = (c s'' - s c'') / n - theta' n' / n
///
/// Where n vanishes there is no angle: zeros.
inline TurnRow angle_row(const TurnRow& s, const TurnRow& c, const Placed& a, const Placed& b,
                         Real before) {
  const Real n = s.c * s.c + c.c * c.c;
  if (n < 1e-40) return {before, Vec3(0), 0};
  const Real p = c.c / n, q = s.c / n;
  const Vec3 k = p * s.k - q * c.k;
  const Real rs = s.rate(a, b), rc = c.rate(a, b);
  const Real angle = std::atan2(s.c, c.c);
  return {angle - 2 * kPi * std::round((angle - before) / (2 * kPi)), k,
          p * s.gamma - q * c.gamma + 2 * (p * rs - q * rc) * (p * rc + q * rs)};
}

/// The twist about x of b against a (see swing_twist): equal to the angle where the x axes agree.
inline TurnRow twist_row(const JointAxes& on_a, const JointAxes& on_b, const Placed& a,
                         const Placed& b, Real before) {
  const Vec3 ya = on_a.y(), za = on_a.z(), yb = on_b.y(), zb = on_b.z();
  return angle_row(dot_row(za, yb, a, b) - dot_row(ya, zb, a, b),
                   dot_row(ya, yb, a, b) + dot_row(za, zb, a, b), a, b, before);
}

inline void write_row(int row, const TurnRow& r, RowsOut out) {
  if (out.c) out.c[row] = r.c;
  if (out.gamma) out.gamma[row] = r.gamma;
  if (out.point) out.point[row - 1] = r.k;
  if (!out.j) return;
  Vec3* j = out.j + 4 * row;
  j[0] = Vec3(0), j[1] = r.k, j[2] = Vec3(0), j[3] = -r.k;
}

/// D1 at once: f and g stay square to each other.
inline void write_square(int row, Vec3 f, Vec3 g, const Placed& a, const Placed& b, RowsOut out) {
  write_row(row, dot_row(f, g, a, b), out);
}

/// D2: C = f.d, how far b's anchor lies along f.
inline void write_along(int row, Vec3 f, const AnchorSpan& s, const Placed& a, RowsOut out) {
  if (out.c) out.c[row] = glm::dot(f, s.d);
  if (out.gamma) {
    const Vec3 turning = glm::cross(a.spin, f);
    out.gamma[row] = -(glm::dot(glm::cross(a.spin, turning), s.d) +
                       2 * glm::dot(turning, s.rate) + glm::dot(f, s.bend));
  }
  if (!out.j) return;
  Vec3* j = out.j + 4 * row;
  j[0] = -f, j[1] = glm::cross(f, s.d + s.arm_a), j[2] = f, j[3] = glm::cross(s.arm_b, f);
}

/// DIST: C = (d.d - L L) / (2 L) with L above zero.
inline void write_distance(int row, Real length, const AnchorSpan& s, RowsOut out) {
  if (out.c) out.c[row] = (glm::dot(s.d, s.d) - length * length) / (2 * length);
  if (out.gamma) out.gamma[row] = -(glm::dot(s.rate, s.rate) + glm::dot(s.d, s.bend)) / length;
  if (!out.j) return;
  const Vec3 n = s.d / length;
  Vec3* j = out.j + 4 * row;
  j[0] = -n, j[1] = glm::cross(n, s.arm_a), j[2] = n, j[3] = glm::cross(s.arm_b, n);
}

/// The length |d| itself. Where the anchors meet it has no derivatives: zeros.
inline void write_length(int row, const AnchorSpan& s, RowsOut out) {
  const Real length = glm::length(s.d);
  const Real inverse = length > 1e-150 ? 1 / length : 0;
  const Vec3 n = s.d * inverse;
  if (out.c) out.c[row] = length;
  if (out.gamma) {
    const Vec3 across = s.rate - glm::dot(n, s.rate) * n;
    out.gamma[row] = -(glm::dot(across, across) * inverse + glm::dot(n, s.bend));
  }
  if (!out.j) return;
  Vec3* j = out.j + 4 * row;
  j[0] = -n, j[1] = glm::cross(n, s.arm_a), j[2] = n, j[3] = glm::cross(s.arm_b, n);
}

}  // namespace pantin
