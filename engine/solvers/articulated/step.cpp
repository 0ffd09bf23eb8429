#include <algorithm>
#include <cstddef>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr std::size_t words(std::size_t bytes) { return bytes / sizeof(Real); }

static_assert(sizeof(Body) % sizeof(Real) == 0);
static_assert(offsetof(Quat, x) == 0 && offsetof(Quat, w) == 3 * sizeof(Real));

const BodyLayout kLayout{words(sizeof(Body)), words(offsetof(Body, pose.position)),
                         words(offsetof(Body, pose.rotation)), words(offsetof(Body, velocity)),
                         words(offsetof(Body, angular_velocity))};

/// Targets of roots and pins, from pins and from kinematic bodies.
void set_targets(const World& world, Island& a) {
  a.scratch.targets.clear();
  const auto place = [&](std::uint32_t body, std::uint32_t pin, Vec3 anchor) {
    return body != UINT32_MAX ? point_on(world, body, anchor) : world.pins.values()[pin].target;
  };
  for (Tree& t : a.trees) {
    if (a.parents[t.first] == kHeld) {
      const Vec3 now = place(t.held_body, t.held_pin, t.anchor);
      t.target_before = a.has_targets ? t.target : now, t.target = now;
    }
    for (int n = 0; n < 3; ++n) a.scratch.targets.push_back(t.target[n]);
  }
  for (PackedPin& h : a.pins) {
    if (h.partner != UINT32_MAX) continue;  // loops are not anchored in the world
    const Vec3 now = place(h.held_body, h.held_pin, h.held_anchor);
    h.target_before = a.has_targets ? h.target : now, h.target = now;
    if (!a.has_targets) h.gap_before = h.target - point_on(world, a.slots[h.column], h.anchor);
  }
  a.has_targets = true;
}

/// Bodies changed by the caller: resets state that is no longer valid.
void notice_changes(World& world, Island& a, Real h) {
  bool changed = false, jumped = false;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    changed = changed || b.restart, jumped = jumped || b.teleport;
  }
  for (const Tree& t : a.trees)
    if (t.held_body != UINT32_MAX) jumped = jumped || world.bodies.values()[t.held_body].teleport;
  a.changed = changed || jumped;
  if (a.changed) a.calm_steps = 0;
  const Real ratio = jumped ? 0 : (a.last_step > 0 && !a.fresh ? h / a.last_step : 1);
  if (ratio != 1) {
    a.calm_steps = 0;
    for (std::size_t c = 0; c < a.count(); ++c)
      a.memory.set(kLambda, c, ratio * ratio * a.memory.vec(kLambda, c));
    for (PackedCable& cord : a.cables) cord.lambda *= ratio * ratio;
    for (PackedPin& constraint : a.pins) constraint.lambda *= ratio * ratio;
  }
  for (Tree& t : a.trees) {
    if (a.parents[t.first] != kFree || !(changed || a.fresh || !t.knows_angular_momentum)) continue;
    t.angular_momentum = angular_momentum(world, a, t), t.knows_angular_momentum = true;
  }
}

void collect_forces(const World& world, Island& a) {
  a.forced = !world.forces.empty();
  if (!a.forced) return;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Force* f = world.forces.find(a.bodies[c]);
    const Real mass = a.constants.at(kMass, c);
    a.scratch.forces.set(0, c, f ? f->force / mass : Vec3(0));
    a.scratch.forces.set(3, c, f ? f->torque : Vec3(0));
  }
}

/// Displacement per step made by a constant force, divided by h^2 force / mass. The second-order
/// rule applies drag to it, as to the weight.
Real share_of_forces(const Island& a, Real h) {
  if (a.fresh) return 0.5;
  if (!a.second_order) return 1;
  Real mass = 0, drag = 0;
  for (std::size_t c = 0; c < a.count(); ++c)
    mass += a.constants.at(kMass, c), drag += a.constants.at(kMass, c) * a.constants.at(kDrag, c);
  return 4.0 / 9 / (1 + 2.0 / 3 * h * drag / mass);
}

Rule rule_of(const Island& a) {
  const Solver s = a.settings.solver;
  if (s == Solver::sweep || s == Solver::paper) return Rule::verlet;
  if (s == Solver::shake2) return Rule::midpoint;
  return a.second_order ? Rule::bdf2 : Rule::euler;
}

