// Springs, friction and motors along the coordinates of joints of trees in contact. Their impulses
// follow their laws at the end of the substep (implicit), iterated with the contacts. So dry
// friction holds and motors keep to their caps, whatever the step.
#include "engine/joints/joint_force.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

Real rate_of(const Group& g, std::uint32_t node) {
  return glm::dot(g.nodes[node].actuator.axis, relative_spin(g, node));
}

}  // namespace

ActuatedAxis actuated_axis_of(const GroupNode& n, Quat own, Quat parent) {
  PANTIN_ASSERT(n.actuator.dof && n.joint);
  return {sign_of(*n.joint) * actuated_axis(*n.joint, own, parent),
          unwound(coordinate_of(*n.joint, own, parent), n.actuator.angle)};
}

void prepare_actuator(const Group& g, std::uint32_t node) {
  GroupNode& n = g.nodes[node];
  GroupActuator& by = n.actuator;
  const auto [axis, angle] = actuated_axis_of(n, n.rotation, parent_rotation(g, n));
  by.axis = axis, by.angle = angle;
  by.response = glm::dot(by.axis, joint_response(g, n, by.axis));
}

void push_actuators(const Group& g) {
  for (std::uint32_t i = 0; i < g.nodes.size(); ++i)
    if (const GroupActuator& by = g.nodes[i].actuator; by.impulse != 0)
      apply_at_joint(g, i, by.impulse * by.axis);
}

namespace {

/// Whether a body is the last of its branch and rotates about its mass centre.
bool is_wheel(const Group& g, std::uint32_t node) {
  constexpr Real kHub = 1e-6;  // m
  const bool is_last = node + 1 >= g.nodes.size() || g.nodes[node + 1].parent != node;
  return is_last && glm::length(g.nodes[node].own_anchor) < kHub;
}

}  // namespace

Real speed_by_actuators(const Group& g, Real h) {
  Real turning = 0;  // rad/s
  for (std::uint32_t i = 0; i < g.nodes.size(); ++i) {
    const GroupActuator& by = g.nodes[i].actuator;
    if (!by.dof || !(by.response > 0) || is_wheel(g, i)) continue;
    const Real rate = rate_of(g, i);
    turning += std::abs(rate_after(*by.dof, {by.angle, rate, h}, by.response) - rate);
  }
  if (turning == 0) return 0;
  Real arm = 0;
  for (const GroupContact& c : g.contacts) {
    if (g.a(c).node != kNoNode) arm = std::max(arm, glm::length(c.arm_a));
    if (g.b(c).node != kNoNode) arm = std::max(arm, glm::length(c.arm_b));
  }
  for (const GroupNode& n : g.nodes) arm = std::max(arm, 2 * glm::length(n.own_anchor));
  return turning * arm;
}

void solve_actuators(const Group& g, Real h) {
  for (std::uint32_t i = 0; i < g.nodes.size(); ++i) {
    GroupActuator& by = g.nodes[i].actuator;
    if (!by.dof || !(by.response > 0)) continue;
    const Real freely = rate_of(g, i) - by.response * by.impulse;
    const Real rate = rate_after(*by.dof, {by.angle, freely, h}, by.response);
    const Real impulse = h * linearise(*by.dof, by.angle + h * rate, rate, Slope::tangent).force;
    const Real more = impulse - by.impulse;
    if (more == 0) continue;
    by.impulse = impulse;
    apply_at_joint(g, i, more * by.axis);
  }
}

}  // namespace pantin::detail::articulated
