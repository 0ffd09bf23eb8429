// The update stage: targets, forces and free motion of the bodies.
#include <algorithm>

#include "engine/joints/joint_force.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/world/joint_drive.hpp"

namespace pantin::detail::articulated {

/// Targets come from pins and from kinematic bodies.
void set_targets(const World& world, Island& a, Real h) {
  a.scratch.targets.clear();
  const auto place = [&](std::uint32_t body, std::uint32_t pin, Vec3 anchor) {
    PANTIN_ASSERT(body != UINT32_MAX || pin < world.pins.size());
    return body != UINT32_MAX ? point_on(world, body, anchor) : world.pins.values()[pin].target;
  };
  // In the first step, joints were closed at the kinematic body's pose one step before.
  const auto before = [&](std::uint32_t slot, Vec3 anchor, Vec3 now) {
    const bool comes =
        slot != UINT32_MAX && world.bodies.values()[slot].motion == Motion::kinematic;
    return comes ? point_before(world, slot, anchor, h) : now;
  };
  for (Tree& t : a.trees) {
    if (a.parents[t.first] == kHeld) {
      const Vec3 now = place(t.held_body, t.held_pin, t.anchor);
      t.target_before = a.has_targets ? t.target : before(t.held_body, t.anchor, now);
      t.target = now;
    }
    for (int n = 0; n < 3; ++n) a.scratch.targets.push_back(t.target[n]);
  }
  for (PackedPin& p : a.pins) {
    if (p.partner != UINT32_MAX) continue;  // loops are not anchored in the world
    const Vec3 now = place(p.held_body, p.held_pin, p.held_anchor);
    p.target_before = a.has_targets ? p.target : before(p.held_body, p.held_anchor, now);
    p.target = now;
    if (!a.has_targets)
      p.gap_before = p.target_before - point_on(world, a.slots[p.column], p.anchor);
  }
  a.has_targets = true;
}

namespace {

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
  const Real ratio = jumped ? 0 : (a.last_step > 0 && !a.fresh ? h / a.last_step : 1);
  if (ratio != 1) {
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
  a.forced = false;
  const Real acts = 1 - a.owed / a.step;  // forces are those of the present step alone
  for (std::size_t c = 0; !world.forces.empty() && c < a.count(); ++c) {
    const Force* found = world.forces.find(a.bodies[c]);
    const Force f = found ? *found : Force{};
    // Components of earlier forces remain, with zero force.
    a.forced = a.forced || f.force != Vec3(0) || f.torque != Vec3(0);
    PANTIN_ASSERT(!a.scratch.forces.numbers().empty());
    a.scratch.forces.set(0, c, acts * f.force / a.constants.at(kMass, c));
    a.scratch.forces.set(3, c, acts * f.torque);
  }
}

}  // namespace

Rule rule_of(const Island& a) {
  const Solver s = a.settings.solver;
  if (s == Solver::sweep || s == Solver::procedural) return Rule::verlet;
  return s == Solver::shake2 ? Rule::midpoint : Rule::euler;
}

void predict_motion(World& world, Island& a, Real h) {
  a.finite = kernels().predict(
      view_of(world, a),
      {h, {world.gravity.x, world.gravity.y, world.gravity.z}, rule_of(a), a.fresh});
}

namespace {

bool is_sound(const JointDrive& drive, Real time) {
  return std::isfinite(drive.stiffness) && std::isfinite(drive.damping) && drive.max_torque >= 0 &&
         is_finite(target_at(drive, time));
}

}  // namespace

Entity find_unsound(const World& world, const Island& a) {
  for (std::size_t c = 0; c < a.joints.size(); ++c) {
    const PackedJoint& j = a.joints[c];
    if (!j.stiff) continue;
    if (is_actuated(j) && !detail::is_sound(dof_of(world, a, c))) return a.bodies[c];
    PANTIN_ASSERT(is_index_or_none(j.drive, world.joint_drives.size()));
    if (j.drive != UINT32_MAX && !is_sound(world.joint_drives.values()[j.drive], world.time))
      return a.bodies[c];
  }
  return {};
}

void update(World& world, Island& a, Real h) {
  a.scratch.predicted = true, a.conserves = false;
  if (a.unfit || find_unsound(world, a)) {
    a.finite = false;
    return predict_still(world, a);
  }
  if (a.asleep) return predict_still(world, a);
  if (!world.forces.empty() && a.scratch.forces.numbers().empty())
    a.scratch.forces.resize(6, a.count());
  set_targets(world, a, h);
  notice_changes(world, a, h);
  collect_forces(world, a);
  a.finite = true;
  // Without colliders, the energy-momentum method needs no prediction.
  a.conserves = conserves(world, a);
  if (!world.collisions.empty() || !a.conserves) predict_motion(world, a, h);
}

}  // namespace pantin::detail::articulated