bool has_rows(const Island& a) { return !a.pins.empty() || !a.cables.empty(); }

bool has_active_contacts(const World& world, const Island& a) {
  return std::any_of(a.scratch.contact_rows.begin(), a.scratch.contact_rows.end(),
                     [&](const ContactRow& t) { return contacts_of(world)[t.contact].active; });
}

/// Whether the island has only free ball joints in this step.
bool is_plain(const Island& a) {
  return !has_rows(a) && a.joints.empty() && a.scratch.contact_rows.empty();
}

/// Inward half of the general solve at the predicted poses, with lambdas of cables, pins and loops.
void eliminate_once(World& world, Island& a, Real h) {
  StepScratch& r = a.scratch;
  // The blocks of the bodies are constant over the iterations; contacts are not.
  r.joint_blocks = r.base;
  a.stiff_contacts = !a.iterates && has_active_contacts(world, a);
  if (a.stiff_contacts) add_contact_rows(world, a, r.joint_blocks);
  inward_pass(a);
  if (has_rows(a)) solve_rows(world, a, h, kPosition, kRotation, false);
}

/// Outward half: final poses and update of the active set. True if unchanged.
bool apply_once(World& world, Island& a, Real h) {
  const bool converged = outward_pass(world, a, h, kPosition, kRotation, false);
  kernels().apply_poses(view_of(world, a), kRotation);
  return (a.iterates ? update_iterated(world, a) : update_contacts(world, a)) && converged;
}

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
    fill_base(a, true);
    add_cable_stiffness(world, a, r.base, kPosition, kRotation);
    eliminate_once(world, a, h);
    apply_once(world, a, h);
    worst = std::max(worst_stretch(world, a), worst_pin_gap(a));
  }
  // The lambdas of the step itself are kept for the next step.
  for (std::size_t c = 0; c < a.count(); ++c) r.lambdas[c] = a.memory.vec(kLambda, c);
  for (int round = 0; round < a.settings.sweeps && worst > enough; ++round) {
    kernels().prepare(p, kFinalPosition, kFinalRotation, false);
    if (!a.joints.empty()) set_terms(world, a, h, kFinalRotation, true);
    keep_gaps(a);
    fill_base(a, true);
    r.joint_blocks = r.base;
    inward_pass(a);
    solve_rows(world, a, h, kFinalPosition, kFinalRotation, true);
    outward_pass(world, a, h, kFinalPosition, kFinalRotation, true);
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
  if (a.settings.solver == Solver::paper) {
    literal_sweep(a, h);
    return;
  }
  const Kernels& k = kernels();
  k.levers(p, kPosition, kRotation);
  k.sweep(p, a.scratch.targets.data(), kPosition, a.settings.rotation_stiffness);
  k.apply_poses(p, kRotation);
}

/// The first body whose state or final position is not finite or out of bounds.
Entity find_lost(const World& world, const Island& a) {
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    if (!(is_finite(b.pose) && is_finite(b.velocity) && is_finite(b.angular_velocity)))
      return a.bodies[c];
    const Vec3 x = a.scratch.work.vec(kAttach, c);
    if (!(glm::dot(x, x) < kTooFar * kTooFar) ||
        !is_finite(a.scratch.work.quat(kAppliedRotation, c)))
      return a.bodies[c];
  }
  return a.bodies.front();
}

/// Writes residuals and tensions back to pins and cables.
void report_holds(World& world, Island& a, Real h) {
  const Real to_force = 1 / (a.force_share * h * h);
  for (PackedPin& constraint : a.pins) {
    const Vec3 at = point_on(world, a.slots[constraint.column], constraint.anchor);
    const Vec3 to = constraint.partner == UINT32_MAX
                        ? constraint.target
                        : point_on(world, a.slots[constraint.partner], constraint.held_anchor);
    constraint.gap_before = to - at;
    constraint.residual = glm::length(constraint.gap_before);
    if (constraint.held_pin == UINT32_MAX) continue;
    Pin& pin = world.pins.values()[constraint.held_pin];
    pin.residual = constraint.residual, pin.reachable = constraint.reachable;
    pin.missed = pin.grip == Grip::exact && pin.residual > a.settings.tolerance * a.size;
  }
  for (const Tree& t : a.trees) {
    if (t.held_pin == UINT32_MAX) continue;
    Pin& pin = world.pins.values()[t.held_pin];
    const Vec3 at = point_on(world, a.slots[t.first], pin.anchor);
    pin.residual = glm::length(t.target - at), pin.reachable = true;
    pin.missed = pin.residual > a.settings.tolerance * a.size;
  }
  for (const PackedCable& cord : a.cables)
    world.cables.values()[cord.cable].tension = to_force * cord.lambda;
}

}  // namespace

