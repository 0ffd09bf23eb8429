// Torques of joints in the energy-momentum method: drives, soft zones, springs, friction, motors.
//
// A spring acts at the mean of its angles, so that it conserves energy; a damper acts at the mean
// rate. Both would ring where the step does not resolve their motion, with inertia I. There a
// spring of stiffness k is weighted towards the end of the step,
//   -k ((1 - s) / 2 before + (1 + s) / 2 end - rest),   s = 1 - 4 / (h^2 k / I), at least 0,
// and an impulse damps the spin at the end of the step by
//   s k h^2 / 2 + (h d / 2 - I), the second at least 0, for a damper d.
// So a stiff drive reaches its target in one step, at rest.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/joints/joint_force.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/smooth/conserving_joints.hpp"
#include "engine/world/joint_drive.hpp"

namespace pantin::detail::articulated {
namespace {

/// Value of h^2 k / I up to which the step resolves a spring.
constexpr Real kResolved = 4;

/// Weights of a spring or damper that the step may not resolve.
struct Resolution {
  Real by_end = 0.5;  // of a spring: weight of the end of the step
  Real damping = 0;   // N m s: damping of the spin at the end
};
Resolution resolution_of(Real h, Real mobility, Real stiffness, Real damping) {
  Resolution r;
  const Real y = h * h * mobility * stiffness;
  const Real unresolved = y > kResolved ? 1 - kResolved / y : 0;
  r.by_end += 0.5 * unresolved;
  r.damping =
      0.5 * h * h * stiffness * unresolved + std::max(Real(0), 0.5 * h * damping - 1 / mobility);
  return r;
}

/// The inertia of a body alone, without outboard bodies, about an axis through its own joint.
Real inertia_about(const StiffStep& s, std::size_t c, Vec3 axis) {
  const Quat q = s.world.bodies.values()[s.a.slots[c]].pose.rotation;
  const Vec3 inside = glm::conjugate(q) * axis;
  const Vec3 arm = s.a.parents[c] == kFree ? Vec3(0) : q * s.a.constants.vec(kOwnAnchor, c);
  const Vec3 across = glm::cross(axis, arm);
  return glm::dot(inside * s.a.constants.vec(kInertia, c), inside) +
         s.a.constants.at(kMass, c) * glm::dot(across, across);
}

Real mobility_of_parent(const StiffStep& s, std::size_t c, Vec3 axis) {
  const std::int32_t p = s.a.parents[c];
  return p < 0 ? 0 : 1 / inertia_about(s, static_cast<std::size_t>(p), axis);
}
/// The coordinate of an actuated joint over the substep.
struct Way {
  Real before, end;  // rad
};

/// The force of a Dof as a function of the coordinate at the end.
struct Law {
  const Dof& dof;
  Real h, by_end;
  Way way;

