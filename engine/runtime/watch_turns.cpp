#include "engine/runtime/watch_turns.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/rotation.hpp"
#include "engine/contact/contact.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/runtime/energy_account.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail {
namespace {

/// The largest motions in a substep that a solver, or a Lagrangian integrator, resolves.
struct Range {
  // rad, rotation of a body. The phase error of a second-order method is rotation^2 / 24.
  Real turn = 1e300;
  // rad: angular frequency of a joint's spring times the step. Beyond it an oscillation loses more
  // than a hundredth of its energy each period.
  Real swing = 1e300;
  bool divides_free_turns = true;  // it subdivides steps of free bodies
  // rad, rotation of a body in contact: contacts act once a step.
  Real roll = 1e300;
};
constexpr Range kArticulatedRange{1, 1.5}, kPlanarRange{1, 1}, kNoRange{},
    // All but `implicit` subdivide steps in which a body rotates far.
    kImplicitRange{0.5, 1, false, 1.5}, kLagrangianRange{.swing = 1, .roll = 1.5};

/// Relative tolerance of equal principal moments, and of anchors on the symmetry axis.
constexpr Real kAlike = 1e-3;
/// rad, or m per m of arm: a spring that moves less in a substep hardly oscillates.
constexpr Real kSwing = 0.02;
/// rad in total, and fraction of the island's kinetic energy: impacts and whip tips may rotate that
/// far.
constexpr Real kBriefly = 2 * kPi, kLittle = 0.05;
/// Above this damping ratio a spring does not oscillate.
constexpr Real kDamped = 0.5;

Range range_of_row(std::uint8_t solver, const SolverSettings& settings) {
  if (solver == kPlanar) return kPlanarRange;
  if (solver == kArticulated)
    return settings.solver == Solver::articulated ? kArticulatedRange : kNoRange;
  if (solver != kLagrangian) return kNoRange;
  if (settings.step_tolerance > 0) return {.roll = kLagrangianRange.roll};
  return settings.integrator == Integrator::implicit ? kImplicitRange : kLagrangianRange;
}

/// The settings of the island of a body.
const SolverSettings& settings_of(const World& world, std::uint32_t slot) {
  const std::vector<std::uint32_t>& islands = partition_of(world).island;
  for (std::uint32_t i = 0; i < world.settings.size(); ++i) {
    const std::uint32_t with = world.bodies.slot(world.settings.owners()[i]);
    if (with < islands.size() && slot < islands.size() && islands[with] == islands[slot])
      return world.settings.values()[i];
  }
  return world.default_settings;
}

Range range_of(const World& world, std::uint32_t slot) {
  return range_of_row(owner_of(partition_of(world), slot).solver, settings_of(world, slot));
}

}  // namespace

void TurnWatch::compile(const World& world) {
  link_up(world);
  find_axes(world);
  find_geared(world);
}

/// Marks bodies with ties other than links: the frequency of their springs is unknown.
void TurnWatch::find_geared(const World& world) {
  const auto mark = [&](std::initializer_list<Entity> bodies) {
    for (const Entity e : bodies)
      if (const std::uint32_t slot = world.bodies.slot(e); slot != kNoSlot)
        bodies_[slot].is_geared = true;
  };
  for (const Cable& c : world.cables.values()) mark({c.a, c.b});
  for (const Pin& p : world.pins.values()) {
    if (p.kind == PinKind::exact) mark({p.body, p.to});
    for (const Entity e : {p.body, p.to})
      if (const std::uint32_t slot = world.bodies.slot(e); slot != kNoSlot)
        bodies_[slot].is_sprung = true;
  }
  for (const SurfaceContact& c : world.surface_contacts.values()) mark({c.a, c.b});
  for (const Belt& belt : world.belts.values())
    for (const BeltPulley& p : belt.pulleys) mark({p.body});
  for (const Gear& gear : world.gears.values())
    for (const Entity e : {gear.first, gear.second})
      if (const Link* link = world.links.find(e)) mark({link->a, link->b});
}