IslandView view_of(World& world, Island& a) {
  return {a.count(),
          a.slots.data(),
          a.parents.data(),
          reinterpret_cast<Real*>(world.bodies.values().data()),
          kLayout,
          a.constants.data(),
          a.memory.data(),
          a.scratch.work.data(),
          a.scratch.nodes.data(),
          a.forced ? a.scratch.forces.data() : nullptr,
          a.is_chain};
}

Vec3 point_at(const Island& a, std::size_t column, Vec3 anchor, Work position_row,
              Work rotation_row) {
  return a.scratch.work.vec(position_row, column) +
         a.scratch.work.quat(rotation_row, column) * anchor;
}

Vec3 point_on(const World& world, std::uint32_t slot, Vec3 anchor) {
  return to_world(world.bodies.values()[slot].pose, anchor);
}

namespace {

/// Allocates memory of the general solve when a step first needs it.
void reserve_general_solve(Island& a) {
  StepScratch& r = a.scratch;
  const std::size_t n = a.count(), rows = 3 * a.pins.size() + a.cables.size();
  if (r.forces_in.empty() && a.iterates) r.forces_in.assign(n, {}), r.torques_in.assign(n, {});
  if (r.joint_nodes.size() == n) return;
  r.joint_nodes.assign(n, {}), r.base.assign(n, {}), r.joint_blocks.assign(n, {});
  r.terms.assign(a.joints.empty() ? 0 : n, {});
  r.translation.assign(n, Vec3(0)), r.rotation.assign(n, Vec3(0)), r.levers.assign(n, Vec3(0));
  r.gaps.assign(n, Vec3(0)), r.lambdas.assign(n, Vec3(0));
  r.rotations.assign(n, kIdentity);
  if (rows == 0) return;
  r.forces_in.assign(n, {}), r.torques_in.assign(n, {});
  r.on_path.assign(std::max(n, rows), 0);
  r.rows.reserve(rows), r.response.assign(rows * rows, 0);
  r.factor.assign(rows * rows, 0), r.solved.assign(rows, 0);
}

bool has_free_tree(const Island& a) {
  return std::any_of(a.trees.begin(), a.trees.end(),
                     [&](const Tree& t) { return a.parents[t.first] == kFree; });
}

bool has_colliders(const World& world, const Island& a) {
  return std::any_of(a.bodies.begin(), a.bodies.end(),
                     [&](Entity e) { return world.collisions.find(e) != nullptr; });
}

}  // namespace

void prepare(World& world) {
  Islands& all = world.memory.of<Islands>();
  if (all.scratch.prepared) return;  // a copy brings no scratch along
  all.scratch.prepared = true;
  for (Island& a : all.list) {
    if (a.scratch.targets.capacity() > 0) continue;  // goes on as it was
    const std::size_t n = a.count(), padded = a.slots.size();
    const bool shake = a.settings.solver == Solver::shake2;
    StepScratch& r = a.scratch;
    r.work.resize(kWorkRows, n);
    for (std::size_t c = n; c < padded; ++c)
      r.work.at(kAppliedRotation + 3, c) = 1;  // padding: identity rotation
    r.nodes.assign(kNodeSize * n, 0);
    r.targets.reserve(3 * a.trees.size());
    if (!world.forces.empty()) r.forces.resize(6, n);
    if (!a.is_chain || shake) r.blocks.assign(kBlockSize * n, 0);
    if (shake) r.translation.assign(n, Vec3(0)), r.rotation.assign(n, Vec3(0));
    if (shake || has_free_tree(a)) r.lambdas.assign(n, Vec3(0));  // also outboard masses
    if (has_rows(a) || !a.joints.empty()) reserve_general_solve(a);
    if (!world.collisions.empty() && has_colliders(world, a)) {
      r.contact_rows.reserve(8 * n);
      reserve_general_solve(a);
    }
  }
}

