#include "engine/world/design.hpp"

#include "engine/joints/kinds.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {
namespace {

/// The anchor of a joint or cable.
template <class Tie>
auto& anchor_of(Tie& tie, Quantity quantity) {
  return quantity == Quantity::anchor_a ? tie.joint.anchor_a : tie.joint.anchor_b;
}

}  // namespace

std::string_view design_fault(const Joint& joint, Quantity quantity) {
  switch (quantity) {
    case Quantity::length:
      if (joint.kind != JointKind::distance)
        return "expected the length of a distance joint or of a cable";
      return {};
    case Quantity::radius:
      return "expected the radius of a pulley that a cable runs over";
    case Quantity::pitch:
      if (joint.kind != JointKind::screw) return "expected the pitch of a screw joint";
      return {};
    case Quantity::anchor_a:
    case Quantity::anchor_b:
      if (joint.kind == JointKind::custom || joint.kind == JointKind::spring)
        return "expected an anchor of a joint whose equations constrain it";
      return {};
    default:  // axes
      if (!info_of(joint.kind).uses_axes) return "expected an axis of a joint that has one";
      return {};
  }
}

std::string_view design_fault(const CableParameters& cable, Quantity quantity, Real radius) {
  if (cable.compliance > 0) return "expected a cable that is inextensible, without \"compliance\"";
  switch (quantity) {
    case Quantity::pitch:
      return "expected the pitch of a screw joint";
    case Quantity::axis_a:
    case Quantity::axis_b:
      return "expected an axis of a joint";
    case Quantity::radius:
      if (!(radius > 0)) return "expected the number of a pulley of the cable, with a \"radius\"";
      return {};
    default:  // length and anchors
      return {};
  }
}

std::string_view fault_of(const World& world, const DesignVariable& v) {
  if (const Link* link = world.links.find(v.law)) return design_fault(link->joint, v.quantity);
  const Cable* cable = world.cables.find(v.law);
  if (!cable) return "expected a joint or a cable";
  const Real radius = v.guide < cable->guides.size() ? cable->guides[v.guide].radius : -1;
  return design_fault(cable->joint, v.quantity, radius);
}

DesignValue value_of(const World& world, const DesignVariable& variable) {
  const Quantity q = variable.quantity;
  if (const Link* link = world.links.find(variable.law)) {
    const JointFrames& frames = link->joint.frames;
    if (q == Quantity::length) return {Vec3(link->joint.parameters->length, 0, 0)};
    if (q == Quantity::pitch) return {Vec3(link->joint.parameters->pitch, 0, 0)};
    if (q == Quantity::axis_a) return {Vec3(0), frames.a()};
    if (q == Quantity::axis_b) return {Vec3(0), frames.b()};
    return {anchor_of(*link, q)};
  }
  const Cable& cable = world.cables[variable.law];
  if (q == Quantity::length) return {Vec3(cable.joint.length, 0, 0)};
  if (q == Quantity::radius) return {Vec3(cable.guides[variable.guide].radius, 0, 0)};
  return {anchor_of(cable, q)};
}

void set_value(World& world, const DesignVariable& variable, const DesignValue& value) {
  const Quantity q = variable.quantity;
  if (Link* link = world.links.find(variable.law)) {
    Joint& joint = link->joint;
    if (q == Quantity::length)
      joint.parameters.edit().length = value.numbers.x;
    else if (q == Quantity::pitch)
      joint.parameters.edit().pitch = value.numbers.x;
    else if (q == Quantity::axis_a)
      joint.frames.set_a(value.axes);
    else if (q == Quantity::axis_b)
      joint.frames.set_b(value.axes);
    else
      anchor_of(*link, q) = value.numbers;
    return;
  }
  Cable& cable = world.cables[variable.law];
  if (q == Quantity::length)
    cable.joint.length = value.numbers.x;
  else if (q == Quantity::radius)
    cable.guides[variable.guide].radius = value.numbers.x;
  else
    anchor_of(cable, q) = value.numbers;
}

}  // namespace pantin::detail
