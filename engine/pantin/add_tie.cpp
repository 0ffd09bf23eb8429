// Connections of two points or two joints: rods, springs, cables, pins, gears.
#include <pantin/joints.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/pantin/detail/findings.hpp"
#include "engine/world/cable_route.hpp"
#include "engine/world/solver_list.hpp"
#include "engine/world/ties.hpp"

namespace pantin {

using namespace detail;

namespace {

/// Checks the two ends; returns the given length, or else their distance.
template <class T>
Real length_of(Findings& findings, const T& tie, const char* member,
               const std::optional<Real>& wish) {
  findings.bodies(tie.a, tie.b);
  findings.finite("anchor_a", tie.anchor_a), findings.finite("anchor_b", tie.anchor_b);
  if (wish) findings.not_negative(member, *wish);
  return wish ? *wish : glm::distance(tie.anchor_a, tie.anchor_b);
}

template <class T>
Vec3 local_a(const World& world, const T& tie) {
  return to_local(world.bodies[tie.a].pose, tie.anchor_a);
}
template <class T>
Vec3 local_b(const World& world, const T& tie) {
  return to_local(world.bodies[tie.b].pose, tie.anchor_b);
}

void check_geared(Findings& findings, const char* member, Entity e, JointCoordinate coordinate) {
  const World& world = findings.world();
  const Link* link = world.is_alive(e) ? world.links.find(e) : nullptr;
  if (!link)
    return findings.add(member, e ? "'" + world.name_of(e) + "', which is no joint" : "no entity",
                        "a joint");
  const bool translates = coordinate == JointCoordinate::travel;
  const auto fits = [&](const JointKindInfo& kind) {
    return kind.is_used(translates ? Coordinate::travel : Coordinate::angle, kGeared);
  };
  if (fits(info_of(link->joint.kind))) return;
  findings.add(member, std::string("a joint of kind ") + name_of(link->joint.kind),
               (translates ? "one with a travel: " : "one with an angle: ") + kinds_where(fits));
}

/// Adds a joint if its solver supports it.
template <class T>
Result<Entity> link(World& world, Findings& findings, const T& described, const Joint& joint) {
  findings.known(features_of(joint), {described.a, described.b});
  if (!findings.ok()) return findings.take();
  return add_link(world, {described.a, described.b, joint}, described.name);
}

}  // namespace

Result<Entity> add_to(World& world, const DistanceJoint& described) {
  Findings findings(world, "DistanceJoint", described.name);
  const Real length = length_of(findings, described, "length", described.length);
  if (findings.ok()) findings.above_zero("length", length);
  if (!findings.ok()) return findings.take();
  Joint joint;
  joint.kind = JointKind::distance;
  joint.anchor_a = local_a(world, described), joint.anchor_b = local_b(world, described);
  joint.parameters.edit().length = length;
  return link(world, findings, described, joint);
}

Result<Entity> add_to(World& world, const SpringJoint& described) {
  Findings findings(world, "SpringJoint", described.name);
  const Real length = length_of(findings, described, "rest_length", described.rest_length);
  findings.not_negative("stiffness", described.stiffness);
  findings.not_negative("damping", described.damping);
  if (described.stiffness == 0 && described.damping == 0)
    findings.add("stiffness", "0, and no damping", "one of them above 0");
  if (!findings.ok()) return findings.take();
  Joint joint;
  joint.kind = JointKind::spring;
  joint.anchor_a = local_a(world, described), joint.anchor_b = local_b(world, described);
  joint.parameters.edit().translation.spring = {described.stiffness, described.damping, length};
  joint.parameters.edit().length = length;
  return link(world, findings, described, joint);
}

namespace {

/// Checks the guides; returns the given length, or else that of the route over them.
Real add_guides(Findings& findings, const CableJoint& described, Cable& cable) {
  const World& world = findings.world();
  const auto local = [&](Entity body, Vec3 point) {
    return to_local(world.bodies[body].pose, point);
  };
  findings.body("a", described.a), findings.body("b", described.b);
  findings.finite("anchor_a", described.anchor_a), findings.finite("anchor_b", described.anchor_b);
  if (described.length) findings.not_negative("length", *described.length);
  if (described.over.size() + 2 > kMostPathPoints)
    findings.add("over", std::to_string(described.over.size()) + " guides", "14 at most");
  for (const CableJoint::Guide& g : described.over) {
    findings.body("over", g.body), findings.finite("over", g.point);
    findings.not_negative("over", g.radius);
    if (g.turns < 0) findings.add("over", std::to_string(g.turns) + " turns", "0 or more");
    if (g.radius > 0 && !(glm::length(g.axis) > 0)) findings.add("over", "no axis", "a direction");
    if (!findings.ok()) return 0;
    CableGuide guide{g.body, local(g.body, g.point)};
    guide.radius = g.radius, guide.wrap += 2 * kPi * g.turns;
    if (g.radius > 0)
      guide.axis = glm::normalize(glm::conjugate(world.bodies[g.body].pose.rotation) *
                                  glm::normalize(g.axis));
    cable.guides.push_back(guide);
    findings.known({{Feature::cable_guide}}, {described.a, g.body, described.b});
  }
  if (!findings.ok()) return 0;
  cable.a = described.a, cable.b = described.b;
  cable.joint.anchor_a = local(described.a, described.anchor_a);
  cable.joint.anchor_b = local(described.b, described.anchor_b);
  const auto route = route_of(cable, [&](Entity e) { return &world.bodies[e].pose; });
  if (route.empty()) findings.add("over", "a body whose pose is not finite", "finite numbers");
  if (!findings.ok()) return 0;
  if (const auto fault = fault_of(route))
    findings.add("over", fault->askew ? "two pulleys in different planes" : "overlapping guides",
                 fault->askew ? "them in one plane, or a ring between them" : "them apart");
  if (!findings.ok()) return 0;
  return described.length ? *described.length : path_length(route, {}).length;
}

Result<Entity> add_cable_over(World& world, const CableJoint& described) {
  Findings findings(world, "CableJoint", described.name);
  Cable cable;
  const Real length = add_guides(findings, described, cable);
  if (findings.ok()) findings.above_zero("length", length);
  findings.not_negative("compliance", described.compliance);
  if (!findings.ok()) return findings.take();
  cable.joint.length = length, cable.joint.compliance = described.compliance;
  const Entity made = add_cable(world, {cable.a, cable.b, cable.joint}, described.name);
  world.cables[made].guides = std::move(cable.guides);
  return made;
}

}  // namespace

Result<Entity> add_to(World& world, const CableJoint& described) {
  if (!described.over.empty()) return add_cable_over(world, described);
  Findings findings(world, "CableJoint", described.name);
  const Real length = length_of(findings, described, "length", described.length);
  if (findings.ok()) findings.above_zero("length", length);
  findings.not_negative("compliance", described.compliance);
  for (const Entity end : {described.a, described.b}) findings.known({{Feature::cable}}, {end});
  if (!findings.ok()) return findings.take();
  CableParameters cable;
  cable.anchor_a = local_a(world, described), cable.anchor_b = local_b(world, described);
  cable.length = length, cable.compliance = described.compliance;
  return add_cable(world, {described.a, described.b, cable}, described.name);
}

Result<Entity> add_to(World& world, const CustomConstraint& described) {
  Findings findings(world, "CustomConstraint", described.name);
  findings.bodies(described.a, described.b);
  const int rows = described.equations ? described.equations->rows() : 0;
  if (!described.equations)
    findings.add("equations", "none", "a CustomJoint");
  else if (rows < 1 || rows > joint_kinds::custom::most)
    findings.add("equations", std::to_string(rows) + " rows", "one to six");
  if (!findings.ok()) return findings.take();
  Joint joint;
  joint.kind = JointKind::custom;
  joint.parameters.edit().custom = described.equations;
  return add_link(world, {described.a, described.b, joint}, described.name);
}

Result<Entity> add_to(World& world, const PinConstraint& described) {
  Findings findings(world, "PinConstraint", described.name);
  findings.body("body", described.body);
  if (described.to) findings.body("to", described.to);
  findings.finite("point", described.point);
  const Vec3 target = described.target.value_or(described.point);
  findings.finite("target", target);
  findings.not_negative("stiffness", described.stiffness);
  findings.not_negative("damping", described.damping);
  if (described.damping > 0 && described.stiffness == 0)
    findings.add("damping", shown(described.damping), "0 without a stiffness");
  if (findings.ok() && described.to == described.body)
    findings.add("to", "the pinned body itself", "another one");
  if (findings.ok() && world.bodies[described.body].motion != Motion::dynamic)
    findings.add("body", "a fixed or kinematic body", "a dynamic one");
  if (described.stiffness > 0) findings.known({{Feature::spring_pin}}, {described.body});
  if (!findings.ok()) return findings.take();
  Pin pin;
  pin.body = described.body, pin.to = described.to, pin.priority = described.priority;
  pin.anchor = to_local(world.bodies[described.body].pose, described.point);
  pin.target = described.to ? to_local(world.bodies[described.to].pose, target) : target;
  if (described.stiffness > 0) pin.kind = PinKind::spring, pin.stiffness = described.stiffness;
  pin.damping = described.damping;
  return world.add_pin(pin, described.name);
}

Result<Entity> add_to(World& world, const GearJoint& described) {
  Findings findings(world, "GearJoint", described.name);
  check_geared(findings, "first", described.first, described.of_first);
  check_geared(findings, "second", described.second, described.of_second);
  if (described.ratio == 0 || !std::isfinite(described.ratio))
    findings.add("ratio", shown(described.ratio), "a finite number that is not 0");
  if (described.offset) findings.finite("offset", *described.offset);
  if (described.first == described.second && described.of_first == described.of_second)
    findings.add("second", "the same coordinate as first", "another one");
  if (!findings.ok()) return findings.take();
  const Link &first = world.links[described.first], &second = world.links[described.second];
  findings.known({{Feature::ratio}}, {first.a, first.b, second.a, second.b});
  if (!findings.ok()) return findings.take();
  Gear gear;
  gear.first = described.first, gear.second = described.second;
  gear.first_travels = described.of_first == JointCoordinate::travel;
  gear.second_travels = described.of_second == JointCoordinate::travel;
  gear.ratio = described.ratio;
  gear.has_offset = described.offset.has_value(), gear.offset = described.offset.value_or(0);
  return add_gear(world, gear, described.name);
}

}  // namespace pantin
