#pragma once
/// What the files of the procedural solver share.
#include "engine/solvers/procedural/kernels.hpp"
#include "engine/world/world.hpp"

namespace pantin::procedural {

/// The articulation as the kernels see it.
Packed packed(World& world, Articulation& a);

/// A point of a packed body, or of a kinematic one, at the poses in the given rows.
Vec3 point_at(const Articulation& a, std::size_t column, Vec3 anchor, Work position_row,
              Work rotation_row);
Vec3 point_on(const World& world, std::uint32_t slot, Vec3 anchor);

/// Rows: strings and held points answered by the articulated solve (rows.cpp).
/// Needs filled blocks; call between fill_blocks and gather_tree.
void add_string_stiffness(const World& world, Articulation& a, Work position_row,
                          Work rotation_row);
/// Solves for the loads of all rows and adds them to the gathered loads. After gather_tree, before
/// close. `again` repeats on already closed poses, for strings only.
void solve_rows(World& world, Articulation& a, Real h, Work position_row, Work rotation_row,
                bool again);
/// Largest stretch of a string at the final poses, m.
Real worst_stretch(const World& world, const Articulation& a);

/// Relaxation (relax.cpp): sweeps from each held point in turn, ending at the root, on the final
/// poses. `strings` takes taut strings as held points too.
void relax(World& world, Articulation& a, bool strings);

/// Moves a free root to where its neighbours' meeting points want it, on the predicted poses.
void place_free_root(Articulation& a, const Tree& tree, Real h);

/// SHAKE: two Newton steps in the directions of the step's start, then a closing sweep (shake.cpp).
void close_shake(World& world, Articulation& a, const Packed& p, Real h);

/// Group mass at the own joint of a body, the load there, and the turn when the joint stays.
inline Mat3 group_mass(const Articulation& a, std::size_t c) {
  const Real* g = a.room.nodes.data() + kNodeSize * c + kGroup;
  return Mat3(g[0], g[4], g[8], g[1], g[5], g[9], g[2], g[6], g[10]);
}
inline Vec3 group_load(const Articulation& a, std::size_t c) {
  const Real* g = a.room.nodes.data() + kNodeSize * c + kGroup;
  return {g[3], g[7], g[11]};
}
/// x of m x = b for a symmetric positive definite m, by LDL^T with floored pivots.
Vec3 solve_symmetric(const Mat3& m, Vec3 b);
/// The turn per displacement of the own joint point of a body, times a displacement.
inline Vec3 times_answer(const Articulation& a, std::size_t c, Vec3 y) {
  const Real* n = a.room.nodes.data() + kNodeSize * c + kAnswer;
  return {n[0] * y.x + n[1] * y.y + n[2] * y.z, n[4] * y.x + n[5] * y.y + n[6] * y.z,
          n[8] * y.x + n[9] * y.y + n[10] * y.z};
}
/// The turn of a body whose own joint point moves by `slide`, from the gathered articulation.
inline Vec3 answer(const Articulation& a, std::size_t c, Vec3 slide) {
  const Real* n = a.room.nodes.data() + kNodeSize * c + kAnswer;
  return Vec3(n[3], n[7], n[11]) - times_answer(a, c, slide);
}

/// The literal rule, root to leaf, into the final poses.
void literal_sweep(Articulation& a, Real h);

/// Keeps the energy from growing (limiter.cpp): what the step added beyond the work done on it is
/// taken from the velocities. What the integrator loses may come back for a while (the reserve),
/// since a stable method lends and returns energy within a swing.
void limit_energy(World& world, Articulation& a, const Packed& p, const EndSums& end, Real h);

/// Gives free trees back the momentum that closing the joints cost (momentum.cpp). True if any was.
bool repair_momentum(World& world, Articulation& a, Real h);
/// Angular momentum of a tree about its mass centre, from the bodies.
Vec3 spin_momentum(const World& world, const Articulation& a, const Tree& tree);

}  // namespace pantin::procedural
