#include "engine/runtime/events.hpp"

#include <algorithm>
#include <cmath>

#include "engine/joints/kinds.hpp"
#include "engine/runtime/requests.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {
namespace {

using enum TimedEventKind;

/// A hand yields to joints and pins of the scene: it opens none, and gets as near as they let it.
constexpr int kPriority = -1000;
/// Less of a step than this is rounding: a push from one step boundary to another wakes nobody in
/// the step after it.
constexpr Real kSliver = 1e-9;

/// The substep to come.
struct Span {
  World& world;
  Real from, h;

  Real to() const { return from + h; }
  /// Whether a moment belongs to its start: to no boundary it is nearer.
  bool begins(Real moment) const { return moment < from + h / 2; }
};

/// How much of a change that takes `over` has been made, in [0, 1].
Real progress_at(const TimedEvent& e, Real time) {
  if (e.over == 0) return 1;
  return std::clamp((time - e.from) / e.over, Real(0), Real(1));
}

/// The same that starts and ends at rest.
Real eased(Real progress) { return progress * progress * (3 - 2 * progress); }

Dof* motor_of(World& world, Entity joint) {
  Link* link = world.links.find(joint);
  if (!link) return nullptr;
  JointParameters& own = link->joint.parameters.edit();
  const bool turns = info_of(link->joint.kind).is_used(Coordinate::angle, kActuated);
  return turns ? &own.rotation : &own.translation;
}

// ---- What happens at one moment ----

void begin_pull(const Span& span, TimedEvent& e) {
  World& world = span.world;
  const Body* body = world.bodies.find(e.on);
  if (!body || body->motion != Motion::dynamic) {
    e.progress.done = true;
    return;
  }
  Pin pin;
  pin.body = e.on, pin.anchor = e.anchor, pin.priority = kPriority;
  pin.target = e.progress.start = to_world(body->pose, e.anchor);
  pin.kind = e.stiffness > 0 ? PinKind::spring : PinKind::exact;
  pin.stiffness = e.stiffness, pin.damping = e.damping;
  e.progress.pin = world.add_pin(pin);
}

/// A joint that gets a motor, or loses it, is another structure.
void begin_motor(World& world, TimedEvent& e) {
  Dof* dof = motor_of(world, e.on);
  if (!dof) return;
  const bool same = dof->motor.kind == e.motor.kind;
  if (!same) world.mark_dirty();
  e.progress.start.x = same || e.motor.kind == MotorKind::velocity ? dof->motor.target : 0;
  if (dof->motor.kind == MotorKind::none) e.progress.start.x = 0;
  dof->motor = e.motor;
  dof->motor.target = e.progress.start.x;
}

void choose_solver(World& world, Solver solver) {
  world.default_settings.solver = solver;
  for (SolverSettings& s : world.settings.values()) s.solver = solver;
  world.mark_dirty();
}

void begin(const Span& span, TimedEvent& e) {
  World& world = span.world;
  switch (e.kind) {
    case pull:
      return begin_pull(span, e);
    case cut:
      return world.destroy(e.on);
    case motor:
      return begin_motor(world, e);
    case drive:
      if (const JointDrive* d = world.joint_drives.find(e.on))
        e.progress.start = {d->stiffness, d->damping, d->max_torque};
      return;
    case winch:
      if (const Cable* c = world.cables.find(e.on)) e.progress.start.x = c->joint.length;
      return;
    case gravity:
      e.progress.start = world.gravity;
      return;
    case solver:
      return choose_solver(world, e.solver);
    case push:
    case impulse:
    case wind:
      return;
  }
}

/// Begins what is due, the earliest first, of equals that which was added first.
void begin_due(const Span& span, std::span<TimedEvent> events) {
  for (;;) {
    TimedEvent* next = nullptr;
    for (TimedEvent& e : events)
      if (!e.progress.done && e.progress.fired == 0 && !lasts(e.kind) && e.kind != impulse &&
          span.begins(e.from) && (!next || e.from < next->from))
        next = &e;
    if (!next) return;
    next->progress.fired = 1;
    begin(span, *next);
    next->progress.done = next->progress.done || next->kind == cut || next->kind == solver;
  }
}

// ---- What goes on over a while ----

void go_on_pulling(const Span& span, TimedEvent& e) {
  World& world = span.world;
  Pin* pin = world.pins.find(e.progress.pin);
  e.progress.done = !pin || span.begins(e.to);
  if (e.progress.done) {
    if (pin) world.destroy(e.progress.pin);
    return;
  }
  const Real part = eased(progress_at(e, span.to()));
  pin->target = e.progress.start + part * (e.target - e.progress.start);
}

/// Wakes what a joint or cable ties.
void rouse_ends(World& world, Entity tie) {
  if (const Link* l = world.links.find(tie)) rouse(world, l->a), rouse(world, l->b);
  if (const Cable* c = world.cables.find(tie)) rouse(world, c->a), rouse(world, c->b);
}

void change_drive(World& world, const TimedEvent& e, Real part) {
  JointDrive* d = world.joint_drives.find(e.on);
  if (!d) return;
  const Vec3& start = e.progress.start;
  d->stiffness = std::lerp(start.x, e.stiffness, part);
  d->damping = std::lerp(start.y, e.damping, part);
  d->max_torque = std::lerp(start.z, e.max_torque, part);
}

/// What is held at the end of the substep goes by its end; a force or a speed by its middle.
void change(const Span& span, TimedEvent& e) {
  World& world = span.world;
  rouse_ends(world, e.on);
  const Real at_end = progress_at(e, span.to());
  const Real in_middle = at_end == 1 && span.from >= e.from + e.over
                             ? Real(1)
                             : progress_at(e, span.from + span.h / 2);
  if (e.kind == motor) {
    if (Dof* dof = motor_of(world, e.on))
      dof->motor.target = std::lerp(e.progress.start.x, e.motor.target,
                                    e.motor.kind == MotorKind::position ? at_end : in_middle);
  } else if (e.kind == drive) {
    change_drive(world, e, in_middle);
  } else if (e.kind == winch) {
    if (Cable* c = world.cables.find(e.on))
      c->joint.length = std::lerp(e.progress.start.x, e.length, eased(at_end));
  } else {
    world.gravity = e.progress.start + in_middle * (e.gravity - e.progress.start);
    if (in_middle == 1) world.gravity = e.gravity;
  }
  e.progress.done = in_middle == 1;
}

// ---- Forces ----

bool can_be_pushed(const World& world, Entity body) {
  const Body* b = world.bodies.find(body);
  return b && b->motion == Motion::dynamic;
}

void push_on(const Span& span, const TimedEvent& e, Vec3 force, Vec3 torque) {
  World& world = span.world;
  if (!can_be_pushed(world, e.on)) return;
  world.push(e.on, force, to_world(world.bodies[e.on].pose, e.anchor));
  world.forces[e.on].torque += torque;
}

/// An impulse is a force that lasts a substep.
void apply_impulse(const Span& span, TimedEvent& e) {
  if (!span.begins(e.from)) return;
  Real due = 1;
  if (e.every > 0) due += std::floor((span.from + span.h / 2 - e.from) / e.every);
  const Real left = due - static_cast<Real>(e.progress.fired);
  e.progress.done = e.every == 0;
  if (!(left >= 1) || !(due < 1e15)) return;
  e.progress.fired = static_cast<std::uint64_t>(due);
  push_on(span, e, left / span.h * e.impulse, left / span.h * e.angular_impulse);
}

/// The part of the substep in which a push or wind acts.
Real active_part(const Span& span, const TimedEvent& e) {
  const Real part = active_time(e, span.from, span.to()) / span.h;
  return part < kSliver ? 0 : std::min(part, Real(1));
}

/// The air's mean velocity while the wind blows within the substep.
Vec3 air_of(const Span& span, const TimedEvent& e) {
  Vec3 air = e.velocity;
  const bool once = e.every == 0;
  const Real from = once ? std::max(span.from, e.from) : span.from,
             to = once ? std::min(span.to(), e.to) : span.to();
  for (int i = 0; i < 3; ++i)
    if (e.gusts[i] != 0)
      air[i] +=
          e.gusts[i] * mean_of({e.seed, static_cast<std::uint64_t>(i), e.gust_time}, from, to);
  return air;
}

void blow(const Span& span, const TimedEvent& e) {
  World& world = span.world;
  const Real part = active_part(span, e);
  if (part == 0) return;
  const Vec3 air = air_of(span, e);
  const auto on_body = [&](Entity owner) {
    if (!can_be_pushed(world, owner)) return;
    const Body& b = world.bodies[owner];
    // A body takes the own drag off its velocity by itself. A rate of the wind's own may not take
    // it beyond the air's in a long step.
    const Vec3 acceleration =
        e.drag < 0 ? b.drag * air
                   : -std::expm1(-e.drag * part * span.h) / (part * span.h) * (air - b.velocity);
    world.push(owner, part * b.mass * acceleration, b.pose.position);
  };
  if (e.bodies.empty())
    for (const Entity owner : world.bodies.owners()) on_body(owner);
  for (const Entity owner : e.bodies) on_body(owner);
}

void go_on(const Span& span, TimedEvent& e) {
  if (e.kind == impulse) return apply_impulse(span, e);
  if (lasts(e.kind)) {
    e.progress.done = e.every == 0 && span.from >= e.to;
    if (e.progress.done) return;
    if (e.kind == wind) return blow(span, e);
    const Real part = active_part(span, e);
    if (part > 0) push_on(span, e, part * e.force, part * e.torque);
    return;
  }
  if (e.progress.fired == 0) return;
  if (e.kind == pull)
    go_on_pulling(span, e);
  else
    change(span, e);
}

}  // namespace

void apply_events(World& world, Real h) {
  if (!events_of(std::as_const(world)) || !std::isfinite(world.time)) return;
  const std::span<TimedEvent> events = events_of(world).values();
  const Span span{world, world.time, h};
  begin_due(span, events);
  for (TimedEvent& e : events)
    if (!e.progress.done) go_on(span, e);
}

}  // namespace pantin::detail
