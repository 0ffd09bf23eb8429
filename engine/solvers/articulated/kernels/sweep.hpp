#pragma once
/// Adjust stage, the sweep: closes every joint from the root to the leaves.
#include "engine/solvers/articulated/kernels/geometry.hpp"

namespace pantin::detail::articulated {
namespace {

/// Rotation of a vector by a body's rotation: v -> v + a (u x v) + b u x (u x v).
struct Carry {
  Vec<double> u;
  double a, b;
  INLINE Vec<double> operator()(Vec<double> v) const {
    const Vec<double> t = cross(u, v);
    return v + (a * t + b * cross(u, t));
  }
};
/// The rotation by a quaternion (u, w) of any length.
INLINE Carry carry_by(Qua<double> q) {
  const double s = 2 / (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {{q.x, q.y, q.z}, s * q.w, s};
}

INLINE double magnitude(double x) { return x < 0 ? -x : x; }

/// The rotation of one body whose own joint point moves to `goal`, by least displacement; a free
/// root stays. Scaled by |r x s|^2 to avoid divisions: the quaternion (Z + C, S) with S = m r x s,
/// C = beta a^T I a + m r.(r + s), Z = sqrt(C^2 + S^2).
struct LeastDisplacement {
  const IslandView& p;
  std::size_t position_row;
  double stiffness;

  INLINE Carry operator()(std::size_t i, double* k, Vec<double> arm, Vec<double>& goal) const {
    const Vec<double> x = vec<double>(k, position_row);
    const Vec<double> to = goal - x;       // r + s
    const Vec<double> a = cross(arm, to);  // r x s = r x (r + s)
    const double a2 = dot(a, a);
    if (p.parents[i] == kFree || !(a2 > 1e-100)) {
      if (p.parents[i] == kFree) goal = x;
      put(k, kAppliedRotation, Qua<double>{0, 0, 0, 1});
      return {{0, 0, 0}, 0, 0};
    }
    const double ma2 = num<double>(column(p.constants, kConstantRows, i), kMass) * a2;
    const double c =
        stiffness * dot(a, mul(sym<double>(k, kRotationalInertia), a)) + ma2 * dot(arm, to);
    const Vec<double> s = ma2 * a;
    const double s2 = ma2 * ma2 * a2;
    // With M = Z + |C|: Z + C is M or S^2 / M, and the quaternion (S, Z + C) or (M S, S^2). |(S, Z
    // + C)|^2 = 2 Z (Z + C). The case is unpredictable, hence no branch.
    const double z = ::sqrt(c * c + s2), m = z + magnitude(c);
    const auto same = Two{c, c} >= Two{0, 0};
    const Two pick = choose(same, Two{1, m}, Two{m, s2});  // factor of S, scalar part
    put(k, kAppliedRotation, Qua<double>{pick[0] * s.x, pick[0] * s.y, pick[0] * s.z, pick[1]});
    return {s, 1 / z, pick[0] / (z * pick[1])};
  }
};

/// State of the previous body in a sweep along a chain.
struct Step {
  Vec<double> goal{0, 0, 0}, arm{0, 0, 0};
  Carry carry{{0, 0, 0}, 0, 0};
};

/// One body of the sweep: position of its joint, and its rotation by `rotate`.
template <bool chain, class Rotate>
INLINE void outwards(const Rotate& rotate, const double*& targets, std::size_t i, Step& at) {
  const IslandView& p = rotate.p;
  double* k = column(p.work, kWorkRows, i);
  const std::int32_t parent = p.parents[i];
  if (parent < 0) {
    at.goal = {targets[0], targets[1], targets[2]};
    targets += 3;
  } else {
    if (!chain) {
      const double* o = column(p.work, kWorkRows, static_cast<std::size_t>(parent));
      at = {vec<double>(o, kAttach), vec<double>(o, kArm),
            carry_by(qua<double>(o, kAppliedRotation))};
    }
    at.goal = at.goal + at.carry(vec<double>(k, kParentArm) - at.arm);
  }
  at.arm = vec<double>(k, kArm);
  at.carry = rotate(i, k, at.arm, at.goal);
  put(k, kAttach, at.goal);
}

template <class Rotate>
INLINE void walk(const IslandView& p, const double* targets, const Rotate& rotate) {
  Step at;
  if (p.is_chain)
    for (std::size_t i = 0; i < p.count; ++i) outwards<true>(rotate, targets, i, at);
  else
    for (std::size_t i = 0; i < p.count; ++i) outwards<false>(rotate, targets, i, at);
}

void sweep(const IslandView& p, const double* targets, std::size_t position_row, double stiffness) {
  walk(p, targets, LeastDisplacement{p, position_row, stiffness});
}

/// The final pose of a block: rotations applied, own joints in place.
struct BlockPose {
  Vec<Four> x;
  Qua<Four> q;
};
INLINE BlockPose pose_of(const IslandView& p, std::size_t i, std::size_t from_rotation_row) {
  const double* k = column(p.work, kWorkRows, i);
  const Qua<Four> q = unit(mul(qua<Four>(k, kAppliedRotation), qua<Four>(k, from_rotation_row)));
  const Vec<Four> arm = rotated(q, vec<Four>(column(p.constants, kConstantRows, i), kOwnAnchor));
  return {vec<Four>(k, kAttach) - arm, q};
}

void apply_poses(const IslandView& p, std::size_t from_rotation_row) {
  for (std::size_t i = 0; i < p.count; i += kLanes) {
    double* k = column(p.work, kWorkRows, i);
    const BlockPose at = pose_of(p, i, from_rotation_row);
    put(k, kFinalRotation, at.q), put(k, kFinalPosition, at.x);
  }
}

}  // namespace
}  // namespace pantin::detail::articulated
