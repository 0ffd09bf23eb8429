#include "engine/runtime/energy_account.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/contact/contact.hpp"
#include "engine/contact/detect.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail {
namespace {

/// Tolerance of gains and losses, as a fraction of the greatest kinetic energy plus the work so
/// far.
constexpr Real kPart = 0.05;
/// Extra tolerance of losses, as a fraction of the energy that contacts may have dissipated.
constexpr Real kRough = 0.1;
/// Energies that correspond to a lift by less than this fraction of a body's size are ignored.
constexpr Real kLift = 0.01;
/// rad/s: angular momenta below about this speed of a body are ignored.
constexpr Real kSlowTurn = 0.01;
/// Substeps after a contact, a start or a change by the user in which losses are allowed.
constexpr int kTouched = 3;
/// Nothing is thrown faster than kThrown times the speed of the pressing body within kThrowing (s).
constexpr Real kThrowing = 0.25, kThrown = 4;
/// m: a holder that moves less in a substep counts as fixed.
constexpr Real kStill = 1e-6;

bool is_dynamic(const Body& b) { return b.motion == Motion::dynamic; }

Real size_of(const World& world, Entity e, const Body& b) {
  const Shapes* shapes = world.shapes.find(e);
  return std::max(shapes ? contact::extent_of(*shapes) : 0, radius_of_gyration(b.inertia, b.mass));
}

}  // namespace

void EnergyAccount::hold(std::uint32_t group, std::uint32_t by) {
  std::uint32_t& held_by = groups_[group].held_by;
  if (by == kNobody || by == held_by) return;
  held_by = held_by == kNobody ? by : kSeveral;
}

/// Joins the dynamic bodies of a joint, cable or pin into one group; the other bodies hold that
/// group.
void EnergyAccount::attach(const World& world, std::initializer_list<Entity> bodies) {
  std::uint32_t first = kNoSlot;
  for (const Entity e : bodies) {
    const std::uint32_t slot = world.bodies.slot(e);
    if (slot == kNoSlot || !is_dynamic(world.bodies.values()[slot])) continue;
    if (first != kNoSlot) join(first, slot);
    first = slot;
  }
  if (first == kNoSlot) return;
  for (const Entity e : bodies) {
    const std::uint32_t slot = world.bodies.slot(e);
    if (slot == kNoSlot || is_dynamic(world.bodies.values()[slot])) continue;
    hold(sets_.root(first), slot);
    holds_.push_back({first, slot});
  }
}

void EnergyAccount::join(std::uint32_t a, std::uint32_t b) {
  a = sets_.root(a), b = sets_.root(b);
  if (a == b) return;
  if (b < a) std::swap(a, b);
  sets_.join(a, b);
  Group &to = groups_[a], &from = groups_[b];
  hold(a, from.held_by);
  to.is_asked = to.is_asked && from.is_asked;
  to.is_lossy = to.is_lossy || from.is_lossy;
  to.touched = std::max(to.touched, from.touched), to.jerked = std::max(to.jerked, from.jerked);
  to.missing += from.missing, to.spent += from.spent, to.spin += from.spin,
      to.slack_spin += from.slack_spin;
  to.drift += from.drift;
  to.slack += from.slack, to.balance += from.balance, to.least += from.least;
  to.greatest += from.greatest, to.exchanged += from.exchanged;
  to.impulse_before += from.impulse_before;
  to.change += from.change, to.kinetic += from.kinetic;
  to.momentum += from.momentum, to.angular += from.angular;
  if (to.fastest == kNoSlot) to.fastest = from.fastest;
  to.pressed_at = std::max(to.pressed_at, from.pressed_at);
  to.worked += from.worked, to.calm += from.calm;
  to.rise += from.rise, to.level += from.level, to.lowest += from.lowest;
  from.has_gained = from.has_lost = from.has_turned = from.is_flung = false;
}

