// Checks and adds timed events.
#include <pantin/events.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/pantin/detail/findings.hpp"
#include "engine/world/solver_list.hpp"

namespace pantin {

using namespace detail;

namespace {

std::string called(const World& world, Entity e) {
  return e ? "'" + world.name_of(e) + "'" : "no entity";
}

void check_body(Findings& findings, Entity e) {
  findings.body("body", e);
  if (findings.ok() && findings.world().bodies[e].motion != Motion::dynamic)
    findings.add("body", "a fixed or kinematic body", "a dynamic one");
}

void check_tie(Findings& findings, Entity e) {
  const World& world = findings.world();
  if (!world.links.find(e) && !world.cables.find(e) && !world.pins.find(e) && !world.gears.find(e))
    findings.add("tie", called(world, e), "a joint, a cable, a pin or a gear");
}

/// The member's name determines the type of the event's target.
template <class E>
void check_target(Findings& findings, const E& event) {
  const World& world = findings.world();
  if constexpr (requires { event.body; }) check_body(findings, event.body);
  if constexpr (requires { event.bodies; })
    for (const Entity e : event.bodies) findings.body("bodies", e);
  if constexpr (requires { event.joint; })
    if (!world.links.find(event.joint))
      findings.add("joint", called(world, event.joint), "a joint");
  if constexpr (requires { event.cable; })
    if (!world.cables.find(event.cable))
      findings.add("cable", called(world, event.cable), "a cable");
  if constexpr (requires { event.tie; }) check_tie(findings, event.tie);
}

/// Further checks of a kind.
void check_more(Findings&, const auto&) {}

void check_more(Findings& findings, const PullEvent& event) {
  if (event.stiffness > 0) findings.known({{Feature::spring_pin}}, {event.body});
}

void check_more(Findings& findings, const MotorEvent& event) {
  const Link& link = findings.world().links[event.joint];
  const JointKindInfo& kind = info_of(link.joint.kind);
  if (!kind.is_used(Coordinate::angle, kActuated) && !kind.is_used(Coordinate::travel, kActuated))
    return findings.add("joint", std::string("a joint of kind ") + kind.name.data(),
                        "one with one rotational or translational coordinate");
  if (event.motor.kind != MotorKind::none) findings.known({{Feature::motor}}, {link.a, link.b});
}

void check_more(Findings& findings, const DriveEvent& event) {
  const World& world = findings.world();
  const JointDrive* drive = world.joint_drives.find(event.joint);
  if (!drive) return findings.add("joint", called(world, event.joint), "a joint with a drive");
  if (!event.motion) return;
  if (!drive->exact)
    findings.add("motion", "one for a drive that is a spring", "an exact drive");
  else if (event.motion->travels != drive->motion.travels)
    findings.add("motion.travels", "another coordinate than that of the drive", "the same");
}

}  // namespace

Result<Entity> add_to(World& world, const TimedEvent& event) {
  Findings findings(world, "TimedEvent", std::string(name_of(event)));
  if (const auto fault = fault_of(event))
    findings.add(fault->member, fault->found, fault->expected);
  std::visit(
      [&](const auto& kind) {
        check_target(findings, kind);
        if (findings.ok()) check_more(findings, kind);
      },
      event.kind);
  if (!findings.ok()) return findings.take();
  return add_event(world, {event.kind});
}

}  // namespace pantin