/// Lists the links of each body, one body after the other.
void TurnWatch::link_up(const World& world) {
  const std::size_t count = world.bodies.size();
  first_.assign(count + 1, 0), seen_.assign(count, 0);
  const auto each_end = [&](const auto& act) {
    for (std::uint32_t i = 0; i < world.links.size(); ++i)
      for (const Entity e : {world.links.values()[i].a, world.links.values()[i].b})
        if (const std::uint32_t slot = world.bodies.slot(e); slot != kNoSlot) act(slot, i);
  };
  each_end([&](std::uint32_t slot, std::uint32_t) { ++first_[slot + 1]; });
  for (std::size_t i = 0; i < count; ++i) first_[i + 1] += first_[i];
  ends_.resize(first_[count]);
  stack_.assign(first_.begin(), first_.end());
  each_end([&](std::uint32_t slot, std::uint32_t link) { ends_[stack_[slot]++] = link; });
  stack_.reserve(count);
}

void TurnWatch::find_axes(const World& world) {
  bodies_.assign(world.bodies.size(), {});
  for (std::uint32_t slot = 0; slot < bodies_.size(); ++slot) {
    const pantin::Body& b = world.bodies.values()[slot];
    Body& on = bodies_[slot];
    on.is_asked = b.motion == Motion::dynamic;
    on.is_joined = first_[slot] < first_[slot + 1];
    Vec3 arm(0);  // the longest anchor vector of a joint
    const auto arm_of = [&](std::uint32_t end) {
      const Link& l = world.links.values()[ends_[end]];
      return world.bodies.slot(l.a) == slot ? l.joint.anchor_a : l.joint.anchor_b;
    };
    for (std::uint32_t k = first_[slot]; k < first_[slot + 1]; ++k)
      if (glm::length(arm_of(k)) > glm::length(arm)) arm = arm_of(k);
    const Vec3 i = b.inertia;
    const Real most = std::max({i.x, i.y, i.z}), size = std::sqrt(most / b.mass);
    const auto alike = [&](Real p, Real q) { return std::abs(p - q) < kAlike * most; };
    const bool has_arm = glm::length(arm) > kAlike * size;
    if (alike(i.x, i.y) && alike(i.y, i.z)) {
      on.axis = has_arm ? glm::normalize(arm) : Vec3(0);
      on.is_asked = on.is_asked && has_arm, on.is_ball = true;
    } else {
      for (int k = 0; k < 3; ++k)
        if (alike(i[(k + 1) % 3], i[(k + 2) % 3])) on.axis = Vec3(0), on.axis[k] = 1;
    }
    for (std::uint32_t k = first_[slot]; k < first_[slot + 1]; ++k)
      if (glm::length(glm::cross(arm_of(k), on.axis)) > kAlike * size) on.axis = Vec3(0);
  }
}

/// The rotation that a body's solver resolves, rad.
Real TurnWatch::range_of(const World& world, std::uint32_t slot) const {
  const Range range = detail::range_of(world, slot);
  return !bodies_[slot].is_joined && range.divides_free_turns ? 1e300 : range.turn;
}

void TurnWatch::end_substep(const World& world, Real h, std::span<const EnergyStore> stores,
                            FindingList& found) {
  const Real least = kImplicitRange.turn / h;
  for (const std::uint32_t slot : partition_of(world).awake) {
    const pantin::Body& b = world.bodies.values()[slot];
    Real& turned = bodies_[slot].turned;
    if (!bodies_[slot].is_asked ||
        glm::dot(b.angular_velocity, b.angular_velocity) < least * least) {
      turned = 0;
      continue;
    }
    const Vec3 axis = b.pose.rotation * bodies_[slot].axis;
    const Real turn =
        h * glm::length(b.angular_velocity - glm::dot(b.angular_velocity, axis) * axis);
    turned = turn > range_of(world, slot) ? turned + turn : 0;
    if (turned > kBriefly && share_of(world, slot) > kLittle)
      found.note(FindingKind::turned_too_far, world.bodies.owners()[slot], turn);
  }
  note_rolling(world, h), check_rolling(world, found);
  for (const EnergyStore& s : stores) {
    if (s.kind == EnergyStore::Kind::coordinate) check_spring(world, h, s, found);
    if (s.kind == EnergyStore::Kind::pin) check_spring_pin(world, h, s, found);
  }
}