void EnergyAccount::compile(const World& world) {
  const std::size_t count = world.bodies.size();
  sets_.reset(count), moving_.clear(), moving_in_.assign(count, 0);
  substep_ = 0, rest_version_ = 0;
  bodies_.assign(count, {}), groups_.assign(count, {});
  const Real g = glm::length(world.gravity);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Body& b = world.bodies.values()[i];
    if (!is_dynamic(b)) continue;
    const Real lift = kLift * size_of(world, world.bodies.owners()[i], b);
    groups_[i].slack = b.mass * lift * (g * std::abs(b.gravity_scale) + lift);
    groups_[i].slack_spin = kSlowTurn * b.mass * (lift / kLift) * (lift / kLift);
    groups_[i].touched = groups_[i].jerked = kTouched;  // joints may close with a jerk
  }
  holds_.clear();
  for (const Link& l : world.links.values()) attach(world, {l.a, l.b});
  for (const Cable& c : world.cables.values()) {
    attach(world, {c.a, c.b});
    for (const CableGuide& guide : c.guides) attach(world, {c.a, c.b, guide.body});
  }
  for (const SurfaceContact& c : world.surface_contacts.values()) attach(world, {c.a, c.b});
  for (const Belt& belt : world.belts.values())
    for (const BeltPulley& p : belt.pulleys) attach(world, {belt.pulleys.front().body, p.body});
  for (const Gear& gear : world.gears.values()) {
    const Link *first = world.links.find(gear.first), *second = world.links.find(gear.second);
    if (first && second) attach(world, {first->a, first->b, second->a, second->b});
  }
  for (std::uint32_t i = 0; i < world.pins.size(); ++i) {
    const Pin& p = world.pins.values()[i];
    attach(world, {p.body, p.to});
    const std::uint32_t body = world.bodies.slot(p.body);
    if (p.kind == PinKind::exact && !p.to && body != kNoSlot &&
        is_dynamic(world.bodies.values()[body]))
      hold(sets_.root(body), kPlaces + i), holds_.push_back({body, kPlaces + i});
  }
  find_losses(world);
  std::size_t roots = 0;  // the number of groups only decreases
  for (std::uint32_t i = 0; i < count; ++i) roots += sets_.root(i) == i;
  moving_.reserve(roots);
  // A length that was changed along with the structure is seen by leave_out().
  const std::vector<CableState> before = std::exchange(cables_, {});
  cables_.resize(world.cables.size());
  for (std::uint32_t i = 0; i < cables_.size(); ++i) cables_[i] = state_of(world, i);
  for (const CableState& was : before)
    if (const std::uint32_t i = world.cables.slot(was.cable); i != kNoSlot)
      cables_[i].length = was.length;
  list_stores(world, stores_);
  built_for_ = world.structure(), is_new_ = true;
}

/// Marks the groups whose joints and ties can dissipate energy.
void EnergyAccount::find_losses(const World& world) {
  const auto lose = [&](std::initializer_list<Entity> bodies) {
    for (const Entity e : bodies)
      if (const std::uint32_t slot = world.bodies.slot(e); slot != kNoSlot)
        groups_[sets_.root(slot)].is_lossy = true;
  };
  const auto takes = [](const Dof& d) {
    return d.spring.damping != 0 || d.friction.viscous != 0 || d.friction.dry != 0 ||
           d.motor.kind != MotorKind::none;
  };
  for (std::uint32_t i = 0; i < world.links.size(); ++i) {
    const Link& l = world.links.values()[i];
    const JointParameters& own = *l.joint.parameters;
    if (l.joint.limits.any() || own.travel.on || own.grip > 0 || own.friction > 0 ||
        takes(own.rotation) || takes(own.translation) ||
        world.joint_drives.find(world.links.owners()[i]))
      lose({l.a, l.b});
  }
  for (const Cable& c : world.cables.values())
    if (c.joint.compliance > 0 || !c.guides.empty()) lose({c.a, c.b});
  for (const Pin& p : world.pins.values()) lose({p.body, p.to});
  for (const SurfaceContact& c : world.surface_contacts.values())
    if (c.lifts || c.friction >= 0) lose({c.a, c.b});
  for (const Belt& belt : world.belts.values())
    if (belt.friction > 0)
      for (const BeltPulley& p : belt.pulleys) lose({p.body});
}

