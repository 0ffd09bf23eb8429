#pragma once
/// What the files of the procedural solver share.
#include "engine/contact/memory.hpp"
#include "engine/solvers/articulated/island.hpp"
#include "engine/solvers/articulated/kernels.hpp"
#include "engine/world/world.hpp"

namespace pantin::articulated {

/// The articulation as the kernels see it.
Packed packed(World& world, Island& a);

/// A point of a packed body, or of a kinematic one, at the poses in the given rows.
Vec3 point_at(const Island& a, std::size_t column, Vec3 anchor, Work position_row,
              Work rotation_row);
Vec3 point_on(const World& world, std::uint32_t slot, Vec3 anchor);

/// The general articulated solve (tree.cpp). Blocks of the bodies alone, from prepare()d levers.
void fill_base(Island& a, bool tension);
/// Gaps of the joints, before closing them writes over that row.
void keep_gaps(Island& a);
/// Leaf to root: room.joint_blocks (used up) to room.joint_nodes.
void gather_joints(Island& a);
/// Root to leaf: joints closed, turns and attach points left for commit(). With `again` it only
/// closes; otherwise multipliers go to the memory, stops and drives learn what they bear. True if
/// none of them asks for another pass.
bool close_joints(World& world, Island& a, Real h, Work position_row, Work rotation_row,
                  bool again);
/// Loads at the joint points go up the tree: `force` becomes the load at each own joint, `torque`
/// the turn each body makes when neither joint nor parent moves.
void carry_up(const Island& a, std::vector<Loads>& force, std::vector<Loads>& torque);
/// ... and displacements come down: `force` becomes the slide of each joint point, `torque` the
/// turn of each body.
void carry_down(const Island& a, std::vector<Loads>& force, std::vector<Loads>& torque);
/// Slot of the body that holds a root by a joint, or UINT32_MAX.
std::uint32_t held_body_of(const Island& a, std::size_t c);

/// Stiff joints (joint_terms.cpp): room.terms for the poses in a row. With `again` springs are left
/// out and stops stay as they are.
void set_terms(const World& world, Island& a, Real h, Work rotation_row, bool again);
/// Makes stiff rows of the stops, where contacts bear too. After fill_base.
void soften_stops(Island& a);
/// After a pass: what the stops of a joint bear, from rotations not clamped yet and the linear
/// answer `turn` and `slide`. True if settled.
bool settle_stops(Island& a, std::size_t c, Quat own, Quat parent, Vec3 turn, Vec3 slide);
/// ... and how much of its torque a drive may exert.
bool settle_drive(World& world, Island& a, Real h, std::size_t c);
/// Work done by drive and soft zones of a joint over the step, J.
Real work_of_springs(const Island& a, std::size_t c, Real h);
/// The turn of a joint, and a body's rotation for a turn and its parent's rotation.
Quat joint_turn(const PackedJoint& joint, Quat own, Quat parent);
Quat own_rotation(const PackedJoint& joint, Quat parent, Quat turn);
Quat parent_rotation(const World& world, const Island& a, std::size_t c, Work rotation_row);

/// Contacts (contacts.cpp): rows of the bodies they touch. Where each wants its body, for a step
/// whose poses are predicted.
void aim_touches(World& world, Island& a, Real h);
/// Adds the bearing ones to the blocks.
void add_touches(const World& world, Island& a, std::vector<JointBlock>& blocks);
/// After a pass: what contacts with fixed and driven bodies bear. True if settled.
bool settle_touches(World& world, Island& a);
/// Where a pass takes the point of a contact, to first order, as its row saw it; and what turning
/// adds to that, for the next pass.
Vec3 moved_to(const Island& a, const Touch& t);
void learn_bend(const Island& a, Touch& t, Vec3 anchor);

/// Loads by iteration (loads.cpp): how an articulation answers to loads of its contacts and stops.
/// After gather_joints; needs room.slide and room.turn of the free answer.
void find_load_response(const World& world, Island& a);
/// Finds the loads of all contacts and stops of these articulations together, in so many rounds or
/// until one moves nothing farther than `enough`, part of the size.
void iterate_loads(World& world, std::span<Island* const> all, Real h, int rounds,
                   Real enough);
/// Adds the loads found to what was gathered.
void add_iterated_loads(World& world, Island& a);
/// After a pass with iterated loads: what turning adds, and what contacts bear. True if settled.
bool settle_iterated(World& world, Island& a);
/// The free answer: what gathered loads and gaps do, into room.slide and room.turn.
void answer_freely(Island& a, Work position_row);
/// Adds loads in room.forces_in and torques_in, side 0, to the gathered nodes.
void add_loads(Island& a);

/// Contacts of what lies still bear what they bore.
void keep_touches(World& world, Island& a, Real h);
/// Takes the overlap that is left from free trees by moving them whole.
void push_out_trees(World& world, Island& a);
/// Impacts to be given back, forces, depths; and the work the contacts did, J.
Real finish_touches(World& world, Island& a, Real h);

/// Rows: strings, pins and loops answered by the articulated solve (rows.cpp).
void add_string_stiffness(const World& world, Island& a, std::vector<JointBlock>& blocks,
                          Work position_row, Work rotation_row);
/// Solves for the loads of all rows and adds them to the gathered loads. After gather_joints,
/// before close_joints. `again` repeats on already closed poses, with no loads but new ones.
void solve_rows(World& world, Island& a, Real h, Work position_row, Work rotation_row,
                bool again);
/// Largest stretch of a string at the final poses, m; and largest gap of pins and loops.
Real worst_stretch(const World& world, const Island& a);
Real worst_hold(const Island& a);
/// Where a hold wants its point, at the final poses.
Vec3 target_of(const Island& a, const Hold& hold, Work position_row, Work rotation_row);

/// Relaxation (relax.cpp): sweeps from each held point in turn, ending at the root, on the final
/// poses. `strings` takes taut strings as held points too.
void relax(World& world, Island& a, bool strings);

/// The closing sweep alone: every joint closed and within its stops, from the roots outwards.
void sweep_closed(const World& world, Island& a);

/// Moves a free root to where its neighbours' meeting points want it, on the predicted poses.
void place_free_root(Island& a, const Tree& tree, Real h);

/// SHAKE: two Newton steps in the directions of the step's start, then a closing sweep (shake.cpp).
void close_shake(World& world, Island& a, const Packed& p, Real h);

/// x of m x = b for a symmetric positive definite m, by LDL^T with floored pivots.
Vec3 solve_symmetric(const Mat3& m, Vec3 b);
/// Group mass at the own joint of a body, the load there, and the turn of a body whose joint point
/// moves by `slide`: as the kernels' gather_tree left them, for ball joints alone.
inline Mat3 group_mass(const Island& a, std::size_t c) {
  const Real* g = a.room.nodes.data() + kNodeSize * c + kGroup;
  return Mat3(g[0], g[4], g[8], g[1], g[5], g[9], g[2], g[6], g[10]);
}
inline Vec3 group_load(const Island& a, std::size_t c) {
  const Real* g = a.room.nodes.data() + kNodeSize * c + kGroup;
  return {g[3], g[7], g[11]};
}
/// The turn per displacement of the own joint point of a body, times a displacement.
inline Vec3 times_answer(const Island& a, std::size_t c, Vec3 y) {
  const Real* n = a.room.nodes.data() + kNodeSize * c + kAnswer;
  return {n[0] * y.x + n[1] * y.y + n[2] * y.z, n[4] * y.x + n[5] * y.y + n[6] * y.z,
          n[8] * y.x + n[9] * y.y + n[10] * y.z};
}
/// The turn of a body whose own joint point moves by `slide`, from the gathered articulation.
inline Vec3 answer(const Island& a, std::size_t c, Vec3 slide) {
  const Real* n = a.room.nodes.data() + kNodeSize * c + kAnswer;
  return Vec3(n[3], n[7], n[11]) - times_answer(a, c, slide);
}

/// The literal rule, root to leaf, into the final poses.
void literal_sweep(Island& a, Real h);

/// Keeps the energy from growing (limiter.cpp): what the step added beyond the work done on it is
/// taken from the velocities. What the integrator loses may come back for a while (the reserve),
/// since a stable method lends and returns energy within a swing.
void limit_energy(World& world, Island& a, const Packed& p, const EndSums& end, Real h);

/// Gives free trees back the momentum that closing the joints cost (momentum.cpp). True if any was.
bool repair_momentum(World& world, Island& a, Real h);
/// Angular momentum of a tree about its mass centre, from the bodies.
Vec3 spin_momentum(const World& world, const Island& a, const Tree& tree);

}  // namespace pantin::articulated