bool must_wake(const World& world, const Island& a) {
  if (world.gravity != a.asleep_gravity) return true;
  for (const Tree& t : a.trees)
    if (t.target != t.target_before) return true;
  for (const PackedPin& h : a.pins)
    if (h.target != h.target_before) return true;
  for (const Entity e : a.bodies) {
    const Body& b = world.bodies[e];
    if (b.restart || b.teleport || b.velocity != Vec3(0) || b.angular_velocity != Vec3(0))
      return true;
    const Force* f = world.forces.find(e);
    if (f && (f->force != Vec3(0) || f->torque != Vec3(0))) return true;
  }
  return false;
}

void wake(World& world, Island& a, Real h) {
  a.asleep = false, a.quiet_time = 0;
  update(world, a, h);
}

/// What does not move is where it is, for others that look for it.
void predict_still(const World& world, Island& a) {
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Pose& pose = world.bodies.values()[a.slots[c]].pose;
    a.scratch.work.set(kPosition, c, pose.position),
        a.scratch.work.set(kRotation, c, pose.rotation);
  }
}

void update(World& world, Island& a, Real h) {
  a.scratch.predicted = true;
  if (a.unfit) {
    a.finite = false;
    return predict_still(world, a);
  }
  if (a.asleep) {
    set_targets(world, a);
    if (!must_wake(world, a)) return predict_still(world, a);
    a.asleep = false, a.quiet_time = 0;
  }
  if (!world.forces.empty() && a.scratch.forces.numbers().empty())
    a.scratch.forces.resize(6, a.count());
  set_targets(world, a);
  notice_changes(world, a, h);
  collect_forces(world, a);
  a.second_order = a.settings.solver == Solver::articulated && !a.fresh && a.calm_steps >= 2;
  a.force_share = share_of_forces(a, h);
  const IslandView p = view_of(world, a);
  const StartSums start = kernels().predict(
      p, {h, {world.gravity.x, world.gravity.y, world.gravity.z}, rule_of(a), a.fresh});
  a.energy_before = start.kinetic + start.potential, a.kinetic_before = start.kinetic;
  a.damped = start.damped;
  a.finite = start.finite;
  a.momentum_before = Vec3(start.momentum[0], start.momentum[1], start.momentum[2]);
  if (a.finite && a.settings.solver != Solver::articulated) begin_watch(world, a);
}

void begin_step(World& world, Island& a, Real h) {
  a.disturbed = a.limited = false;
  a.sweeps_used = a.active_set_iterations_used = a.stops_hit = a.drives_capped = 0;
  a.stop_work = 0, a.iterates = false;
  if (!a.finite || a.settings.solver != Solver::articulated || is_plain(a)) return;
  reserve_general_solve(a);
  const bool tension = a.settings.tension_stiffness;
  kernels().prepare(view_of(world, a), kPosition, kRotation, false);
  if (!a.joints.empty()) set_terms(world, a, h, kRotation, false);
  keep_gaps(a);
  fill_base(a, tension);
  if (tension) add_cable_stiffness(world, a, a.scratch.base, kPosition, kRotation);
  prepare_contacts(world, a, h);
  if (!a.joints.empty() && has_active_contacts(world, a)) regularise_limits(a);
}

namespace {

bool needs_active_set(const Island& a) {
  return a.finite && a.settings.solver == Solver::articulated && !is_plain(a);
}

}  // namespace

void begin_iterating(World& world, Island& a) {
  if (a.iterates || !needs_active_set(a)) return;
  a.iterates = true;
  reserve_general_solve(a);
  for (std::size_t c = 0; c < a.joints.size(); ++c)
    for (Stop& stop : a.scratch.terms[c].stops) {
      stop.nonlinearity = 0;
      if (stop.both_ways) continue;
      stop.on = false, stop.weight = 0;
      stop.lambda = std::max(Real(0), a.joint_memory[c].lambdas[&stop - a.scratch.terms[c].stops]);
    }
  for (ContactRow& t : a.scratch.contact_rows) {
    t.nonlinearity = Vec3(0);
    if (t.side > 0) contacts_of(world)[t.contact].lambda = contacts_of(world)[t.contact].before;
  }
}