bool EnergyAccount::is_asked(std::uint32_t slot) const {
  DisjointSets sets = sets_;
  return slot < groups_.size() && groups_[sets.root(slot)].is_asked;
}

void EnergyAccount::begin_substep(const World& world) {
  if (built_for_ != world.structure()) compile(world);
  for (EnergyStore& s : stores_) begin_store(world, s);
  begun_ = true;
}

void EnergyAccount::note_start(const World& world, std::uint32_t slot, Real h) {
  const Body& b = world.bodies.values()[slot];
  Start& s = bodies_[slot];
  s.velocity = b.velocity, s.angular_velocity = b.angular_velocity;
  // Kinematic bodies have moved already; the former pose follows from the velocity.
  s.pose = is_dynamic(b) || b.teleport ? b.pose : contact::pose_before(b, h);
  if (!is_dynamic(b)) return;
  if (Group& g = groups_[sets_.root(slot)]; b.restart) g.touched = g.jerked = kTouched;
  const Energies e = energies_of(world, b);
  s.energy = e.all, s.kinetic = e.kinetic, s.spin = e.spin;
  s.force = s.torque = Vec3(0);
}

/// Bodies that sleep keep what was noted when they fell asleep.
void EnergyAccount::note_start(const World& world, Real h) {
  begun_ = begun_ && built_for_ == world.structure();
  if (!begun_) return;
  const Partition& partition = partition_of(world);
  for (std::uint32_t i = 0; is_new_ && i < bodies_.size(); ++i)
    if (owner_of(partition, i).solver == kQuasistatic) groups_[sets_.root(i)].is_asked = false;
  if (std::exchange(rest_version_, partition.rest_version) != partition.rest_version) {
    for (std::uint32_t i = 0; i < bodies_.size(); ++i) note_start(world, i, h);
  } else {
    for (const auto* slots : {&partition.kinematic, &partition.awake})
      for (const std::uint32_t slot : *slots) note_start(world, slot, h);
  }
  for (std::size_t i = 0; i < world.forces.size(); ++i) {
    const std::uint32_t slot = world.bodies.slot(world.forces.owners()[i]);
    const Force& f = world.forces.values()[i];
    if (slot != kNoSlot && is_finite(f.force) && is_finite(f.torque))
      bodies_[slot].force = f.force, bodies_[slot].torque = f.torque;
  }
}

void EnergyAccount::list_moving(const World& world) {
  moving_.clear(), ++substep_;
  for (const std::uint32_t slot : partition_of(world).awake) {
    const std::uint32_t root = sets_.root(slot);
    if (!is_moving(root)) moving_.push_back(root), moving_in_[root] = substep_;
  }
  std::sort(moving_.begin(), moving_.end());
}

void EnergyAccount::end_substep(const World& world, Real h) {
  if (!begun_ || built_for_ != world.structure()) return;
  begun_ = false;
  for (const Contact& c : contacts_of(world))
    if (c.active && is_dynamic(world.bodies.values()[c.slot_a]) &&
        is_dynamic(world.bodies.values()[c.slot_b]))
      join(c.slot_a, c.slot_b);
  list_moving(world);
  for (const std::uint32_t root : moving_) {
    Group& g = groups_[root];
    g.change = g.paid = g.kinetic = g.kinetic_before = g.worked = g.rise = 0, g.is_pressed = false,
    g.momentum = g.angular = Vec3(0), g.before = g.now = {};
  }
  add_bodies(world, h);
  add_contacts(world, h);
  add_stores(world, h);
  leave_out(world);
  add_cable_blows(world, h);
  add_leads(world, h);
  close(world, h);
  is_new_ = false;
}

