#pragma once
/// Elimination of one body in a step by the energy-momentum method; see conserving.hpp.
#include "engine/solvers/articulated/kernels/inward.hpp"

namespace pantin::detail::articulated {
namespace {

/// A body with its outboard subtree, before its rotation is eliminated; each row is followed by the
/// component of a vector.
struct ConservingBlock {
  Rows tt, ty, yt, yy;  // ty: | torque impulse to be made; yy: | momentum, or nothing
  Vec<double> impulse;  // at the own joint, from the parent
  Vec<double> torque;   // impulse about the own joint, which has to vanish
};
static_assert(kConservingBlock == 4 * 12 + 2 * 3);

template <class T>
struct Axes {
  Vec<T> d[3];
};
/// The columns of the rotation matrix.
INLINE Axes<Four> axes_of(Qua<Four> q) {
  const Four xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z,
             yz = q.y * q.z, wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  const Four one = all(1.0);
  return {{{one - 2.0 * (yy + zz), 2.0 * (xy + wz), 2.0 * (xz - wy)},
           {2.0 * (xy - wz), one - 2.0 * (xx + zz), 2.0 * (yz + wx)},
           {2.0 * (xz + wy), 2.0 * (yz - wx), one - 2.0 * (xx + yy)}}};
}
INLINE Vec<Four> along(const Axes<Four>& r, Vec<Four> v) {
  return v.x * r.d[0] + v.y * r.d[1] + v.z * r.d[2];
}

/// A sum of outer products a b^T, by rows.
struct Outer {
  Vec<Four> x{all(0), all(0), all(0)}, y = x, z = x;
  INLINE void add(Vec<Four> a, Vec<Four> b) { x = x + a.x * b, y = y + a.y * b, z = z + a.z * b; }
  /// Minus the trace, on the diagonal: a (b . t) - t (a . b), the turned a crossed with b.
  INLINE void put_crossed(double* k, std::size_t row) const {
    const Four trace = x.x + y.y + z.z;
    put(k, row, Vec<Four>{x.x - trace, x.y, x.z});
    put(k, row + 3, Vec<Four>{y.x, y.y - trace, y.z});
    put(k, row + 6, Vec<Four>{z.x, z.y, z.z - trace});
  }
};

/// The block of a body without its children.
template <Unknown unknown>
INLINE void add_own(const IslandView& p, double per, std::size_t i, ConservingBlock& b) {
  const double* k = column(p.work, kWorkRows, i);
  const double mass = num<double>(column(p.constants, kConstantRows, i), kMass);
  const double m = unknown == Unknown::displacement ? mass * per : mass;
  const std::size_t arm_row = unknown == Unknown::displacement ? kMeanArm : kEndArm;
  const Vec<double> e = m * vec<double>(k, arm_row), e1 = m * vec<double>(k, kEndArm);
  const Vec<double> t = vec<double>(k, kTorqueImpulse), f = vec<double>(k, kImpulse);
  const Vec<double> x = vec<double>(k, kTurn), y = vec<double>(k, kTurn + 3),
                    z = vec<double>(k, kTurn + 6);
  b.tt.x += Four{x.x, x.y, x.z, 0}, b.tt.y += Four{y.x, y.y, y.z, 0};
  b.tt.z += Four{z.x, z.y, z.z, 0};
  b.ty.x += Four{0, -e.z, e.y, -t.x}, b.ty.y += Four{e.z, 0, -e.x, -t.y};
  b.ty.z += Four{-e.y, e.x, 0, -t.z};
  b.yt.x += Four{0, e1.z, -e1.y, 0}, b.yt.y += Four{-e1.z, 0, e1.x, 0};
  b.yt.z += Four{e1.y, -e1.x, 0, 0};
  const bool moves = unknown == Unknown::velocity;
  b.yy.x += Four{m, 0, 0, moves ? f.x : 0}, b.yy.y += Four{0, m, 0, moves ? f.y : 0};
  b.yy.z += Four{0, 0, m, moves ? f.z : 0};
  if (!moves) b.impulse = b.impulse + f, b.torque = b.torque + t;
}

/// Cross product of a row's first three components with r.
INLINE Four row_cross(Four row, Vec<double> r) {
  return Four{row[1] * r.z - row[2] * r.y, row[2] * r.x - row[0] * r.z, row[0] * r.y - row[1] * r.x,
              0};
}

/// Adds an eliminated child, given as mass | bias at its joint and the impulse there.
template <Unknown unknown>
INLINE void add_child(ConservingBlock& b, const Rows& child, Vec<double> impulse, const double* k) {
  const Vec<double> r1 = vec<double>(k, kEndReach);
  const Vec<double> r = unknown == Unknown::displacement ? vec<double>(k, kMeanReach) : r1;
  b.yy.x += child.x, b.yy.y += child.y, b.yy.z += child.z;
  b.yt.x -= row_cross(child.x, r1), b.yt.y -= row_cross(child.y, r1);
  b.yt.z -= row_cross(child.z, r1);
  const Four kx = r.y * child.z - r.z * child.y, ky = r.z * child.x - r.x * child.z,
             kz = r.x * child.y - r.y * child.x;
  b.ty.x += kx, b.ty.y += ky, b.ty.z += kz;
  b.tt.x -= row_cross(kx, r1), b.tt.y -= row_cross(ky, r1), b.tt.z -= row_cross(kz, r1);
  if (unknown == Unknown::velocity) return;
  const Vec<double> f = 0.5 * impulse, t = cross(r, impulse);
  const double along = dot(f, r1);
  b.tt.x += Four{r1.x * f.x - along, r1.x * f.y, r1.x * f.z, 0};
  b.tt.y += Four{r1.y * f.x, r1.y * f.y - along, r1.y * f.z, 0};
  b.tt.z += Four{r1.z * f.x, r1.z * f.y, r1.z * f.z - along, 0};
  b.ty.x[3] -= t.x, b.ty.y[3] -= t.y, b.ty.z[3] -= t.z;
  b.impulse = b.impulse + impulse, b.torque = b.torque + t;
}

/// Columns of the inverse of a 3x3 matrix, given by its rows.
struct Inverse {
  Vec<double> u, v, w;
  INLINE Inverse(Four a, Four b, Four c) {
    const Vec<double> x{a[0], a[1], a[2]}, y{b[0], b[1], b[2]}, z{c[0], c[1], c[2]};
    const Vec<double> yz = cross(y, z);
    const double per_det = 1 / dot(x, yz);
    u = per_det * yz, v = per_det * cross(z, x), w = per_det * cross(x, y);
  }
};

/// Refers the equations of the rotation to axes that rotate with the body (the mean of its axes
/// before and after). A torque left by an iteration would otherwise couple the rotation about the
/// axis of a thin body with those across it, where its inertia is larger by orders of magnitude.
/// `turned` is Cayley's vector of the rotation over the step.
INLINE void turn_axes(ConservingBlock& b, Vec<double> turned) {
  const Vec<double> n = 0.5 * b.torque, d = -0.5 * turned;
  const double along = dot(n, d);
  b.tt.x += Four{n.x * d.x - along, n.x * d.y - n.z, n.x * d.z + n.y, 0};
  b.tt.y += Four{n.y * d.x + n.z, n.y * d.y - along, n.y * d.z - n.x, 0};
  b.tt.z += Four{n.z * d.x - n.y, n.z * d.y + n.x, n.z * d.z - along, 0};
}

/// Eliminates the rotation, given the inverse of tt: mass | bias at the own joint; both go to the
/// node.
INLINE Rows eliminate(const ConservingBlock& b, const Inverse& inverse, double* node) {
  const auto& [u, v, w] = inverse;
  const Rows response{u.x * b.ty.x + v.x * b.ty.y + w.x * b.ty.z,
                      u.y * b.ty.x + v.y * b.ty.y + w.y * b.ty.z,
                      u.z * b.ty.x + v.z * b.ty.y + w.z * b.ty.z};
  response.to(node + kResponse);
  const auto less = [&](Four yy, Four yt) {
    return ((yy - yt[0] * response.x) - yt[1] * response.y) - yt[2] * response.z;
  };
  const Rows mass{less(b.yy.x, b.yt.x), less(b.yy.y, b.yt.y), less(b.yy.z, b.yt.z)};
  mass.to(node + kArticulatedMass);
  return mass;
}

/// What the ties of a body add to its block (kTieBlock numbers), of displacements only.
INLINE void add_ties(ConservingBlock& b, const double* t) {
  b.tt.x += Four{t[0], t[1], t[2], 0}, b.tt.y += Four{t[3], t[4], t[5], 0};
  b.tt.z += Four{t[6], t[7], t[8], 0};
  const Vec<double> impulse{t[9], t[10], t[11]}, torque{t[12], t[13], t[14]};
  b.ty.x[3] -= torque.x, b.ty.y[3] -= torque.y, b.ty.z[3] -= torque.z;
  b.impulse = b.impulse + impulse, b.torque = b.torque + torque;
}

/// What the ties need of the elimination (kTieFactor numbers): the inverse of tt, and yt, by rows.
INLINE void keep_factor(const ConservingBlock& b, const Inverse& inverse, double* to) {
  const Vec<double> columns[3] = {inverse.u, inverse.v, inverse.w};
  for (int n = 0; n < 3; ++n)
    to[n] = columns[n].x, to[3 + n] = columns[n].y, to[6 + n] = columns[n].z;
  for (int n = 0; n < 3; ++n) to[9 + n] = b.yt.x[n], to[12 + n] = b.yt.y[n], to[15 + n] = b.yt.z[n];
}

INLINE ConservingBlock nothing() {
  const Rows none{all(0), all(0), all(0)};
  return {none, none, none, none, {0, 0, 0}, {0, 0, 0}};
}

}  // namespace
}  // namespace pantin::detail::articulated