void begin_iteration(World& world, Island& a, Real h) {
  if (!needs_active_set(a)) return;
  ++a.active_set_iterations_used;
  eliminate_once(world, a, h);
  free_response(a, kPosition);
  find_contact_response(world, a);
}

bool end_iteration(World& world, Island& a, Real h) {
  if (!needs_active_set(a)) return true;
  add_iterated_lambdas(world, a);
  return apply_once(world, a, h);
}

void iterate_mutual(World& world, Real h) {
  std::vector<Island*>& all = world.memory.of<Islands>().mutual.list;
  all.clear();
  for (Island& a : islands_of(world))
    if (a.mutual && needs_active_set(a)) all.push_back(&a);
  iterate_contacts(world, all, h, 100, 1e-9);
}

namespace {

/// Free ball joints only: all passes in one loop.
EndSums close_plain(Island& a, const IslandView& p, const VelocityInput& in) {
  const Kernels& k = kernels();
  if (p.is_chain) {
    k.inward_pass_chain(p, a.settings.tension_stiffness);
  } else {
    k.prepare(p, kPosition, kRotation, a.settings.tension_stiffness);
    k.fill_blocks(p, a.scratch.blocks.data());
    k.inward_pass_tree(p, a.settings.tension_stiffness, a.scratch.blocks.data());
  }
  return k.outward_pass_and_update(p, a.scratch.targets.data(), in);
}

/// Stores the multipliers of limits and the state of drives after the last iteration.
void store_limits(Island& a, Real h) {
  for (std::size_t c = 0; c < a.joints.size(); ++c) {
    const PackedJoint& j = a.joints[c];
    if (!j.stiff) continue;
    bool hit = false;
    for (int s = 0; s < 4; ++s) {
      const Stop& stop = a.scratch.terms[c].stops[s];
      const bool is_active = stop.on || (a.iterates && stop.lambda > 0);
      a.joint_memory[c].lambdas[s] = is_active ? stop.lambda : 0;
      hit = hit || (is_active && !stop.both_ways);
    }
    a.stops_hit += hit;
    a.drives_capped += j.drive != UINT32_MAX && a.joint_memory[c].torque_fraction < 1;
    a.stop_work += work_of_springs(a, c, h);
  }
}

/// Kinetic and potential energy and momentum of the bodies.
void sum_up(const World& world, const Island& a, EndSums& end) {
  end.kinetic = end.potential = 0;
  Vec3 momentum(0);
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    momentum += b.mass * b.velocity;
    const Vec3 w = glm::conjugate(b.pose.rotation) * b.angular_velocity;
    end.kinetic += 0.5 * (b.mass * glm::dot(b.velocity, b.velocity) + glm::dot(b.inertia, w * w));
    end.potential -= b.mass * b.gravity_scale * glm::dot(world.gravity, b.pose.position);
  }
  for (int n = 0; n < 3; ++n) end.momentum[n] = momentum[n];
}

}  // namespace

namespace {

constexpr Real kTimeToSleep = 0.5;  // s

/// Falls asleep after resting on fixed bodies long enough. Islands in contact with other dynamic
/// islands, or with joint drives or cables, stay awake.
void update_sleep(World& world, Island& a, Real h) {
  const Real slow = a.settings.sleep_speed;
  bool still = a.contact_active && !a.mutual && a.cables.empty();
  for (std::size_t c = 0; still && c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    still = glm::length(b.velocity) < slow && glm::length(b.angular_velocity) < 10 * slow;
    still = still && (a.joints.empty() || a.joints[c].drive == UINT32_MAX);
  }
  a.quiet_time = still ? a.quiet_time + h : 0;
  a.asleep = a.quiet_time > kTimeToSleep;
  if (!a.asleep) return;
  a.asleep_gravity = world.gravity;
  for (std::uint32_t c = 0; c < a.count(); ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.velocity = b.angular_velocity = Vec3(0);
    a.memory.set(kLastTranslation, c, Vec3(0)), a.memory.set(kLastRotation, c, Vec3(0));
    a.memory.set(kVelocityBefore, c, Vec3(0)), a.memory.set(kAngularMomentumBefore, c, Vec3(0));
  }
}

}  // namespace