/// An upper bound on the energy that a contact dissipated: its force times the relative velocity,
/// at the start or at the end of the substep. Sliding dissipates by friction, an impact half of its
/// initial value.
Real EnergyAccount::taken_by(const World& world, const Contact& c, Real h) const {
  Vec3 slip[2] = {c.surface_velocity, c.surface_velocity}, spin[2] = {};
  for (const std::uint32_t slot : {c.slot_a, c.slot_b}) {
    const Body& b = world.bodies.values()[slot];
    const Start& from = bodies_[slot];
    const Vec3 on = slot == c.slot_a ? c.point_a : c.point_b;
    const Real sign = slot == c.slot_a ? 1 : -1;
    const bool moves = is_dynamic(b);
    const Vec3 w = moves ? from.angular_velocity : b.angular_velocity,
               v = moves ? from.velocity : b.velocity;
    slip[0] += sign * (v + glm::cross(w, from.pose.rotation * on)), spin[0] += sign * w;
    slip[1] += sign * velocity_at(b, to_world(b.pose, on)), spin[1] += sign * b.angular_velocity;
  }
  Real most = 0;
  for (const int k : {0, 1})
    most = std::max(most, -glm::dot(c.force, slip[k]) - glm::dot(c.torque, spin[k]));
  return h * most;
}

/// Whether the body is at rest now and did not move in the substep.
bool EnergyAccount::stands(const Body& b, const Start& from) {
  const Vec3 none(0);
  return b.velocity == none && b.angular_velocity == none && from.velocity == none &&
         from.angular_velocity == none && b.pose.position == from.pose.position &&
         b.pose.rotation == from.pose.rotation;
}

/// Conveyor surfaces and led bodies do work. Overlap counts as stored elastic energy, which the
/// normal force releases.
void EnergyAccount::add_contacts(const World& world, Real h) {
  for (const Contact& c : contacts_of(world)) {
    if (!c.active) continue;
    const Body &a = world.bodies.values()[c.slot_a], &b = world.bodies.values()[c.slot_b];
    if (!is_dynamic(a) || !is_moving(sets_.root(c.slot_a))) continue;
    const Start &from_a = bodies_[c.slot_a], &from_b = bodies_[c.slot_b];
    Group& g = groups_[sets_.root(c.slot_a)];
    g.touched = kTouched;
    if (!is_dynamic(b)) {
      g.momentum -= h * c.force;
      g.angular -= h * (glm::cross(to_world(a.pose, c.point_a), c.force) + c.torque);
    }
    // Most contacts are between bodies that sleep and do no work.
    if (c.surface_velocity == Vec3(0) && stands(a, from_a) && stands(b, from_b)) continue;
    Real work = -h * glm::dot(c.force, c.surface_velocity);
    const Vec3 way_a = to_world(a.pose, c.point_a) - to_world(from_a.pose, c.point_a),
               way_b = to_world(b.pose, c.point_b) - to_world(from_b.pose, c.point_b);
    if (!is_dynamic(b)) {
      const Real speed = glm::length(way_b) / h + glm::length(c.surface_velocity);
      g.is_pressed = g.is_pressed || speed > 0, g.pressed_at = std::max(g.pressed_at, speed);
      work += glm::dot(c.force, way_b) + h * glm::dot(c.torque, b.angular_velocity);
    }
    g.change -= work, g.exchanged += std::abs(work);
    g.paid += taken_by(world, c, h);
    if (c.gap >= 0) continue;
    const Real deep = std::max(-c.gap, c.depth);
    const Real given =
        glm::dot(c.force, c.normal) * std::clamp(glm::dot(c.normal, way_a - way_b), -deep, deep);
    g.change -= given, g.paid += given;
  }
}

void EnergyAccount::add_stores(const World& world, Real h) {
  for (EnergyStore& s : stores_) {
    const StoreChange change = end_store(world, s, h);
    Group& g = groups_[sets_.root(s.body)];
    g.rise += change.stored, g.change -= change.worked, g.exchanged += std::abs(change.worked);
    g.worked += std::abs(change.stored) + std::abs(change.worked);
  }
}

/// The poses of a holder at the start of the substep and now: a body, or the point that a pin
/// holds.
EnergyAccount::Way EnergyAccount::way_of(const World& world, std::uint32_t holder) const {
  Way way;
  if (holder >= kPlaces) {  // the point itself, since the target may not be reached yet
    const Pin& pin = world.pins.values()[holder - kPlaces];
    const std::uint32_t slot = world.bodies.slot(pin.body);
    way.from.position = to_world(bodies_[slot].pose, pin.anchor);
    way.to.position = to_world(world.bodies.values()[slot].pose, pin.anchor);
    return way;
  }
  const Body& b = world.bodies.values()[holder];
  return {bodies_[holder].pose, b.pose, b.velocity - bodies_[holder].velocity};
}