/// Notes bodies other than balls that roll, slide or spin on a contact while they rotate too far in
/// a step.
void TurnWatch::note_rolling(const World& world, Real h) {
  const Real least = kLagrangianRange.roll / h;
  for (const Contact& c : contacts_of(world))
    for (const std::uint32_t slot : {c.slot_a, c.slot_b}) {
      const pantin::Body& b = world.bodies.values()[slot];
      const Vec3 spin = b.angular_velocity;
      if (!c.active || glm::dot(spin, spin) < least * least || bodies_[slot].is_ball ||
          b.motion != Motion::dynamic)
        continue;
      const Real turn = h * glm::length(spin);
      if (turn > detail::range_of(world, slot).roll)
        bodies_[slot].rolls = std::max(bodies_[slot].rolls, turn);
    }
}

void TurnWatch::check_rolling(const World& world, FindingList& found) {
  for (const std::uint32_t slot : partition_of(world).awake) {
    Body& b = bodies_[slot];
    b.rolled = b.rolls > 0 ? b.rolled + b.rolls : 0;
    if (b.rolled > kBriefly && share_of(world, slot) > kLittle)
      found.note(FindingKind::turned_too_far, world.bodies.owners()[slot], b.rolls);
    b.rolls = 0;
  }
}

/// The fraction of its island's kinetic energy.
Real TurnWatch::share_of(const World& world, std::uint32_t slot) const {
  const std::vector<std::uint32_t>& islands = partition_of(world).island;
  if (slot >= islands.size()) return 1;
  Real all = 0;
  for (std::uint32_t i = 0; i < bodies_.size() && i < islands.size(); ++i)
    if (islands[i] == islands[slot]) all += kinetic_energy(world.bodies.values()[i]);
  return kinetic_energy(world.bodies.values()[slot]) / all;
}

Real TurnWatch::inertia_beyond(const World& world, const EnergyStore& s, std::uint32_t from,
                               std::uint32_t to) {
  const Link& link = world.links.values()[s.slot];
  const Pose& a = world.bodies[link.a].pose;
  const Vec3 axis = a.rotation * (link.joint.frames.a() * Vec3(1, 0, 0));
  const Vec3 anchor = to_world(a, link.joint.anchor_a);
  std::fill(seen_.begin(), seen_.end(), std::uint8_t{0});
  seen_[from] = seen_[to] = 1;
  stack_.assign(1, to);
  Real sum = 0;
  while (!stack_.empty()) {
    const std::uint32_t slot = stack_.back();
    stack_.pop_back();
    const pantin::Body& b = world.bodies.values()[slot];
    if (b.motion != Motion::dynamic || bodies_[slot].is_geared || bodies_[slot].is_sprung) return 0;
    const Vec3 across = glm::cross(axis, b.pose.position - anchor),
               inside = glm::conjugate(b.pose.rotation) * axis;
    sum += s.along == Coordinate::travel
               ? b.mass
               : b.mass * glm::dot(across, across) + glm::dot(inside, b.inertia * inside);
    for (std::uint32_t k = first_[slot]; k < first_[slot + 1]; ++k) {
      if (ends_[k] == s.slot) continue;
      const Link& next = world.links.values()[ends_[k]];
      const std::uint32_t on_a = world.bodies.slot(next.a), on_b = world.bodies.slot(next.b);
      const std::uint32_t other = on_a == slot ? on_b : on_a;
      if (other == kNoSlot) continue;
      if (seen_[other]) return 0;  // a loop
      seen_[other] = 1, stack_.push_back(other);
    }
  }
  return sum;
}