namespace {

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

}  // namespace

bool finish_step(World& world, Island& a, Real h, Entity& lost) {
  if (!a.finite) {  // before joints can hide it
    lost = a.unfit ? a.unfit : find_lost(world, a);
    return false;
  }
  const IslandView p = view_of(world, a);
  const Kernels& k = kernels();
  const Solver solver = a.settings.solver;
  VelocityInput in{h,
                   {world.gravity.x, world.gravity.y, world.gravity.z},
                   rule_of(a),
                   a.fresh,
                   a.settings.calm_angle};
  const bool one_held_tree = a.trees.size() == 1 && a.parents.front() == kHeld;
  a.in_contact = a.contact_active = false;
  bool changed_rule = false;
  EndSums end;
  if (is_plain(a) && solver == Solver::articulated) {
    end = close_plain(a, p, in);
  } else if (is_plain(a) && solver == Solver::sweep && one_held_tree) {
    end = k.sweep_and_update(p, a.scratch.targets.data(), a.settings.rotation_stiffness, in);
  } else {
    if (solver == Solver::articulated) {
      if (has_rows(a)) close_rows(world, a, h);
      if (!a.joints.empty()) store_limits(a, h);
      a.contact_active = has_active_contacts(world, a);
      a.in_contact = a.stops_hit > 0 || a.contact_active;
    } else if (solver == Solver::shake2) {
      close_shake(world, a, p, h);
    } else {
      close_kinematic(a, p, h);
    }
    if (!a.joints.empty() && solver != Solver::articulated) sweep_closed(world, a);
    if (has_rows(a)) relax(world, a, solver != Solver::articulated);
    if (!a.scratch.contact_rows.empty()) push_out_trees(world, a);
    Vec3 drift(0);
    const bool may_stay =
        solver == Solver::articulated && (!a.scratch.contact_rows.empty() || a.in_contact);
    const bool stayed = may_stay && stays(world, a, h, drift);
    if (stayed) a.in_contact = a.limited = true;
    // After an impact the history is invalid: first-order rule.
    if (a.in_contact) a.disturbed = true;
    if (a.in_contact && solver == Solver::articulated) {
      changed_rule = (a.second_order || a.fresh) && !stayed;
      in.rule = Rule::euler, in.first = false;
      a.second_order = a.fresh = false;
    }
    end = k.update_velocities(p, in);
    if (stayed) {
      k.scale(p, 0, &drift[0]);
      end.kinetic = 0.5 * a.mass * glm::dot(drift, drift);
    }
  }
  if (!end.sane) {
    lost = find_lost(world, a);
    return false;
  }
  // No momentum correction in contact: it could cause penetration, and contacts change the angular
  // momentum.
  if (a.scratch.contact_rows.empty()) {
    if (repair_momentum(world, a, h)) sum_up(world, a, end);
  } else {
    for (Tree& t : a.trees) t.knows_angular_momentum = false;
  }
  if (!a.scratch.contact_rows.empty()) a.stop_work += finish_contacts(world, a, h);
  if (changed_rule) scale_to_momentum(world, a, end, h);
  const bool small_rotations =
      end.largest_rotation2 < a.settings.calm_angle * a.settings.calm_angle;
  a.disturbed = a.disturbed || !small_rotations;
  if (solver == Solver::articulated)
    limit_energy(world, a, p, end, h);
  else
    end_watch(world, a, h);
  const bool calm = !a.limited && !a.disturbed;
  a.calm_steps = calm ? std::min(a.calm_steps + 1, 1000) : 0;
  if (has_rows(a) || a.trees.front().held_pin != UINT32_MAX) report_holds(world, a, h);
  for (std::size_t c = 0; a.changed && c < a.count(); ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.restart = b.teleport = false;
  }
  a.fresh = false;
  a.last_step = h;
  update_sleep(world, a, h);
  return true;
}