/// Excludes groups with several holders one of which moves, and groups with a winch or an exact
/// drive.
void EnergyAccount::leave_out(const World& world) {
  const auto leave = [&](Entity e) {
    if (const std::uint32_t slot = world.bodies.slot(e); slot != kNoSlot)
      groups_[sets_.root(slot)].is_asked = false;
  };
  for (std::size_t i = 0; i < world.joint_drives.size(); ++i) {
    const Link* link = world.links.find(world.joint_drives.owners()[i]);
    if (link && world.joint_drives.values()[i].exact) leave(link->a), leave(link->b);
  }
  for (const Hold& hold : holds_) {
    Group& g = groups_[sets_.root(hold.body)];
    if (g.held_by != kSeveral || !g.is_asked) continue;
    const Way way = way_of(world, hold.by);
    const Vec3 moved = way.to.position - way.from.position;
    g.is_asked = glm::dot(moved, moved) < kStill * kStill && way.from.rotation == way.to.rotation;
  }
  const auto cables = world.cables.values();
  for (std::size_t i = 0; i < cables.size(); ++i) {
    if (cables[i].joint.length == cables_[i].length || cables[i].joint.compliance > 0) continue;
    leave(cables[i].a), leave(cables[i].b);
    for (const CableGuide& guide : cables[i].guides) leave(guide.body);
  }
}

EnergyAccount::CableState EnergyAccount::state_of(const World& world, std::uint32_t cable) {
  const Cable& c = world.cables.values()[cable];
  const Entity own = world.cables.owners()[cable];
  const Body *a = world.bodies.find(c.a), *b = world.bodies.find(c.b);
  if (!a || !b || c.joint.compliance > 0 || !c.guides.empty()) return {own, c.joint.length};
  const Vec3 on_a = to_world(a->pose, c.joint.anchor_a), on_b = to_world(b->pose, c.joint.anchor_b);
  const Real span = glm::length(on_b - on_a);
  const Vec3 along = span > 0 ? (on_b - on_a) / span : Vec3(0);
  return {own, c.joint.length, glm::dot(along, velocity_at(*b, on_b) - velocity_at(*a, on_a))};
}

/// A cable that becomes taut dissipates half of its impulse times the separation speed that ends,
/// whatever else constrains its ends.
void EnergyAccount::add_cable_blows(const World& world, Real h) {
  for (std::uint32_t i = 0; i < cables_.size(); ++i) {
    const Cable& c = world.cables.values()[i];
    const CableState before = std::exchange(cables_[i], state_of(world, i));
    const Real ended = std::max({Real(0), before.rate, cables_[i].rate});
    const std::uint32_t a = world.bodies.slot(c.a), b = world.bodies.slot(c.b);
    for (const std::uint32_t slot : {a, b})
      if (slot != kNoSlot && is_dynamic(world.bodies.values()[slot])) {
        groups_[sets_.root(slot)].paid += h * c.tension * ended;
        break;
      }
  }
}

/// The work of led bodies, and of pins with moving targets, on the groups that they hold.
void EnergyAccount::add_leads(const World& world, Real h) {
  for (const std::uint32_t root : moving_) {
    Group& g = groups_[root];
    if (g.held_by == kNobody || g.held_by == kSeveral) continue;
    const auto& [from, to, faster] = way_of(world, g.held_by);
    const Vec3 middle = 0.5 * (from.position + to.position);
    const Vec3 torque = g.angular - glm::cross(middle, g.momentum);
    const Real work = glm::dot(g.momentum, to.position - from.position) / h +
                      glm::dot(torque, angular_velocity_between(from.rotation, to.rotation, h));
    // An impulse may occur at any moment of the substep, while the led body changes its velocity.
    const Real unknown = 0.5 * std::abs(glm::dot(g.momentum - g.impulse_before, faster));
    g.change -= work + unknown, g.exchanged += std::abs(work);
    g.impulse_before = g.momentum;
  }
}

