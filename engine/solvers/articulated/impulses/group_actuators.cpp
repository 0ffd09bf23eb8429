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

void prepare_actuator(const Group& g, std::uint32_t node) {
  GroupNode& n = g.nodes[node];
  GroupActuator& by = n.actuator;
  const Quat parent = parent_rotation(g, n);
  PANTIN_ASSERT(by.dof && n.joint);
  by.axis = sign_of(*n.joint) * actuated_axis(*n.joint, n.rotation, parent);
  by.angle = unwound(coordinate_of(*n.joint, n.rotation, parent), by.angle);
  by.response = glm::dot(by.axis, joint_response(g, n, by.axis));
}

void push_actuators(const Group& g) {
  for (std::uint32_t i = 0; i < g.nodes.size(); ++i)
    if (const GroupActuator& by = g.nodes[i].actuator; by.impulse != 0)
      apply_at_joint(g, i, by.impulse * by.axis);
}

void solve_actuators(const Group& g, Real h) {
  for (std::uint32_t i = 0; i < g.nodes.size(); ++i) {
    GroupActuator& by = g.nodes[i].actuator;
    if (!by.dof || !(by.response > 0)) continue;
    const auto impulse_at = [&](Real rate) {
      const LinearisedForce f = linearise(*by.dof, by.angle + h * rate, rate, Slope::tangent);
      return std::array<Real, 2>{h * f.force, h * (h * f.stiffness + f.damping)};
    };
    const Real freely = rate_of(g, i) - by.response * by.impulse;
    const Real impulse = impulse_at(settled(freely, by.response, impulse_at))[0];
    const Real more = impulse - by.impulse;
    if (more == 0) continue;
    by.impulse = impulse;
    apply_at_joint(g, i, more * by.axis);
  }
}

}  // namespace pantin::detail::articulated
