// Timed events: checked, and added.
#include <pantin/events.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/pantin/detail/findings.hpp"

namespace pantin {

using namespace detail;

namespace {

std::string called(const World& world, Entity e) {
  return e ? "'" + world.name_of(e) + "'" : "no entity";
}

void check_body(Findings& findings, const char* member, Entity e) {
  findings.body(member, e);
  if (findings.ok() && findings.world().bodies[e].motion != Motion::dynamic)
    findings.add(member, "a body that is fixed or kinematic", "a dynamic one");
}

void check_motor(Findings& findings, const TimedEvent& event) {
  const World& world = findings.world();
  const Link* link = world.links.find(event.on);
  if (!link) return findings.add("on", called(world, event.on), "a joint");
  const JointKindInfo& kind = info_of(link->joint.kind);
  if (!kind.is_used(Coordinate::angle, kActuated) && !kind.is_used(Coordinate::travel, kActuated))
    return findings.add("on", std::string("a joint of kind ") + kind.name.data(),
                        "one that turns or slides along one coordinate");
  if (event.motor.kind != MotorKind::none) findings.known({{Feature::motor}}, {link->a, link->b});
}

void check_what(Findings& findings, const TimedEvent& event) {
  using enum TimedEventKind;
  const World& world = findings.world();
  const Entity on = event.on;
  switch (event.kind) {
    case push:
    case impulse:
      return check_body(findings, "on", on);
    case pull:
      check_body(findings, "on", on);
      if (findings.ok() && event.stiffness > 0) findings.known({{Feature::spring_pin}}, {on});
      return;
    case wind:
      for (const Entity e : event.bodies) findings.body("bodies", e);
      return;
    case cut:
      if (!world.links.find(on) && !world.cables.find(on) && !world.pins.find(on) &&
          !world.gears.find(on))
        findings.add("on", called(world, on), "a joint, a cable, a pin or a gear");
      return;
    case motor:
      return check_motor(findings, event);
    case drive:
      if (!world.joint_drives.find(on))
        findings.add("on", called(world, on), "a joint with a drive");
      return;
    case winch:
      if (!world.cables.find(on)) findings.add("on", called(world, on), "a cable");
      return;
    case gravity:
    case solver:
      return;
  }
}

}  // namespace

Result<Entity> add_to(World& world, const TimedEvent& event) {
  Findings findings(world, "TimedEvent",
                    std::string(kTimedEventNames[static_cast<std::size_t>(event.kind)]));
  if (const TimedEventFault* fault = fault_of(event))
    findings.add(fault->member, fault->found, fault->expected);
  check_what(findings, event);
  if (!findings.ok()) return findings.take();
  TimedEvent fresh = event;
  fresh.progress = {};
  return add_event(world, fresh);
}

}  // namespace pantin
