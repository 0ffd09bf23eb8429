// Energy of steps that do not conserve it. Allowed sources are the energy before, kinematic bodies
// that move, and applied forces. For the rules of the paper, severalfold growth is reported. A step
// of `auto` by sweeps has its excess energy removed.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Factor of "severalfold" growth: excess over the energy supplied, relative to the initial energy
/// and to the scale of the island's motion (a fall through its own size, rotation at 1 rad/s).
constexpr Real kSeveral = 3;

struct Energy {
  Real kinetic = 0, potential = 0;  // J
  Real whole() const { return kinetic + potential; }
};

Energy energy_of(const World& world, const Island& a) {
  Energy e;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    const Vec3 w = glm::conjugate(b.pose.rotation) * b.angular_velocity;
    e.kinetic += 0.5 * (b.mass * glm::dot(b.velocity, b.velocity) + glm::dot(b.inertia, w * w));
    e.potential -= b.mass * b.gravity_scale * glm::dot(world.gravity, b.pose.position);
  }
  return e;
}

/// Speed of the fastest anchor of the island, m/s. For the rules of the paper a gap to be closed
/// counts as displacement.
Real fastest_anchor_speed(const World& world, const Island& a, Real h) {
  Real most = 0;
  for (const Tree& t : a.trees)
    if (a.parents[t.first] == kHeld)
      most = std::max(most, glm::length(t.target - t.target_before) / h);
  for (const PackedPin& constraint : a.pins) {
    if (constraint.compliance > 0) continue;  // springs are not solved here
    const Vec3 way =
        constraint.partner == UINT32_MAX ? constraint.target - constraint.target_before : Vec3(0);
    const bool closes = a.settings.solver != Solver::articulated;
    const Real gap = closes ? std::max(glm::length(constraint.gap_before), constraint.residual) : 0;
    most = std::max(most, (glm::length(way) + gap) / h);
  }
  for (const PackedCable& c : a.cables) {
    const Cable& s = world.cables.values()[c.cable];
    if (is_reeled(c.before(), s.joint))
      most = std::max(most, std::abs(s.joint.length - c.length_before) / h);
    if (c.column_a != UINT32_MAX && c.column_b != UINT32_MAX) continue;
    const bool a_moves = c.column_a != UINT32_MAX;
    const Body& holder = world.bodies.values()[a_moves ? c.slot_b : c.slot_a];
    const Vec3 arm = holder.pose.rotation * (a_moves ? s.joint.anchor_b : s.joint.anchor_a);
    most = std::max(most, glm::length(holder.velocity + glm::cross(holder.angular_velocity, arm)));
  }
  return most;
}

/// Velocities before the step. Islands with pins or cables store them apart, since the iterations
/// of a step that closes gaps overwrite the rows of kMove; sweeps do not.
void keep_velocity(Island& a, std::size_t c, Vec3 v) {
  if (has_rows(a))
    a.scratch.velocities[c] = v;
  else
    a.memory.set(kMove, c, v);
}
Vec3 velocity_before(const Island& a, std::size_t c) {
  return has_rows(a) ? a.scratch.velocities[c] : a.memory.vec(kMove, c);
}

/// Upper bound on the work done on the island in the step: the forces on its bodies other than
/// weight and applied ones, times the displacement of the fastest anchor; and the applied work.
Real most_work(const World& world, const Island& a, Real h) {
  Real pulls = 0, pushed = 0;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    Vec3 change =
        b.mass * (b.velocity - velocity_before(a, c) - h * b.gravity_scale * world.gravity);
    const Force* f = a.forced ? world.forces.find(a.bodies[c]) : nullptr;
    if (f) {
      change -= h * f->force;
      pushed += h * std::max(Real(0), glm::dot(f->force, b.velocity) +
                                          glm::dot(f->torque, b.angular_velocity));
    }
    pulls += glm::length(change);
  }
  PANTIN_ASSERT(!has_rows(a) || a.scratch.velocities.size() == a.count());
  const Real speed = fastest_anchor_speed(world, a, h);
  return pulls * speed + pushed;
}

/// As a fraction of the kinetic energy.
constexpr Real kRounding = 1e-13;

/// Whether nothing connects the island to the world.
bool flies_free(const Island& a) {
  const auto to_world = [](const PackedCable& c) {
    return c.column_a == UINT32_MAX || c.column_b == UINT32_MAX;
  };
  return a.scratch.contact_rows.empty() && a.pins.empty() &&
         std::none_of(a.cables.begin(), a.cables.end(), to_world) &&
         std::all_of(a.trees.begin(), a.trees.end(),
                     [&](const Tree& t) { return a.parents[t.first] == kFree; });
}

