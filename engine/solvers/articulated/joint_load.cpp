// Forces and torques through a joint, computed on request after a step.
//
// Forces are the multipliers of the step. Torques follow by an inward recursion of Newton and
// Euler: what a body was rotated by, from its predicted to its final pose, is the work of its
// joints and of all else that loads it,
//   I theta = tau + r x lambda - sum over joints to outboard bodies (tau_k + r_k x lambda_k) +
//   others
// with the arms r from the mass centre and the wrench (lambda, tau) at the joint to the parent.
#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

bool is_stiff(const Island& a, std::size_t c) { return !a.joints.empty() && a.joints[c].stiff; }

Vec3 arm_of(const Island& a, std::size_t column, Vec3 anchor) {
  return a.scratch.work.quat(kFinalRotation, column) * anchor;
}

/// Torques about the mass centres, kg m^2, by column.
using Torques = std::vector<Vec3>;

void subtract_pins(const Island& a, Torques& torques) {
  for (const PackedPin& pin : a.pins) {
    torques[pin.column] -= glm::cross(arm_of(a, pin.column, pin.anchor), pin.lambda);
    if (pin.partner != UINT32_MAX)
      torques[pin.partner] += glm::cross(arm_of(a, pin.partner, pin.held_anchor), pin.lambda);
  }
}

/// An end of a cable: the column of its body, or none and a body elsewhere; and the point in it.
struct CableEnd {
  std::uint32_t column = UINT32_MAX;
  Entity body;
  Vec3 anchor{0};
};

/// The point of a cable's end in the world.
Vec3 point_of(const World& world, const Island& a, const CableEnd& end) {
  if (end.column != UINT32_MAX) return point_at(a, end.column, end.anchor, kFinalPoses);
  return to_world(world.bodies[end.body].pose, end.anchor);
}

void subtract_cables(const World& world, const Island& a, Torques& torques) {
  for (const PackedCable& packed : a.cables) {
    const std::uint32_t slot = world.cables.slot_now(packed.cable);
    if (slot >= world.cables.size() || packed.lambda == 0) continue;
    const Cable* cable = &world.cables.values()[slot];
    const CableParameters& own = cable->joint;
    const Vec3 to_b = point_of(world, a, {packed.column_b, cable->b, own.anchor_b}) -
                      point_of(world, a, {packed.column_a, cable->a, own.anchor_a});
    const Real span = glm::length(to_b);
    if (!(span > 0)) continue;
    const Vec3 pull = packed.lambda / span * to_b;
    if (packed.column_a != UINT32_MAX)
      torques[packed.column_a] -= glm::cross(arm_of(a, packed.column_a, own.anchor_a), pull);
    if (packed.column_b != UINT32_MAX)
      torques[packed.column_b] += glm::cross(arm_of(a, packed.column_b, own.anchor_b), pull);
  }
}

void subtract_contacts(const World& world, const Island& a, Real to_lambda, Torques& torques) {
  for (const ContactRow& row : a.scratch.contact_rows) {
    const Contact& contact = contacts_of(world)[row.contact];
    const Vec3 point = row.side > 0 ? contact.point_a : contact.point_b;
    torques[row.column] -=
        to_lambda * row.side * glm::cross(arm_of(a, row.column, point), contact.force);
  }
}

/// Of the drive and the soft zones, on the body of the column.
Vec3 torque_of_springs(const Island& a, std::size_t c) {
  const JointTerms& t = a.scratch.terms[c];
  return t.torque - t.spring * t.rotated +
         a.joint_memory[c].torque_fraction * (t.drive_torque - t.drive_spring * t.rotated);
}

/// The torque through the joint of a column, springs included.
Vec3 torque_through(const World& world, const Island& a, std::size_t column, Real to_lambda) {
  const LaneTable& work = a.scratch.work;
  Torques torques(a.count(), Vec3(0));
  subtract_pins(a, torques);
  subtract_cables(world, a, torques);
  subtract_contacts(world, a, to_lambda, torques);
  for (std::size_t c = a.count(); c-- > column;) {
    const Vec3 lambda = a.memory.vec(kLambda, c);
    Vec3 own(0);  // a free ball joint transmits none
    if (is_stiff(a, c)) {
      const Quat predicted = work.quat(kRotation, c);
      const Vec3 theta = rotation_vector(work.quat(kFinalRotation, c) * glm::conjugate(predicted));
      own = torques[c] + world_inertia(predicted, a.constants.vec(kInertia, c)) * theta -
            glm::cross(arm_of(a, c, a.constants.vec(kOwnAnchor, c)), lambda);
    }
    if (c == column) return own;
    if (a.parents[c] < 0) continue;
    const auto parent = static_cast<std::size_t>(a.parents[c]);
    torques[parent] +=
        own + glm::cross(arm_of(a, parent, a.constants.vec(kParentAnchor, c)), lambda);
  }
  return Vec3(0);
}

}  // namespace

Real force_per_lambda(const Island& a) {
  const Real h = a.last_step;
  const bool knows = a.settings.solver == Solver::articulated && !a.scratch.work.numbers().empty();
  return knows && h > 0 ? 1 / (a.force_share * h * h) : 0;
}

JointLoad joint_load(const World& world, const Island& a, std::size_t column) {
  const Real to_force = force_per_lambda(a);
  JointLoad load{to_force * a.memory.vec(kLambda, column), Vec3(0)};
  if (to_force == 0 || !is_stiff(a, column)) return load;
  if (a.knows_torques) {
    load.torque = a.joint_memory[column].torque;
    return load;
  }
  load.torque =
      to_force * (torque_through(world, a, column, 1 / to_force) - torque_of_springs(a, column));
  return load;
}

}  // namespace pantin::detail::articulated
