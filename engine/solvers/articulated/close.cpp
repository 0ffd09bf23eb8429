// Joints closed at the predicted poses by the method of the island, and the velocities after that.
#include <algorithm>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr Real kJumpResidual = 1e-2;  // relative to the size: residual beyond the linearisation

/// Cables, pins and loops are satisfied to first order; Newton iterations from the final poses
/// close the rest, with the active set of limits and contacts unchanged.
void close_rows(World& world, Island& a, Real h) {
  const IslandView p = view_of(world, a);
  StepScratch& r = a.scratch;
  const Real enough = 0.1 * a.settings.tolerance * a.size;
  Real worst = std::max(worst_stretch(world, a), worst_pin_gap(a));
  if (!(worst > enough)) return;
  if (worst > kJumpResidual * a.size) {
    // A jump: solved again from the prediction, with the geometric stiffness of the forces found.
    fill_base(a, Tension::stiffens);
    add_cable_stiffness(world, a, r.base);
    eliminate_once(world, a, h);
    apply_once(world, a, h);
    worst = std::max(worst_stretch(world, a), worst_pin_gap(a));
  }
  // The lambdas of the step itself are kept for the next step.
  PANTIN_ASSERT(r.lambdas.size() == a.count());
  for (std::size_t c = 0; c < a.count(); ++c) r.lambdas[c] = a.memory.vec(kLambda, c);
  for (int round = 0; round < a.settings.sweeps && worst > enough; ++round) {
    kernels().prepare(p, kFinalPosition, kFinalRotation, Tension::ignored);
    if (!a.joints.empty()) set_terms(world, a, h, kCorrection);
    keep_gaps(a);
    fill_base(a, Tension::stiffens);
    r.joint_blocks = r.base;
    inward_pass(a);
    solve_rows(world, a, h, kCorrection);
    outward_pass(world, a, h, kCorrection);
    kernels().apply_poses(p, kFinalRotation);
    // The next iteration uses the geometric stiffness of the full step.
    for (std::size_t c = 0; r.step_fraction < 1 && c < a.count(); ++c)
      a.memory.set(kLambda, c, a.memory.vec(kLambda, c) / r.step_fraction);
    a.sweeps_used = round + 1;
    const Real now = std::max(worst_stretch(world, a), worst_pin_gap(a));
    // Stops when the residual stagnates: the target is out of reach.
    if (std::abs(worst - now) < a.settings.stall_drop * worst) break;
    worst = now;
  }
  for (std::size_t c = 0; c < a.count(); ++c) a.memory.set(kLambda, c, r.lambdas[c]);
}

/// Closes joints one after the other from the root, as if inboard bodies were fixed.
void close_kinematic(Island& a, const IslandView& p, Real h) {
  for (const Tree& t : a.trees)
    if (a.parents[t.first] == kFree && t.count > 1) place_free_root(a, t, h);
  if (a.settings.solver == Solver::procedural) {
    literal_sweep(a, h);
    return;
  }
  const Kernels& k = kernels();
  k.levers(p, kPosition, kRotation);
  k.sweep(p, a.scratch.targets.data(), kPosition, a.settings.rotation_stiffness);
  k.apply_poses(p, kRotation);
}

/// Free ball joints only: all passes in one loop.
EndSums close_plain(Island& a, const IslandView& p, const VelocityInput& in) {
  const Kernels& k = kernels();
  if (p.is_chain) {
    k.inward_pass_chain(p, tension_of(a));
  } else {
    PANTIN_ASSERT(a.scratch.blocks.size() >= kBlockSize * a.count());
    k.prepare(p, kPosition, kRotation, tension_of(a));
    k.fill_blocks(p, a.scratch.blocks.data());
    k.inward_pass_tree(p, tension_of(a), a.scratch.blocks.data());
  }
  PANTIN_ASSERT(a.scratch.targets.size() == 3 * a.trees.size());
  return k.outward_pass_and_update(p, a.scratch.targets.data(), in);
}

/// Stores the multipliers of limits and the state of drives after the last iteration.
void store_limits(Island& a, Real h) {
  for (std::size_t c = 0; c < a.joints.size(); ++c) {
    const PackedJoint& j = a.joints[c];
    if (!j.stiff) continue;
    bool hit = false;
    for (int s = 0; s < 4; ++s) {
      PANTIN_ASSERT(c < a.scratch.terms.size() && c < a.joint_memory.size());
      const LimitRow& limit = a.scratch.terms[c].limits[s];
      const bool is_active = limit.on || (a.iterates && limit.lambda > 0);
      a.joint_memory[c].lambdas[s] = is_active ? limit.lambda : 0;
      hit = hit || (is_active && !limit.both_ways);
    }
    a.stops_hit += hit;
    a.drives_capped += j.drive != UINT32_MAX && a.joint_memory[c].torque_fraction < 1;
    a.supplied_work += work_of_springs(a, c, h);
  }
}