  LinearisedForce forces(Real end) const {
    return linearise(dof, way.before + by_end * (end - way.before), (end - way.before) / h,
                     Slope::tangent);
  }
  /// Force and minus its derivative by the coordinate at the end, which is `end`.
  std::array<Real, 2> at(Real end) const {
    const LinearisedForce f = forces(end);
    return {f.force, by_end * f.stiffness + f.damping / h};
  }
};

/// The spring, friction and motor of a joint.
void add_dof(const StiffStep& s, std::size_t c, const JointEnds& ends) {
  const PackedJoint& j = s.a.joints[c];
  ConservingNode& n = s.a.scratch.conserving_nodes[c];
  const Real sign = sign_of(j);
  const Vec3 axis0 = actuated_axis(j, ends.own0, ends.parent0),
             axis = actuated_axis(j, ends.own1, ends.parent1), mean = glm::normalize(axis0 + axis);
  const Dof& dof = dof_of(s.world, s.a, c);
  const Real before = unwound(coordinate_of(j, ends.own0, ends.parent0), s.a.joint_memory[c].angle);
  const Way way{before, unwound(coordinate_of(j, ends.own1, ends.parent1), before)};
  // From the last elimination, plus the parent's mobility.
  const Real mobility = n.yield > 0 ? 2 * n.yield / (s.h * s.h) + mobility_of_parent(s, c, axis0)
                                    : mobility_about(s, c, axis0);
  const Real stiffness =
      dof.spring.stiffness + (dof.motor.kind == MotorKind::position ? dof.motor.gain : 0);
  const Law law{dof, s.h, resolution_of(s.h, mobility, stiffness, 0).by_end, way};
  const Real yield = n.yield > 0 ? n.yield : 0.5 * s.h * s.h * mobility;
  const auto force_at = [&](Real end) { return law.at(end); };
  const Real x = saturates(dof) ? settled(way.end - yield * n.expected, yield, force_at) : way.end;
  const auto [force, slope] = law.at(x);
  n.expected = force + slope * (x - way.end), n.slope = slope, n.axis = sign * axis;
  const LinearisedForce f = law.forces(x);
  const Real damping = resolution_of(s.h, mobility, f.stiffness, f.damping).damping;
  const bool turns = dof.motor.kind == MotorKind::velocity && f.damping > 0;
  n.damping += damping * glm::outerProduct(axis, axis);
  // A velocity motor below its cap keeps its target speed.
  if (turns)
    n.damped += damping * std::min(Real(1), dof.motor.gain / f.damping) * dof.motor.target * n.axis;
  // Scaled so that the work of the spring is exactly its force times the change of the coordinate.
  const Real turned = sign * glm::dot(mean, turned_by(s, c, ends)), moved = way.end - way.before;
  const bool tells = std::abs(turned) > 1e-6 && std::abs(moved) < kPi / 2;
  const Real exact = tells ? std::clamp(moved / turned, Real(0.5), Real(1)) : 1;
  const Real at = way.before + law.by_end * moved,
             stored = dof.spring.stiffness * (at - dof.spring.rest);
  n.exerted += sign * (n.expected + (1 - exact) * stored) * mean;
  n.stiffness += slope * glm::outerProduct(mean, axis);
}

/// The derivative of a rotation vector by a rotation in the body's own axes.
Mat3 turn_of_vector(Vec3 r) {
  const Real angle2 = glm::dot(r, r), angle = std::sqrt(angle2);
  const Real by_square =
      angle > 1e-3 ? 1 / angle2 - 1 / (2 * angle * std::tan(0.5 * angle)) : 1.0 / 12;
  const Mat3 across = cross_matrix(r);
  return Mat3(1) + 0.5 * across + by_square * across * across;
}

/// rad/s: rate of a drive's target in the world, at the end of the substep.
Vec3 target_rate(const StiffStep& s, std::size_t c, const JointEnds& ends, Real until) {
  const PackedJoint& j = s.a.joints[c];
  const JointDrive& drive = s.world.joint_drives.values()[j.drive];
  if (drive.keys.empty()) return Vec3(0);
  const Real before = 1e-3 * s.h;
  return rotation_vector(
             own_rotation(j, ends.parent1, target_at(drive, until)) *
             glm::conjugate(own_rotation(j, ends.parent1, target_at(drive, until - before)))) /
         before;
}

void add_drive(const StiffStep& s, std::size_t c, const JointEnds& ends) {
  const PackedJoint& j = s.a.joints[c];
  const JointDrive& drive = s.world.joint_drives.values()[j.drive];
  ConservingNode& n = s.a.scratch.conserving_nodes[c];
  const Real from = s.world.time + s.part.begin * s.part.whole,
             until = s.world.time + s.part.end * s.part.whole;
  const Quat goal0 = own_rotation(j, ends.parent0, target_at(drive, from)),
             goal1 = own_rotation(j, ends.parent1, target_at(drive, until));
  const Vec3 off0 = rotation_vector(goal0 * glm::conjugate(ends.own0)),
             off1 = rotation_vector(goal1 * glm::conjugate(ends.own1));
  Vec3 ahead(0);  // the target's own rotation
  if (!drive.keys.empty())
    ahead = rotation_vector(goal1 *
                            glm::conjugate(own_rotation(j, ends.parent1, target_at(drive, from))));
  const Real mobility = std::max({mobility_about(s, c, {1, 0, 0}), mobility_about(s, c, {0, 1, 0}),
                                  mobility_about(s, c, {0, 0, 1})});
  const Resolution by = resolution_of(s.h, mobility, drive.stiffness, drive.damping);
  const Vec3 torque = drive.stiffness * ((1 - by.by_end) * off0 + by.by_end * off1) +
                      drive.damping / s.h * (ahead - turned_by(s, c, ends));
  const Real whole = glm::length(torque);
  n.drive_share = whole > drive.max_torque ? drive.max_torque / whole : 1;
  n.driven = n.drive_share * whole;
  n.exerted += n.drive_share * torque;
  n.stiffness += n.drive_share *
                 (by.by_end * drive.stiffness * turn_of_vector(off1) + Mat3(drive.damping / s.h));
  if (n.drive_share < 1 || by.damping == 0) return;
  n.damping += Mat3(by.damping);
  n.damped += by.damping * target_rate(s, c, ends, until);
}

/// Springs before the limits: the mean force is a discrete gradient of the stored energy.
void add_soft_zones(const StiffStep& s, std::size_t c, const JointEnds& ends) {
  const PackedJoint& j = s.a.joints[c];
  const JointLimits& limits = *j.joint.limits;
  ConservingNode& n = s.a.scratch.conserving_nodes[c];
  JointLimit before[4], end[4];
  find_limits(j, ends.own0, ends.parent0, before);
  find_limits(j, ends.own1, ends.parent1, end);
  for (int k = 0; k < 4; ++k) {
    if (!end[k].watched) continue;
    const Real within1 = limits.soft_zone - end[k].clearance;
    const Real within0 = before[k].watched ? limits.soft_zone - before[k].clearance : within1;
    const Real in0 = std::max(Real(0), within0), in1 = std::max(Real(0), within1);
    if (in0 == 0 && in1 == 0) continue;
    const Vec3 along = end[k].along;
    const Real damping = in1 > 0 ? limits.soft_damping : 0;
    const Resolution by =
        resolution_of(s.h, mobility_about(s, c, along), limits.soft_stiffness, damping);
    const Real way = within1 - within0, at_end = 2 * by.by_end - 1;
    const bool moves = std::abs(way) > 1e-9;
    const Real stored = moves ? (in1 * in1 - in0 * in0) / (2 * way) : 0.5 * (in0 + in1);
    const Real by_way = moves ? (in1 - stored) / way : 0.5;
    const Real pull =
        limits.soft_stiffness * ((1 - at_end) * stored + at_end * in1) + damping / s.h * way;
    const Real slope =
        limits.soft_stiffness * ((1 - at_end) * by_way + (in1 > 0 ? at_end : 0)) + damping / s.h;
    n.exerted -= pull * along;
    n.stiffness += slope * glm::outerProduct(along, along);
    if (in1 > 0) n.damping += by.damping * glm::outerProduct(along, along);
  }
}

}  // namespace

Real mobility_about(const StiffStep& s, std::size_t c, Vec3 axis) {
  return 1 / inertia_about(s, c, axis) + mobility_of_parent(s, c, axis);
}

Vec3 turned_by(const StiffStep& s, std::size_t c, const JointEnds& ends) {
  const auto cayley = [](Quat to, Quat from) {
    const Quat q = to * glm::conjugate(from);
    return 2 / q.w * Vec3(q.x, q.y, q.z);
  };
  return cayley(ends.own1, ends.own0) - (s.a.parents[c] < 0 && held_body_of(s.a, c) == UINT32_MAX
                                             ? Vec3(0)
                                             : cayley(ends.parent1, ends.parent0));
}

bool is_actuated(const PackedJoint& joint) {
  return joint.joint.parameters.any() && joint.joint.parameters->rotation.any() &&
         info_of(joint.joint.kind).is_used(Coordinate::angle, kActuated);
}

bool exerts_torque(const PackedJoint& joint) {
  return joint.drive != UINT32_MAX || joint.joint.limits->soft_zone > 0 || is_actuated(joint);
}

const Dof& dof_of(const World& world, const Island& a, std::size_t c) {
  return world.links.values()[a.links[c]].joint.parameters->rotation;
}

bool is_driven(const World& world, const Island& a, std::size_t c) {
  const PackedJoint& joint = a.joints[c];
  if (joint.drive != UINT32_MAX) return true;
  if (!is_actuated(joint)) return false;
  const Dof& dof = dof_of(world, a, c);
  return dof.motor.kind != MotorKind::none || dof.spring.stiffness != 0;
}

Real coordinate_of(const PackedJoint& joint, Quat own, Quat parent) {
  const Quat rotation = joint_rotation(joint, own, parent);
  return turns_of(joint.joint.kind) == Turns::about_two ? universal_angles(rotation).first
                                                        : swing_twist(rotation).twist;
}

Real unwound(Real angle, Real near) {
  return angle + 2 * kPi * std::round((near - angle) / (2 * kPi));
}

Vec3 actuated_axis(const PackedJoint& joint, Quat own, Quat parent) {
  const Quat a = (joint.own_is_a ? own : parent) * joint.joint.frames.a();
  return a * (turns_of(joint.joint.kind) == Turns::about_two ? Vec3(0, 1, 0) : Vec3(1, 0, 0));
}

void find_torque(const StiffStep& s, std::size_t c, const JointEnds& ends) {
  const PackedJoint& j = s.a.joints[c];
  if (!exerts_torque(j)) return;
  ConservingNode& n = s.a.scratch.conserving_nodes[c];
  n.exerted = n.damped = Vec3(0), n.stiffness = n.damping = Mat3(0);
  if (is_actuated(j)) add_dof(s, c, ends);
  if (j.drive != UINT32_MAX) add_drive(s, c, ends);
  if (j.joint.limits->soft_zone > 0) add_soft_zones(s, c, ends);
}

Real angle_of(const World& world, const Island& a, std::size_t c) {
  const auto rotation = [&](std::uint32_t slot) {
    return slot == UINT32_MAX ? kIdentity : world.bodies.values()[slot].pose.rotation;
  };
  const std::uint32_t parent =
      a.parents[c] >= 0 ? a.slots[static_cast<std::size_t>(a.parents[c])] : held_body_of(a, c);
  return unwound(coordinate_of(a.joints[c], rotation(a.slots[c]), rotation(parent)),
                 a.joint_memory[c].angle);
}

Real rate_of(const World& world, const Island& a, std::size_t c) {
  const std::uint32_t parent =
      a.parents[c] >= 0 ? a.slots[static_cast<std::size_t>(a.parents[c])] : held_body_of(a, c);
  const Body& own = world.bodies.values()[a.slots[c]];
  const Body* const other = parent == UINT32_MAX ? nullptr : &world.bodies.values()[parent];
  const Vec3 axis =
      actuated_axis(a.joints[c], own.pose.rotation, other ? other->pose.rotation : kIdentity);
  const Vec3 spin = own.angular_velocity - (other ? other->angular_velocity : Vec3(0));
  return sign_of(a.joints[c]) * glm::dot(axis, spin);
}

bool counts_turns(const Island& a, std::size_t c) {
  return a.joints[c].stiff && is_actuated(a.joints[c]) && a.parents[c] != kFree;
}

void count_turns(const World& world, Island& a) {
  for (std::size_t c = 0; c < a.joints.size(); ++c)
    if (counts_turns(a, c)) a.joint_memory[c].angle = angle_of(world, a, c);
}

}  // namespace pantin::detail::articulated
