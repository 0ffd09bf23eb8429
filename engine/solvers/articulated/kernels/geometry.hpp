#pragma once
/// Adjust stage: joint geometry of a block of bodies.
#include "engine/solvers/articulated/kernels/table.hpp"

namespace pantin::detail::articulated {
namespace {

/// Own arm and world inertia of a block at a pose.
INLINE void put_arm(double* k, Qua<Four> q, Vec<Four> anchor, Vec<Four> moments) {
  put(k, kArm, rotated(q, anchor));
  // R diag(I) R^T, from the columns of R.
  const Four xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z,
             yz = q.y * q.z, wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  const Four two = all(2.0), one = all(1.0);
  const Vec<Four> ex{one - two * (yy + zz), two * (xy + wz), two * (xz - wy)};
  const Vec<Four> ey{two * (xy - wz), one - two * (xx + zz), two * (yz + wx)};
  const Vec<Four> ez{two * (xz + wy), two * (yz - wx), one - two * (xx + yy)};
  const Vec<Four> mx = moments.x * ex, my = moments.y * ey, mz = moments.z * ez;
  put(k, kRotationalInertia,
      Sym<Four>{mx.x * ex.x + my.x * ey.x + mz.x * ez.x, mx.x * ex.y + my.x * ey.y + mz.x * ez.y,
                mx.x * ex.z + my.x * ey.z + mz.x * ez.z, mx.y * ex.y + my.y * ey.y + mz.y * ez.y,
                mx.y * ex.z + my.y * ey.z + mz.y * ez.z, mx.z * ex.z + my.z * ey.z + mz.z * ez.z});
}

/// Joint geometry of a block: own arms and inertias, the parents' arms to the same joints, the
/// gaps.
INLINE void put_levers(const IslandView& p, std::size_t i, std::size_t position_row,
                       std::size_t rotation_row) {
  const double* c = column(p.constants, kConstantRows, i);
  double* k = column(p.work, kWorkRows, i);
  const Vec<Four> x = vec<Four>(k, position_row);
  const Qua<Four> q = qua<Four>(k, rotation_row);
  put_arm(k, q, vec<Four>(c, kOwnAnchor), vec<Four>(c, kInertia));
  // The parents' poses, lane by lane; roots use their own.
  Qua<Four> pq = q;
  Vec<Four> px = x;
  for (std::size_t l = 0; l < kLanes; ++l) {
    const std::int32_t parent = p.parents[i + l];
    if (parent < 0) continue;
    const double* o = column(p.work, kWorkRows, static_cast<std::size_t>(parent));
    pq.x[l] = o[rotation_row * kLanes], pq.y[l] = o[(rotation_row + 1) * kLanes];
    pq.z[l] = o[(rotation_row + 2) * kLanes], pq.w[l] = o[(rotation_row + 3) * kLanes];
    px.x[l] = o[position_row * kLanes], px.y[l] = o[(position_row + 1) * kLanes];
    px.z[l] = o[(position_row + 2) * kLanes];
  }
  const Vec<Four> arm = rotated(pq, vec<Four>(c, kParentAnchor));
  put(k, kParentArm, arm);
  put(k, kGap, (px + arm) - (x + vec<Four>(k, kArm)));
}

void levers(const IslandView& p, std::size_t position_row, std::size_t rotation_row) {
  for (std::size_t i = 0; i < p.count; i += kLanes) put_levers(p, i, position_row, rotation_row);
}

template <class T>
INLINE void add(Sym<T>& a, const Sym<T>& b) {
  a.xx += b.xx, a.xy += b.xy, a.xz += b.xz, a.yy += b.yy, a.yz += b.yz, a.zz += b.zz;
}

/// Rows of the work table that hold the poses: the first row of positions and of rotations.
struct PosedAt {
  std::size_t position_row, rotation_row;
};

/// Joint geometry of a block, and its rotational inertia about the own joints.
INLINE void put_turning(const IslandView& p, std::size_t i, const PosedAt& at) {
  put_levers(p, i, at.position_row, at.rotation_row);
  double* k = column(p.work, kWorkRows, i);
  const Vec<Four> arm = vec<Four>(k, kArm);
  const Vec<Four> ma = num<Four>(column(p.constants, kConstantRows, i), kMass) * arm;
  const Four a2 = dot(ma, arm);
  Sym<Four> tt = sym<Four>(k, kRotationalInertia);
  add(tt, Sym<Four>{a2 - ma.x * arm.x, -ma.x * arm.y, -ma.x * arm.z, a2 - ma.y * arm.y,
                    -ma.y * arm.z, a2 - ma.z * arm.z});
  put(k, kRotationalInertia, tt);
}

void prepare(const IslandView& p, std::size_t position_row, std::size_t rotation_row) {
  for (std::size_t i = 0; i < p.count; i += kLanes) put_turning(p, i, {position_row, rotation_row});
}

}  // namespace
}  // namespace pantin::detail::articulated