void EnergyAccount::close(const World& world, Real h) {
  for (const std::uint32_t root : moving_) {
    Group& g = groups_[root];
    g.change += g.rise;
    if (!std::isfinite(g.change)) continue;
    g.level += g.rise, g.lowest = std::min(g.lowest, g.level);
    close_flight(world, g, h);
    g.greatest = std::max({g.greatest, g.kinetic, g.kinetic_before});
    if (!g.is_asked) continue;
    // In the first step initial gaps may close, which can lift bodies; only kinetic energy counts.
    g.balance += is_new_ ? std::min(g.change, g.kinetic - g.kinetic_before) : g.change;
    g.least = std::min(g.least, g.balance);
    const Real may = g.slack + kPart * (g.greatest + g.exchanged);
    // Part of an earlier loss may be stored in a form that is not accounted for.
    const bool thrown = g.balance - g.least > may && g.kinetic > (g.balance - g.least) / 2;
    g.has_gained = (g.balance > may || thrown) && g.gain() > may;
    close_losses(g, h);
    if ((g.has_gained || g.has_lost || g.has_turned || g.is_flung) && g.fastest == kNoSlot)
      find_fastest(world, root);
  }
}

/// Whether a group under led bodies is much faster than these could have thrown it.
void EnergyAccount::close_flight(const World& world, Group& g, Real h) const {
  if (is_new_) g.calm = g.kinetic_before;
  const Real fall = kThrowing * glm::length(world.gravity);
  const Real usual =
      std::sqrt(g.calm) + (kThrown * g.pressed_at + fall) * std::sqrt(g.now.mass / 2);
  g.is_flung = g.is_pressed && g.kinetic > 2 * usual * usual + g.slack;
  const Real passed = std::min(Real(1), h / kThrowing);
  g.calm = std::min(g.kinetic, g.calm + passed * (g.kinetic - g.calm) + g.worked);
  g.pressed_at *= 1 - 0.5 * passed;
}

/// Updates the losses of groups without dissipation, and the angular momentum of free groups.
void EnergyAccount::close_losses(Group& g, Real h) {
  const bool is_led = g.held_by != kNobody && g.exchanged > 0;
  g.spent += g.paid;
  const bool is_lossy = g.is_lossy || g.jerked > 0 || is_led;
  g.missing = is_lossy ? 0 : std::max(Real(0), g.missing - g.change - g.paid);
  g.has_lost = g.missing > g.slack + kPart * (g.greatest + g.exchanged) + kRough * g.spent;
  const auto about_centre = [](const Moments& m, Vec3 angular, Vec3 momentum) {
    return angular - glm::cross(m.first / m.mass, momentum);
  };
  const Vec3 angular = about_centre(g.now, g.now.angular, g.now.momentum);
  const Vec3 change = angular - about_centre(g.before, g.before.angular, g.before.momentum);
  const Vec3 centre = 0.5 * (g.before.first + g.now.first) / g.now.mass;  // mean over the substep
  const Vec3 twist = g.now.torque - glm::cross(centre, g.now.force);
  g.spin = std::max({g.spin, g.now.spins, glm::length(angular)});
  const bool is_free = g.held_by == kNobody && g.touched == 0 && !g.is_lossy && !g.is_slowed;
  g.drift = is_free ? g.drift + change - h * twist : Vec3(0);
  g.has_turned = glm::length(g.drift) > g.slack_spin + kPart * g.spin;
  g.touched = std::max(0, g.touched - 1), g.jerked = std::max(0, g.jerked - 1);
}

void EnergyAccount::find_fastest(const World& world, std::uint32_t group) {
  Real most = -1;
  for (std::uint32_t k = group; k < bodies_.size(); ++k) {
    const Body& b = world.bodies.values()[k];
    if (!is_dynamic(b) || sets_.root(k) != group) continue;
    const Real kinetic = energies_of(world, b).kinetic;
    if (kinetic > most) most = kinetic, groups_[group].fastest = k;
  }
}

}  // namespace pantin::detail
