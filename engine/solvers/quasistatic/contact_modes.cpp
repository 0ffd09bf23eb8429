#include "engine/solvers/quasistatic/contact_modes.hpp"

#include <algorithm>
#include <cmath>

#include "engine/modes/feasible.hpp"
#include "engine/world/timed_event.hpp"

namespace pantin::detail::quasistatic {
namespace {

constexpr Real kTouching = 1e-6;  // of the outline's extent, as when laminas are placed
constexpr int kStable = 1;        // see modes::index_of

modes::Vec2 flat(Vec3 v) { return {v.x, v.y}; }

const Lamina* find_lamina(const World& world, Entity body) {
  const Store<Lamina>* all = laminas_of(world);
  const Lamina* lamina = all ? all->find(body) : nullptr;
  const bool is_sound = lamina && world.bodies.find(body) && lamina_fault(world, body).empty();
  return is_sound ? lamina : nullptr;
}

void add_tips(const World& world, const Lamina& lamina, Grip& grip) {
  for (const LaminaFinger& f : lamina.fingers) {
    const Body* body = world.bodies.find(f.body);
    if (!body) continue;
    FingerMotion motion{body->pose.position + body->pose.rotation * f.point, body->velocity};
    if (!f.path.empty()) motion = motion_of(f.path, world.time);
    grip.tips.push_back({flat(motion.at), flat(motion.velocity),
                         flat(body->pose.rotation * f.normal), f.flat, f.roll, f.slide});
    grip.bodies.push_back(f.body);
  }
}

/// The load besides its fingers: its weight, and active push events.
modes::Part part_of(const World& world, Entity lamina, const Grip& grip) {
  const Body& b = world.bodies[lamina];
  Vec3 force = b.mass * b.gravity_scale * world.gravity;
  Real torque = 0;
  if (const Store<TimedEvent>* events = events_of(world))
    for (const TimedEvent& event : events->values()) {
      const auto* push = std::get_if<PushEvent>(&event.kind);
      if (!push || push->body != lamina || world.time < push->from || world.time >= push->to)
        continue;
      force += push->force, torque += push->torque.z;
    }
  return {grip.outline, {0, 0}, flat(force), torque};
}

void add_contacts(const modes::Moment& now, const modes::Touches& touches, Grip& grip) {
  for (const modes::Touch t : touches) {
    grip.contacts.push_back(contact_of(now, t));
    grip.fingers.push_back(grip.bodies[t.finger]);
    grip.roll.push_back(now.fingers[t.finger].roll);
    grip.slide.push_back(now.fingers[t.finger].slide);
  }
  grip.load = load_of(now);
}

modes::Placement placement_of(const Body& b) {
  return {flat(b.pose.position), 2 * std::atan2(b.pose.rotation.z, b.pose.rotation.w)};
}

/// A lamina with its fingers, without contacts; false if there is none.
bool take_up(const World& world, Entity lamina, Grip& grip) {
  const Lamina* found = find_lamina(world, lamina);
  if (!found) return false;
  for (const Vec3 corner : found->outline) grip.outline.push_back(flat(corner));
  add_tips(world, *found, grip);
  return !grip.tips.empty();
}

}  // namespace

Grip grip_of(const World& world, Entity lamina) {
  Grip grip;
  if (!take_up(world, lamina, grip)) return grip;
  const modes::Part part = part_of(world, lamina, grip);
  modes::Moment now{part, grip.tips};
  now.place(placement_of(world.bodies[lamina]));
  const modes::Touches touches = touches_of(now, kTouching * modes::extent(grip.outline));
  if (!touches.at_corner && !touches.too_many) add_contacts(now, touches, grip);
  return grip;
}

std::vector<GripMode> modes_of(const Grip& grip) {
  std::vector<GripMode> all;
  const modes::Lamina lamina{grip.contacts, grip.load};
  if (!check(lamina)) return all;
  modes::Prepared prepared;
  prepare(lamina, prepared);
  modes::ModeSet set;
  const modes::Friction mu{grip.roll, grip.slide};
  find_modes(prepared, mu, set);
  for (const modes::FeasibleMode& m : set.modes)
    all.push_back({signed_mode_of(prepared, m, mu), m.index == kStable});
  for (const modes::SignedMode& m : set.indeterminate) all.push_back({m, false});
  return all;
}

bool last_mode(const World& world, Entity lamina, Grip& grip, GripMode& mode) {
  const std::vector<Island>& islands = islands_of(world);
  const auto it = std::ranges::find(islands, lamina, &Island::body);
  if (it == islands.end() || it->phase != Phase::modes || !it->motion.is_known) return false;
  if (!take_up(world, lamina, grip)) return false;
  const modes::Motion& motion = it->motion;
  if (std::ranges::any_of(motion.touches,
                          [&](const modes::Touch& t) { return t.finger >= grip.tips.size(); }))
    return false;
  const modes::Part part = part_of(world, lamina, grip);
  modes::Moment now{part, grip.tips};
  now.place(placement_of(world.bodies[lamina]));
  add_contacts(now, motion.touches, grip);
  mode.mode.signs = motion.signs, mode.mode.twist = motion.twist;
  mode.mode.normal_force = motion.normal_force, mode.mode.tangent_force = motion.tangent_force;
  mode.is_stable = motion.index == kStable;
  return true;
}

}  // namespace pantin::detail::quasistatic