/// A spring is resolved if its frequency is low enough, or if it hardly oscillates.
void TurnWatch::check_spring(const World& world, Real h, const EnergyStore& s, FindingList& found) {
  const Link& link = world.links.values()[s.slot];
  const JointParameters& own = *link.joint.parameters;
  const Dof& dof = s.along == Coordinate::angle ? own.rotation : own.translation;
  const bool holds = dof.motor.kind == MotorKind::position;
  const Real stiffness = dof.spring.stiffness + (holds ? dof.motor.gain : 0);
  const Real damping = dof.spring.damping + dof.friction.viscous + (holds ? dof.motor.damping : 0);
  if (!(stiffness > 0)) return;
  Real least = kSwing;
  if (s.along == Coordinate::travel) {
    const Vec3 apart = world.bodies[link.a].pose.position - world.bodies[link.b].pose.position;
    const pantin::Body& body = world.bodies.values()[s.body];
    least *= std::max(glm::length(apart), radius_of_gyration(body.inertia, body.mass));
  }
  if (std::abs(s.moved) < least) return;
  const std::uint32_t a = world.bodies.slot(link.a), b = world.bodies.slot(link.b);
  const Real beyond_a = inertia_beyond(world, s, b, a), beyond_b = inertia_beyond(world, s, a, b);
  if (beyond_a == 0 && beyond_b == 0) return;
  const Real inertia = beyond_a == 0   ? beyond_b
                       : beyond_b == 0 ? beyond_a
                                       : beyond_a * beyond_b / (beyond_a + beyond_b);
  if (damping > 2 * kDamped * std::sqrt(stiffness * inertia)) return;
  const Real swing = h * std::sqrt(stiffness / inertia);
  if (swing > detail::range_of(world, s.body).swing)
    found.note(FindingKind::spring_unresolved, world.links.owners()[s.slot], swing);
}

/// Spring pins between bodies that nothing else constrains.
void TurnWatch::check_spring_pin(const World& world, Real h, const EnergyStore& s,
                                 FindingList& found) {
  const Pin& pin = world.pins.values()[s.slot];
  struct End {
    const pantin::Body* body;
    std::uint32_t slot;
    Vec3 anchor, at;
  };
  const auto end_of = [&](Entity e, Vec3 anchor) {
    const std::uint32_t slot = world.bodies.slot(e);
    const pantin::Body* b = slot != kNoSlot ? &world.bodies.values()[slot] : nullptr;
    return End{b, slot, anchor, b ? to_world(b->pose, anchor) : anchor};
  };
  const End ends[] = {end_of(pin.body, pin.anchor), end_of(pin.to, pin.target)};
  const Vec3 gap = ends[1].at - ends[0].at;
  if (gap == Vec3(0)) return;
  Real mobile = 0, size = 0;  // acceleration per unit of force along the spring; size of the
                              // bodies, m
  Vec3 rate(0);
  for (const End& end : ends) {
    if (!end.body) continue;
    rate += (&end == ends ? -1.0 : 1.0) * velocity_at(*end.body, end.at);
    if (end.body->motion != Motion::dynamic) continue;
    if (bodies_[end.slot].is_joined || bodies_[end.slot].is_geared) return;
    const Vec3 inertia = end.body->inertia;
    const Vec3 across =
        glm::cross(end.anchor, glm::conjugate(end.body->pose.rotation) * glm::normalize(gap));
    mobile += 1 / end.body->mass + glm::dot(across, across / inertia);
    size = std::max(size, radius_of_gyration(inertia, end.body->mass));
  }
  if (h * glm::length(rate) < kSwing * size) return;
  if (pin.damping * std::sqrt(mobile) > 2 * kDamped * std::sqrt(pin.stiffness)) return;
  const Real swing = h * std::sqrt(pin.stiffness * mobile);
  if (swing > detail::range_of(world, s.body).swing)
    found.note(FindingKind::spring_unresolved, world.pins.owners()[s.slot], swing);
}

}  // namespace pantin::detail
