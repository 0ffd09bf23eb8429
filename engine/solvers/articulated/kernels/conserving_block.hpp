#pragma once
/// Elimination of one body in a step by the energy-momentum method, scalar or vectorised over
/// islands; see conserving.hpp.
#include "engine/solvers/articulated/kernels/rows.hpp"

namespace pantin::detail::articulated {
namespace {

/// A body with its outboard subtree, before its rotation is eliminated; each row is followed by the
/// component of a vector.
template <class N>
struct ConservingBlock {
  Rows<N> tt, ty, yt, yy;  // ty: | torque impulse to be made; yy: | momentum, or nothing
  Vec<N> impulse;          // at the own joint, from the parent
  Vec<N> torque;           // impulse about the own joint: a residual, to vanish

  INLINE static ConservingBlock none() {
    const Row<N> row = row_of(N{}, N{}, N{}, N{});
    const Rows<N> rows{row, row, row};
    return {rows, rows, rows, rows, {N{}, N{}, N{}}, {N{}, N{}, N{}}};
  }
};

template <class T>
struct Axes {
  Vec<T> d[3];
};
/// The columns of the rotation matrix.
template <class F>
INLINE Axes<F> axes_of(Qua<F> q) {
  const F xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z,
          yz = q.y * q.z, wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  const F one = all<F>(1.0);
  return {{{one - 2.0 * (yy + zz), 2.0 * (xy + wz), 2.0 * (xz - wy)},
           {2.0 * (xy - wz), one - 2.0 * (xx + zz), 2.0 * (yz + wx)},
           {2.0 * (xz + wy), 2.0 * (yz - wx), one - 2.0 * (xx + yy)}}};
}
template <class F>
INLINE Vec<F> along(const Axes<F>& r, Vec<F> v) {
  return v.x * r.d[0] + v.y * r.d[1] + v.z * r.d[2];
}

/// A sum of outer products a b^T, by rows.
template <class F>
struct Outer {
  Vec<F> x{all<F>(0), all<F>(0), all<F>(0)}, y = x, z = x;
  INLINE void add(Vec<F> a, Vec<F> b) { x = x + a.x * b, y = y + a.y * b, z = z + a.z * b; }
  /// A row, with the trace subtracted from the diagonal: a (b . t) - t (a . b) = (t x a) x b.
  INLINE Vec<F> crossed(std::size_t row) const {
    const F trace = x.x + y.y + z.z;
    if (row == 0) return {x.x - trace, x.y, x.z};
    return row == 1 ? Vec<F>{y.x, y.y - trace, y.z} : Vec<F>{z.x, z.y, z.z - trace};
  }
};

/// The block of a body without its children, from its rows of the work table.
template <Unknown unknown, class N>
INLINE void add_own(const double* k, N mass, N per, ConservingBlock<N>& b) {
  const N m = unknown == Unknown::displacement ? mass * per : mass, none{};
  const std::size_t arm_row = unknown == Unknown::displacement ? kMeanArm : kEndArm;
  const Vec<N> e = m * vec<N>(k, arm_row), e1 = m * vec<N>(k, kEndArm);
  const Vec<N> t = vec<N>(k, kTorqueImpulse), f = vec<N>(k, kImpulse);
  const Vec<N> x = vec<N>(k, kTurn), y = vec<N>(k, kTurn + 3), z = vec<N>(k, kTurn + 6);
  b.tt.x += row_of(x.x, x.y, x.z, none), b.tt.y += row_of(y.x, y.y, y.z, none);
  b.tt.z += row_of(z.x, z.y, z.z, none);
  b.ty.x += row_of(none, -e.z, e.y, -t.x), b.ty.y += row_of(e.z, none, -e.x, -t.y);
  b.ty.z += row_of(-e.y, e.x, none, -t.z);
  b.yt.x += row_of(none, e1.z, -e1.y, none), b.yt.y += row_of(-e1.z, none, e1.x, none);
  b.yt.z += row_of(e1.y, -e1.x, none, none);
  const bool moves = unknown == Unknown::velocity;
  b.yy.x += row_of(m, none, none, moves ? f.x : none);
  b.yy.y += row_of(none, m, none, moves ? f.y : none);
  b.yy.z += row_of(none, none, m, moves ? f.z : none);
  if (!moves) b.impulse = b.impulse + f, b.torque = b.torque + t;
}

/// Cross product of a row's first three components with r.
template <class N>
INLINE Row<N> row_cross(const Row<N>& row, Vec<N> r) {
  return row_of(row[1] * r.z - row[2] * r.y, row[2] * r.x - row[0] * r.z,
                row[0] * r.y - row[1] * r.x, N{});
}

/// Adds an eliminated child, given as mass | bias at its joint and the impulse there, and its rows
/// of the work table.
template <Unknown unknown, class N>
INLINE void add_child(ConservingBlock<N>& b, const Rows<N>& child, Vec<N> impulse,
                      const double* k) {
  const Vec<N> r1 = vec<N>(k, kEndReach);
  const Vec<N> r = unknown == Unknown::displacement ? vec<N>(k, kMeanReach) : r1;
  const N none{};
  b.yy.x += child.x, b.yy.y += child.y, b.yy.z += child.z;
  b.yt.x -= row_cross(child.x, r1), b.yt.y -= row_cross(child.y, r1);
  b.yt.z -= row_cross(child.z, r1);
  const Row<N> kx = r.y * child.z - r.z * child.y, ky = r.z * child.x - r.x * child.z,
               kz = r.x * child.y - r.y * child.x;
  b.ty.x += kx, b.ty.y += ky, b.ty.z += kz;
  b.tt.x -= row_cross(kx, r1), b.tt.y -= row_cross(ky, r1), b.tt.z -= row_cross(kz, r1);
  if (unknown == Unknown::velocity) return;
  const Vec<N> f = 0.5 * impulse, t = cross(r, impulse);
  const N along = dot(f, r1);
  b.tt.x += row_of(r1.x * f.x - along, r1.x * f.y, r1.x * f.z, none);
  b.tt.y += row_of(r1.y * f.x, r1.y * f.y - along, r1.y * f.z, none);
  b.tt.z += row_of(r1.z * f.x, r1.z * f.y, r1.z * f.z - along, none);
  b.ty.x[3] -= t.x, b.ty.y[3] -= t.y, b.ty.z[3] -= t.z;
  b.impulse = b.impulse + impulse, b.torque = b.torque + t;
}

/// Columns of the inverse of a 3x3 matrix, given by its rows.
template <class N>
struct Inverse {
  Vec<N> u, v, w;
  INLINE explicit Inverse(const Rows<N>& m) {
    const Vec<N> x{m.x[0], m.x[1], m.x[2]}, y{m.y[0], m.y[1], m.y[2]}, z{m.z[0], m.z[1], m.z[2]};
    const Vec<N> yz = cross(y, z);
    const N per_det = 1.0 / dot(x, yz);
    u = per_det * yz, v = per_det * cross(z, x), w = per_det * cross(x, y);
  }
};

/// Refers the equations of the rotation to axes that rotate with the body (the mean of its axes
/// before and after). Otherwise a residual torque would couple the rotation about the axis of a
/// thin body with those across it, where its inertia is larger by orders of magnitude. `turned` is
/// the Cayley vector of the rotation over the step.
template <class N>
INLINE void turn_axes(ConservingBlock<N>& b, Vec<N> turned) {
  const Vec<N> n = 0.5 * b.torque, d = -0.5 * turned;
  const N along = dot(n, d), none{};
  b.tt.x += row_of(n.x * d.x - along, n.x * d.y - n.z, n.x * d.z + n.y, none);
  b.tt.y += row_of(n.y * d.x + n.z, n.y * d.y - along, n.y * d.z - n.x, none);
  b.tt.z += row_of(n.z * d.x - n.y, n.z * d.y + n.x, n.z * d.z - along, none);
}

/// Eliminates the rotation, given the inverse of tt. Returns mass | bias at the own joint; writes
/// this and the response to the node.
template <class N>
INLINE Rows<N> eliminate(const ConservingBlock<N>& b, const Inverse<N>& inverse, double* node) {
  const auto& [u, v, w] = inverse;
  const Rows<N> response{u.x * b.ty.x + v.x * b.ty.y + w.x * b.ty.z,
                         u.y * b.ty.x + v.y * b.ty.y + w.y * b.ty.z,
                         u.z * b.ty.x + v.z * b.ty.y + w.z * b.ty.z};
  response.to(node, kResponse);
  const auto less = [&](const Row<N>& yy, const Row<N>& yt) {
    return ((yy - yt[0] * response.x) - yt[1] * response.y) - yt[2] * response.z;
  };
  const Rows<N> mass{less(b.yy.x, b.yt.x), less(b.yy.y, b.yt.y), less(b.yy.z, b.yt.z)};
  mass.to(node, kArticulatedMass);
  return mass;
}

template <class N>
INLINE void add_rows(Rows<N>& to, const double* t) {
  const auto row = [&](std::size_t i) {
    return row_of(get<N>(t, i), get<N>(t, i + 1), get<N>(t, i + 2), N{});
  };
  to.x += row(0), to.y += row(3), to.z += row(6);
}
/// Adds the derivatives of grounded ties: see grounded_block().
template <class N>
INLINE void add_grounded(ConservingBlock<N>& b, const double* t) {
  constexpr std::size_t wide = kNumbersIn<N>;
  add_rows(b.ty, t + kTieTurnMove * wide), add_rows(b.yt, t + kTieMoveTurn * wide);
  add_rows(b.yy, t + kTieMoveMove * wide);
}
/// Adds the ties of a body to its block (kTieBlock numbers), for displacements only.
template <class N>
INLINE void add_ties(ConservingBlock<N>& b, const double* t) {
  add_rows(b.tt, t);
  const Vec<N> impulse = get_vec<N>(t, kTieImpulse), torque = get_vec<N>(t, kTieTorque);
  b.ty.x[3] -= torque.x, b.ty.y[3] -= torque.y, b.ty.z[3] -= torque.z;
  b.impulse = b.impulse + impulse, b.torque = b.torque + torque;
}

/// Stores for the ties the inverse of tt, and yt, by rows (kTieFactor numbers).
template <class N>
INLINE void keep_factor(const ConservingBlock<N>& b, const Inverse<N>& inverse, double* to) {
  const auto& [u, v, w] = inverse;
  set_vec(to, 0, Vec<N>{u.x, v.x, w.x}), set_vec(to, 3, Vec<N>{u.y, v.y, w.y});
  set_vec(to, 6, Vec<N>{u.z, v.z, w.z});
  const auto front = [](const Row<N>& row) { return Vec<N>{row[0], row[1], row[2]}; };
  set_vec(to, 9, front(b.yt.x)), set_vec(to, 12, front(b.yt.y)), set_vec(to, 15, front(b.yt.z));
}

}  // namespace
}  // namespace pantin::detail::articulated