namespace {

/// Steps without guessing after a wrong guess.
constexpr int kStepsIterating = 4;
/// Guessing iterations; each costs a tenth of a Gauss-Seidel iteration.
constexpr int kGuesses = 8;
/// Largest number of Gauss-Seidel iterations, counted from the third; more do not help.
constexpr int kIterations = 4;
/// With more contacts, substeps are cheaper than iterating.
constexpr std::ptrdiff_t kFewContacts = 24;
/// Substeps of a step that does not converge.
constexpr int kSubsteps = 4;

std::ptrdiff_t bearing(const World& world, const Island& a) {
  return std::count_if(a.scratch.contact_rows.begin(), a.scratch.contact_rows.end(),
                       [&](const ContactRow& t) { return contacts_of(world)[t.contact].active; });
}

/// Active-set iterations from the predicted poses. False without convergence.
bool find_active_set(World& world, Island& a, Real h, bool in_substeps) {
  bool converged = !needs_active_set(a);
  // The active set is warm-started from the last step; one or two iterations mostly confirm it.
  // Otherwise projected Gauss-Seidel finds it.
  const bool few = in_substeps || bearing(world, a) <= kFewContacts;
  const int guesses = few && a.iterating > 0                  ? 0
                      : a.settings.active_set_iterations <= 2 ? a.settings.active_set_iterations
                                                              : kGuesses;
  for (int n = 0; n < guesses && !converged; ++n) {
    ++a.active_set_iterations_used;
    eliminate_once(world, a, h);
    converged = apply_once(world, a, h);
  }
  a.iterating = converged ? 0 : a.iterating > 0 ? a.iterating - 1 : kStepsIterating;
  if (converged || a.settings.active_set_iterations <= 2) return converged;
  if (!in_substeps && bearing(world, a) > kFewContacts) return false;
  begin_iterating(world, a);
  for (int n = 2; n < std::min(kIterations, a.settings.active_set_iterations) && !converged; ++n) {
    begin_iteration(world, a, h);
    Island* const alone[] = {&a};
    iterate_contacts(world, alone, h, 100, 1e-8);
    converged = end_iteration(world, a, h);
  }
  return converged;
}

/// Repeats the step in equal substeps, for rotations too large for one step.
bool adjust_in_substeps(World& world, Island& a, Real h, Entity& lost) {
  for (const ContactRow& t : a.scratch.contact_rows)
    if (t.side > 0) contacts_of(world)[t.contact].lambda = contacts_of(world)[t.contact].before;
  int passes = a.active_set_iterations_used;
  bool sound = true;
  const std::vector<Tree> trees = a.trees;  // their targets in this step
  std::vector<Vec3> forces(a.scratch.contact_rows.size(), Vec3(0));
  for (int part = 1; part <= kSubsteps && sound; ++part) {
    a.substeps_left = kSubsteps - part;
    update(world, a, h / kSubsteps);
    for (std::size_t t = 0; t < trees.size(); ++t) {
      const Vec3 whole = trees[t].target - trees[t].target_before;
      a.trees[t].target = trees[t].target_before + Real(part) / kSubsteps * whole;
      a.trees[t].target_before = a.trees[t].target - whole / Real(kSubsteps);
      for (std::size_t n = 0; n < 3; ++n)
        a.scratch.targets[3 * t + n] = a.trees[t].target[static_cast<int>(n)];
    }
    begin_step(world, a, h / kSubsteps);
    find_active_set(world, a, h / kSubsteps, true);
    passes += a.active_set_iterations_used;
    sound = finish_step(world, a, h / kSubsteps, lost);
    for (std::size_t i = 0; i < forces.size(); ++i)
      forces[i] += contacts_of(world)[a.scratch.contact_rows[i].contact].force / Real(kSubsteps);
  }
  for (std::size_t i = 0; i < forces.size(); ++i)
    if (a.scratch.contact_rows[i].side > 0)
      contacts_of(world)[a.scratch.contact_rows[i].contact].force = forces[i];
  a.active_set_iterations_used = passes, a.substeps_left = 0;
  return sound;
}

}  // namespace

bool adjust(World& world, Island& a, Real h, Entity& lost) {
  if (a.asleep) {
    keep_sleeping_contacts(world, a, h);
    return true;
  }
  begin_step(world, a, h);
  const bool converged = find_active_set(world, a, h, false);
  if (!converged && !a.scratch.contact_rows.empty() && a.settings.active_set_iterations > 2)
    return adjust_in_substeps(world, a, h, lost);
  return finish_step(world, a, h, lost);
}

}  // namespace pantin::detail::articulated