/// Scales the velocities so that the kinetic energy is at most `allowed`, J. A free island keeps
/// the motion of its mass centre.
void slow_down(World& world, Island& a, Real kinetic, Real allowed) {
  Vec3 mean(0);
  Real mass = 0;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    mean += b.mass * b.velocity, mass += b.mass;
  }
  mean = flies_free(a) ? mean / mass : Vec3(0);
  const Real whole = 0.5 * mass * glm::dot(mean, mean);
  const Real within = kinetic - whole > kRounding * kinetic ? kinetic - whole : 0;
  const Real left = std::max(Real(0), allowed - whole);
  const Real factor = within > 0 ? std::sqrt(std::min(Real(1), left / within)) : 1;
  if (factor == 1) return;
  kernels().scale(view_of(world, a), factor, &mean[0]);
  for (Tree& t : a.trees) t.angular_momentum *= factor;
}

/// Potential energy at the final poses, J.
Real potential_of_final(const World& world, const Island& a) {
  Real sum = 0;
  for (std::size_t c = 0; c < a.count(); ++c)
    sum -= a.constants.at(kMass, c) * a.constants.at(kGravityScale, c) *
           glm::dot(world.gravity, a.scratch.work.vec(kFinalPosition, c));
  return sum;
}

/// Undoes a step by a half, by three quarters or completely, until the potential energy is at most
/// `allowed`. The bodies are then at rest, with closed joints.
void take_back(World& world, Island& a, Real allowed) {
  const Kernels& k = kernels();
  const IslandView p = view_of(world, a);
  LaneTable& w = a.scratch.work;
  for (const Real back : {0.5, 0.75, 1.0}) {
    for (std::size_t c = 0; c < a.count(); ++c) {
      const Pose& pose = world.bodies.values()[a.slots[c]].pose;
      const Quat rotation = from_rotation_vector(-back * a.memory.vec(kLastRotation, c));
      w.set(kPosition, c, pose.position - back * a.memory.vec(kLastTranslation, c));
      w.set(kRotation, c, glm::normalize(rotation * pose.rotation));
    }
    k.levers(p, kPosition, kRotation);
    k.sweep(p, a.scratch.targets.data(), kPosition, a.settings.rotation_stiffness);
    k.apply_poses(p, kRotation);
    if (!a.joints.empty()) sweep_closed(world, a);
    if (has_rows(a)) relax(world, a);
    if (potential_of_final(world, a) <= allowed) break;
  }
  for (std::size_t c = 0; c < a.count(); ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.pose = {w.vec(kFinalPosition, c), w.quat(kFinalRotation, c)};
    b.velocity = b.angular_velocity = Vec3(0);
  }
}

/// Removes the energy above `allowed`, J, from a step of `auto` by sweeps.
void limit_energy(World& world, Island& a, const Energy& now, Real allowed) {
  const Real slack = 1e-12 * (std::abs(now.potential) + std::abs(allowed));
  if (!a.settings.limiter || !(now.whole() > allowed + slack)) return;
  slow_down(world, a, now.kinetic, allowed - now.potential);
  if (!flies_free(a) && now.potential > allowed + slack) take_back(world, a, allowed);
  // Energy that sweeps add towards an unreachable pin does not count as removed.
  const bool pulls =
      std::any_of(a.pins.begin(), a.pins.end(), [](const PackedPin& p) { return !p.reachable; });
  const Real removed = now.whole() - energy_of(world, a).whole();
  if (pulls || !(removed > 0)) return;
  a.limited = true, a.energy_removed += removed;
}

}  // namespace

void begin_watch(const World& world, Island& a) {
  a.grew = a.limited = false;
  for (std::size_t c = 0; c < a.count(); ++c)
    keep_velocity(a, c, world.bodies.values()[a.slots[c]].velocity);
  if (a.fresh || a.changed) a.watched = false;
  if (a.settings.solver == Solver::articulated) a.budget = energy_of(world, a).whole();
}

void end_closing(World& world, Island& a, Real h) {
  const Energy now = energy_of(world, a);
  const Real allowed = a.budget + most_work(world, a, h);
  if (!(now.whole() > allowed)) return;
  slow_down(world, a, now.kinetic, allowed - now.potential);
}

void end_watch(World& world, Island& a, Real h) {
  const Energy now = energy_of(world, a);
  const Real work = most_work(world, a, h);
  if (a.settings.solver == Solver::articulated) return limit_energy(world, a, now, a.budget + work);
  // The first step closes initial gaps; with contacts there is no energy account.
  if (!a.watched || !a.scratch.contact_rows.empty()) {
    a.watched = true, a.budget = now.whole();
    a.usual = now.kinetic + a.mass * a.size * (glm::length(world.gravity) + 0.5 * a.size);
    return;
  }
  a.budget += work;
  a.grew = !(now.whole() <= a.budget + kSeveral * a.usual);
  // Energy lost must not return much later: the budget follows the energy downwards.
  a.budget = std::min(a.budget, now.whole() + a.usual);
}

}  // namespace pantin::detail::articulated
