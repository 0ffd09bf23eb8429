#pragma once
/// Adjust stage, inward pass: eliminates every body from the leaves to the root, leaving the
/// articulated mass and the bias at its joint.
#include "engine/solvers/articulated/kernels/geometry.hpp"
#include "engine/solvers/articulated/kernels/rows.hpp"

namespace pantin::detail::articulated {
namespace {

/// The block of a body with its outboard subtree, before its rotation is eliminated: A_tt, A_ty |
/// g_t and A_yy | g_y.
struct Block {
  Sym<double> tt;
  Rows<double> ty, yy;
};

INLINE Four with_last(Four v, double last) {
  v[3] = last;
  return v;
}

/// Adds a child, given as articulated mass | bias at its joint, to the block of its parent.
INLINE void add_child(Block& b, const Rows<double>& mass_and_bias, Vec<double> gap,
                      Vec<double> rho) {
  // Bias after the gap is closed: g - M s.
  const Four ms = gap.x * mass_and_bias.x + gap.y * mass_and_bias.y + gap.z * mass_and_bias.z;
  const Four fx = with_last(mass_and_bias.x, mass_and_bias.x[3] - ms[0]);
  const Four fy = with_last(mass_and_bias.y, mass_and_bias.y[3] - ms[1]);
  const Four fz = with_last(mass_and_bias.z, mass_and_bias.z[3] - ms[2]);
  b.yy.x += fx, b.yy.y += fy, b.yy.z += fz;
  // K(rho) M | rho x f, with K(a) b = a x b; and -K M K.
  const Four kx = rho.y * fz - rho.z * fy;
  const Four ky = rho.z * fx - rho.x * fz;
  const Four kz = rho.x * fy - rho.y * fx;
  b.ty.x += kx, b.ty.y += ky, b.ty.z += kz;
  add(b.tt, Sym<double>{rho.y * kx[2] - rho.z * kx[1], rho.z * kx[0] - rho.x * kx[2],
                        rho.x * kx[1] - rho.y * kx[0], rho.z * ky[0] - rho.x * ky[2],
                        rho.x * ky[1] - rho.y * ky[0], rho.x * kz[1] - rho.y * kz[0]});
}

/// The block of a body alone: A_tt is prepared, A_ty = m K(e) with e = -arm, A_yy = m.
INLINE Block own_block(const double* c, const double* k) {
  const double m = num<double>(c, kMass);
  const Vec<double> ma = m * vec<double>(k, kArm);
  return {sym<double>(k, kRotationalInertia),
          {Four{0, ma.z, -ma.y, 0}, Four{-ma.z, 0, ma.x, 0}, Four{ma.y, -ma.x, 0, 0}},
          {Four{m, 0, 0, 0}, Four{0, m, 0, 0}, Four{0, 0, m, 0}}};
}

/// Eliminates the rotation of a body, pivot by pivot: articulated mass and bias at its joint, then
/// its response. The next body depends on the articulated mass only, which is computed first.
INLINE Rows<double> eliminate(const Block& b, double* node) {
  const double floor = 4 * 2.220446049250313e-16 * (b.tt.xx + b.tt.yy + b.tt.zz);
  const double d0 = b.tt.xx, i0 = 1 / (d0 > floor ? d0 : floor);
  const double l01 = b.tt.xy * i0, l02 = b.tt.xz * i0;
  const double d1 = b.tt.yy - l01 * b.tt.xy, s12 = b.tt.yz - l01 * b.tt.xz;
  const double e2 = b.tt.zz - l02 * b.tt.xz;
  const Four r0 = b.ty.x, m0 = i0 * r0;
  const Four r1 = b.ty.y - l01 * r0, q2 = b.ty.z - l02 * r0;

  const double i1 = 1 / (d1 > floor ? d1 : floor);
  const double l12 = s12 * i1, d2 = e2 - l12 * s12;
  const Four m1 = i1 * r1, r2 = q2 - l12 * r1;

  const double i2 = 1 / (d2 > floor ? d2 : floor);
  const Four m2 = i2 * r2;
  const Rows<double> mass_and_bias{((b.yy.x - m0[0] * r0) - m1[0] * r1) - m2[0] * r2,
                                   ((b.yy.y - m0[1] * r0) - m1[1] * r1) - m2[1] * r2,
                                   ((b.yy.z - m0[2] * r0) - m1[2] * r1) - m2[2] * r2};
  mass_and_bias.to(node, kArticulatedMass);
  // Back substitution: rows of the response, each followed by the bias.
  const Four a1 = m1 - l12 * m2;
  Rows<double>{(m0 - l01 * a1) - l02 * m2, a1, m2}.to(node, kResponse);
  return mass_and_bias;
}

INLINE void put_block(double* at, const Block& b) {
  at[0] = b.tt.xx, at[1] = b.tt.xy, at[2] = b.tt.xz, at[3] = b.tt.yy, at[4] = b.tt.yz;
  at[5] = b.tt.zz;
  b.ty.to(at, kRotationTranslation), b.yy.to(at, kTranslationTranslation);
}
INLINE Block block_at(const double* at) {
  return {{at[0], at[1], at[2], at[3], at[4], at[5]},
          Rows<double>::from(at, kRotationTranslation),
          Rows<double>::from(at, kTranslationTranslation)};
}

void fill_blocks(const IslandView& p, double* blocks) {
  for (std::size_t i = 0; i < p.count; ++i)
    put_block(blocks + kBlockSize * i,
              own_block(column(p.constants, kConstantRows, i), column(p.work, kWorkRows, i)));
}

/// Each body is added to its parent's block once it is eliminated.
void inward_pass(const IslandView& p, double* blocks) {
  for (std::size_t i = p.count; i-- > 0;) {
    const double* k = column(p.work, kWorkRows, i);
    const Rows<double> mass_and_bias =
        eliminate(block_at(blocks + kBlockSize * i), p.nodes + kNodeSize * i);
    if (p.parents[i] < 0) continue;
    const auto parent = static_cast<std::size_t>(p.parents[i]);
    Block b = block_at(blocks + kBlockSize * parent);
    add_child(b, mass_and_bias, vec<double>(k, kGap),
              vec<double>(k, kParentArm) - vec<double>(column(p.work, kWorkRows, parent), kArm));
    put_block(blocks + kBlockSize * parent, b);
  }
}

}  // namespace
}  // namespace pantin::detail::articulated