/// A diverged solve with contacts or limits is discarded: the bodies stay in place, at rest, and
/// the lambdas are reset. A free island continues with the velocity of its mass centre, returned in
/// `drift` (m/s). Counts as limited.
bool stays(World& world, Island& a, Real h, Vec3& drift) {
  Real fastest = 0, farthest = 0;
  bool finite = true, flies = a.scratch.contact_rows.empty() && a.cables.empty() && a.pins.empty();
  for (const Tree& t : a.trees) flies = flies && a.parents[t.first] == kFree;
  drift = flies ? a.momentum_before / a.mass + h * world.gravity : Vec3(0);
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    const Vec3 x = a.scratch.work.vec(kFinalPosition, c);
    finite = finite && is_finite(x) && is_finite(a.scratch.work.quat(kFinalRotation, c));
    fastest = std::max(fastest, glm::length(b.velocity));
    farthest = std::max(farthest, glm::length(x - b.pose.position));
  }
  if (finite && farthest < 10 * a.size + 10 * h * fastest) return false;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    a.scratch.work.set(kFinalPosition, c, b.pose.position + h * drift);
    a.scratch.work.set(kFinalRotation, c, b.pose.rotation);
    a.memory.set(kLambda, c, Vec3(0));
  }
  for (const ContactRow& t : a.scratch.contact_rows) {
    Contact& contact = contacts_of(world)[t.contact];
    if (t.side > 0) contact.lambda = contact.force = Vec3(0), contact.active = false;
  }
  for (JointMemory& j : a.joint_memory) std::fill(std::begin(j.lambdas), std::end(j.lambdas), 0);
  return true;
}

/// Whether an inextensible cable became taut: a blow. The rule of a first step would double the
/// velocities that it gives.
bool cable_hits(const World& world, const Island& a) {
  return std::any_of(a.cables.begin(), a.cables.end(), [&](const PackedCable& cord) {
    return world.cables.values()[cord.cable].joint.compliance == 0 && cord.lambda > 0 &&
           !cord.was_taut;
  });
}

/// Any island, one thing after the other.
EndSums close_in_turn(World& world, Island& a, VelocityInput in) {
  const IslandView p = view_of(world, a);
  const Solver solver = a.settings.solver;
  if (solver == Solver::articulated) {
    if (has_rows(a)) close_rows(world, a, in.h);
    if (!a.joints.empty()) store_limits(a, in.h);
    a.contact_active = has_active_contacts(world, a);
    a.in_contact = a.stops_hit > 0 || a.contact_active || (a.fresh && cable_hits(world, a));
  } else if (solver == Solver::shake2) {
    close_shake(world, a, p, in.h);
  } else {
    close_kinematic(a, p, in.h);
  }
  if (!a.joints.empty() && solver != Solver::articulated) sweep_closed(world, a);
  if (has_rows(a))
    relax(world, a, solver == Solver::articulated ? Relaxed::pins : Relaxed::pins_and_cables);
  if (!a.scratch.contact_rows.empty()) push_out_trees(world, a);
  Vec3 drift(0);
  const bool may_stay =
      solver == Solver::articulated && (!a.scratch.contact_rows.empty() || a.in_contact);
  const bool stayed = may_stay && stays(world, a, in.h, drift);
  if (stayed) a.in_contact = a.limited = true;
  // After an impact the history is invalid: first-order rule.
  if (a.in_contact) a.disturbed = true;
  const bool impact = a.in_contact && solver == Solver::articulated;
  const bool changed_rule = impact && (a.second_order || a.fresh) && !stayed;
  if (impact) {
    in.rule = Rule::euler, in.first = false;
    a.second_order = a.fresh = false;
  }
  EndSums end = kernels().update_velocities(p, in);
  end.changed_rule = changed_rule;
  if (stayed) {
    kernels().scale(p, 0, &drift[0]);
    a.energy_removed += a.kinetic_before;
    end.kinetic = 0.5 * a.mass * glm::dot(drift, drift);
  }
  return end;
}

}  // namespace

EndSums close_joints(World& world, Island& a, Real h) {
  const IslandView p = view_of(world, a);
  const VelocityInput in{h,
                         {world.gravity.x, world.gravity.y, world.gravity.z},
                         rule_of(a),
                         a.fresh,
                         a.settings.calm_angle};
  a.in_contact = a.contact_active = false;
  if (!is_plain(a)) return close_in_turn(world, a, in);
  if (a.settings.solver == Solver::articulated) return close_plain(a, p, in);
  const bool one_held_tree = a.trees.size() == 1 && a.parents.front() == kHeld;
  if (a.settings.solver == Solver::sweep && one_held_tree)
    return kernels().sweep_and_update(p, a.scratch.targets.data(), a.settings.rotation_stiffness,
                                      in);
  return close_in_turn(world, a, in);
}

}  // namespace pantin::detail::articulated
