#pragma once
/// What the files of the procedural solver share.
#include "engine/solvers/procedural/kernels.hpp"
#include "engine/world/world.hpp"

namespace pantin::procedural {

/// The articulation as the kernels see it.
Packed packed(World& world, Articulation& a);

/// What multiplies h^2 in the displacement that a steady force makes in one step.
inline Real force_share(const Articulation& a) { return a.second_order ? 4.0 / 9 : 1.0; }

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

/// A symmetric tensor out of six rows of a table.
inline Mat3 symmetric(const Table& t, std::size_t row, std::size_t column) {
  const Real xx = t.at(row, column), xy = t.at(row + 1, column), xz = t.at(row + 2, column);
  const Real yy = t.at(row + 3, column), yz = t.at(row + 4, column), zz = t.at(row + 5, column);
  return Mat3(xx, xy, xz, xy, yy, yz, xz, yz, zz);
}
/// x of m x = b for a symmetric positive definite m, by LDL^T with floored pivots.
Vec3 solve_symmetric(const Mat3& m, Vec3 b);
/// The turn of a body whose own joint point moves by `slide`, from the gathered articulation.
inline Vec3 answer(const Table& work, std::size_t column, Vec3 slide) {
  return work.vec(kRest, column) - Vec3(glm::dot(work.vec(kAnswer, column), slide),
                                        glm::dot(work.vec(kAnswer + 3, column), slide),
                                        glm::dot(work.vec(kAnswer + 6, column), slide));
}

/// The literal rule, root to leaf, into the final poses.
void literal_sweep(Articulation& a, Real h);

/// Gives free trees back the momentum that closing the joints cost (momentum.cpp). True if any was.
bool repair_momentum(World& world, Articulation& a, Real h);
/// Angular momentum of a tree about its mass centre, from the bodies.
Vec3 spin_momentum(const World& world, const Articulation& a, const Tree& tree);

}  // namespace pantin::procedural
