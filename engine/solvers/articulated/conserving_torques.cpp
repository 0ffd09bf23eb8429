// Torques of joints in the energy-momentum method: drives, soft zones, springs, friction, motors.
//
// A spring that the step resolves acts at the mean of its angles, so that what it stores it gives
// back; a damper acts at the mean rate. Beyond what the step resolves both act more and more at the
// end of it: nothing rings, however stiff. The rate at the end is twice the mean less that at the
// start. With s between 0, resolved, and 1
//   spring  -k ((1 - s) / 2 before + (1 + s) / 2 end - rest) - s k h / 2 (rate at the end)
//   damper  -d (rate at theta), theta = max(1/2, 1 - 1 / (h d / inertia))
// In the stiff limit both are at rest after two steps.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/joints/joint_force.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/conserving_joints.hpp"
#include "engine/world/joint_drive.hpp"

namespace pantin::detail::articulated {
namespace {

/// Squared ratio of the step to a spring's period, over (2 pi)^2, up to which it is resolved.
constexpr Real kResolved = 4;


/// How a law is taken over the part; `mobility` is the relative turn's, 1/(kg m^2).
struct Scheme {
  Real h, stiff = 0, theta = 0.5;
  Scheme(Real length, Real mobility, Real stiffness, Real damping) : h(length) {
    const Real y = h * h * mobility * stiffness, x = h * mobility * damping;
    if (y > kResolved) stiff = 1 - kResolved / y;
    if (x > 2) theta = 1 - 1 / x;
  }
  Real by_end() const { return 0.5 * (1 + stiff); }
};

/// The inertia of a body, and of nothing outboard of it, about an axis through its own joint.
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
Real mobility_about(const StiffStep& s, std::size_t c, Vec3 axis) {
  return 1 / inertia_about(s, c, axis) + mobility_of_parent(s, c, axis);
}

/// rad/s, of the own body less that of its parent, at the start of the part.
Vec3 spin_before(const StiffStep& s, std::size_t c) {
  const auto spin = [&](std::uint32_t slot) { return s.world.bodies.values()[slot].angular_velocity; };
  if (s.a.parents[c] >= 0)
    return spin(s.a.slots[c]) - spin(s.a.slots[static_cast<std::size_t>(s.a.parents[c])]);
  const std::uint32_t held = held_body_of(s.a, c);
  return spin(s.a.slots[c]) - (held == UINT32_MAX ? Vec3(0) : spin(held));
}

/// Cayley's vector of the relative turn over the part: the work of a torque is its product with it.
Vec3 turned_by(const StiffStep& s, std::size_t c, const JointEnds& ends) {
  const auto cayley = [](Quat to, Quat from) {
    const Quat q = to * glm::conjugate(from);
    return 2 / q.w * Vec3(q.x, q.y, q.z);
  };
  return cayley(ends.own1, ends.own0) -
         (s.a.parents[c] < 0 && held_body_of(s.a, c) == UINT32_MAX
              ? Vec3(0)
              : cayley(ends.parent1, ends.parent0));
}

/// The rotations at a joint, at an iterate or at the end of the iterations.
struct EndsAt {
  JointEnds ends;
  bool iterates;
};

/// The coordinate of an actuated joint over the part.
struct Way {
  Real before, end, rate;  // rad, rad/s at the start
};

/// The force of a Dof as a function of the coordinate at the end.
struct Law {
  const Dof& dof;
  Scheme scheme;
  Way way;

  /// Force and minus its derivative by the coordinate at the end, which is `end`.
  std::array<Real, 2> at(Real end) const {
    const Real h = scheme.h, mean = (end - way.before) / h, last = 2 * mean - way.rate;
    const Real rate = 2 * scheme.theta * mean + (1 - 2 * scheme.theta) * way.rate;
    const Real coordinate = way.before + scheme.by_end() * (end - way.before);
    const LinearisedForce f = linearise(dof, coordinate, rate, Slope::tangent);
    const Real numerical = 0.5 * scheme.stiff * f.stiffness * h;
    return {f.force - numerical * last,
            scheme.by_end() * f.stiffness + (2 * scheme.theta * f.damping + 2 * numerical) / h};
  }
};

/// The spring, friction and motor of a joint.
void add_dof(const StiffStep& s, std::size_t c, const EndsAt& at, JointTorque& out) {
  const JointEnds& ends = at.ends;
  const PackedJoint& j = s.a.joints[c];
  ConservingNode& n = s.a.scratch.conserving_nodes[c];
  const Real sign = sign_of(j);
  const Vec3 axis0 = actuated_axis(j, ends.own0, ends.parent0),
             axis = actuated_axis(j, ends.own1, ends.parent1), mean = glm::normalize(axis0 + axis);
  const Dof& dof = dof_of(s.world, s.a, c);
  const Real before =
      unwound(coordinate_of(j, ends.own0, ends.parent0), s.a.joint_memory[c].angle);
  const Way way{before, unwound(coordinate_of(j, ends.own1, ends.parent1), before),
                sign * glm::dot(axis0, spin_before(s, c))};
  // As the last elimination has it, the parent apart.
  const Real mobility =
      n.yield > 0 ? 2 * n.yield / (s.h * s.h) + mobility_of_parent(s, c, axis0)
                  : mobility_about(s, c, axis0);
  LinearisedForce most = linearise(dof, dof.motor.kind == MotorKind::position ? dof.motor.target : 0,
                                   0, Slope::tangent);
  if (dof.motor.kind == MotorKind::velocity)
    most.damping = dof.spring.damping + dof.friction.viscous + dof.motor.gain +
                   dof.friction.dry / dof.friction.slip;
  const Law law{dof, Scheme(s.h, mobility, most.stiffness, most.damping), way};
  const Real yield = n.yield > 0 ? n.yield : 0.5 * s.h * s.h * mobility;
  const auto force_at = [&](Real end) { return law.at(end); };
  const Real x = saturates(dof) && at.iterates
                     ? settled(way.end - yield * n.expected, yield, force_at)
                     : way.end;
  const auto [force, slope] = law.at(x);
  n.expected = force + slope * (x - way.end), n.slope = slope, n.axis = sign * axis;
  // Its work is exactly the force times the change of the coordinate.
  const Real turned = sign * glm::dot(mean, turned_by(s, c, ends)), moved = way.end - way.before;
  const Real exact =
      std::abs(turned) > 1e-6 && std::abs(moved) < 2 ? std::clamp(moved / turned, Real(0.5), Real(1)) : 1;
  out.torque += sign * n.expected * exact * mean;
  out.stiffness += slope * glm::outerProduct(mean, axis);
}

/// The inverse of the derivative of a rotation vector by a turn in the body's own axes.
Mat3 turn_of_vector(Vec3 r) {
  const Real angle2 = glm::dot(r, r), angle = std::sqrt(angle2);
  const Real by_square =
      angle > 1e-3 ? 1 / angle2 - 1 / (2 * angle * std::tan(0.5 * angle)) : 1.0 / 12;
  const Mat3 across = cross_matrix(r);
  return Mat3(1) + 0.5 * across + by_square * across * across;
}

void add_drive(const StiffStep& s, std::size_t c, const JointEnds& ends, JointTorque& out) {
  const PackedJoint& j = s.a.joints[c];
  const JointDrive& drive = s.world.joint_drives.values()[j.drive];
  ConservingNode& n = s.a.scratch.conserving_nodes[c];
  const Real from = s.world.time + s.part.begin * s.part.whole,
             until = s.world.time + s.part.end * s.part.whole;
  const Quat goal0 = own_rotation(j, ends.parent0, target_at(drive, from)),
             goal1 = own_rotation(j, ends.parent1, target_at(drive, until));
  const Vec3 off0 = rotation_vector(goal0 * glm::conjugate(ends.own0)),
             off1 = rotation_vector(goal1 * glm::conjugate(ends.own1));
  Vec3 ahead(0);  // the target's own turn
  if (!drive.keys.empty())
    ahead = rotation_vector(goal1 *
                            glm::conjugate(own_rotation(j, ends.parent1, target_at(drive, from))));
  const Vec3 mobile(mobility_about(s, c, {1, 0, 0}), mobility_about(s, c, {0, 1, 0}),
                    mobility_about(s, c, {0, 0, 1}));
  const Real most = std::max({mobile.x, mobile.y, mobile.z});
  const Scheme scheme(s.h, most, drive.stiffness, drive.damping);
  const Vec3 rate0 = spin_before(s, c), mean = turned_by(s, c, ends) / s.h,
             last = Real(2) * mean - rate0;
  const Vec3 rate = 2 * scheme.theta * mean + (1 - 2 * scheme.theta) * rate0;
  const Real numerical = 0.5 * scheme.stiff * drive.stiffness * s.h;
  const Vec3 torque =
      drive.stiffness * ((1 - scheme.by_end()) * off0 + scheme.by_end() * off1) +
      drive.damping * (ahead / s.h - rate) + numerical * (ahead / s.h - last);
  const Real whole = glm::length(torque);
  n.drive_share = whole > drive.max_torque ? drive.max_torque / whole : 1;
  n.driven = n.drive_share * whole;
  out.torque += n.drive_share * torque;
  out.stiffness += n.drive_share * (scheme.by_end() * drive.stiffness * turn_of_vector(off1) +
                                    Mat3((2 * scheme.theta * drive.damping + 2 * numerical) / s.h));
}

/// Springs before the limits, as stiff as the step resolves at their own force's mean.
void add_soft_zones(const StiffStep& s, std::size_t c, const JointEnds& ends, JointTorque& out) {
  const PackedJoint& j = s.a.joints[c];
  const JointLimits& limits = *j.joint.limits;
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
    const Scheme scheme(s.h, mobility_about(s, c, along), limits.soft_stiffness,
                        in1 > 0 ? limits.soft_damping : 0);
    // The mean over the way, as the difference of what is stored; at the end where that is stiff.
    const Real way = within1 - within0;
    const Real stored = std::abs(way) > 1e-9 ? (in1 * in1 - in0 * in0) / (2 * way) : 0.5 * (in0 + in1);
    const Real by_end = std::abs(way) > 1e-9 ? (in1 - stored) / way : 0.5;
    const Real rate0 = glm::dot(along, spin_before(s, c)), mean = way / s.h, last = 2 * mean - rate0;
    const Real rate = 2 * scheme.theta * mean + (1 - 2 * scheme.theta) * rate0;
    const Real damping = in1 > 0 ? limits.soft_damping : 0;
    const Real numerical = in1 > 0 ? 0.5 * scheme.stiff * limits.soft_stiffness * s.h : 0;
    const Real pull = limits.soft_stiffness * ((1 - scheme.stiff) * stored + scheme.stiff * in1) +
                      damping * rate + numerical * last;
    const Real slope = limits.soft_stiffness *
                           ((1 - scheme.stiff) * by_end + (in1 > 0 ? scheme.stiff : 0)) +
                       (2 * scheme.theta * damping + 2 * numerical) / s.h;
    out.torque -= pull * along;
    out.stiffness += slope * glm::outerProduct(along, along);
  }
}

}  // namespace

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

namespace {

JointTorque torque_at(const StiffStep& s, std::size_t c, const EndsAt& at) {
  JointTorque out;
  const PackedJoint& j = s.a.joints[c];
  const JointEnds& ends = at.ends;
  if (is_actuated(j)) add_dof(s, c, at, out);
  if (j.drive != UINT32_MAX) add_drive(s, c, ends, out);
  if (j.joint.limits->soft_zone > 0) add_soft_zones(s, c, ends, out);
  return out;
}

}  // namespace

JointTorque torque_of(const StiffStep& s, std::size_t c) {
  return exerts_torque(s.a.joints[c]) ? torque_at(s, c, {ends_of(s, c), true}) : JointTorque{};
}

Real work_of(const StiffStep& s, std::size_t c) {
  const JointEnds ends = ends_of(s, c);
  const Vec3 torque = torque_at(s, c, {ends, false}).torque;
  s.a.scratch.conserving_nodes[c].exerted = torque;
  return glm::dot(torque, turned_by(s, c, ends));
}

Real angle_of(const World& world, const Island& a, std::size_t c) {
  const auto rotation = [&](std::uint32_t slot) {
    return slot == UINT32_MAX ? kIdentity : world.bodies.values()[slot].pose.rotation;
  };
  const std::uint32_t parent = a.parents[c] >= 0 ? a.slots[static_cast<std::size_t>(a.parents[c])]
                                                 : held_body_of(a, c);
  return unwound(coordinate_of(a.joints[c], rotation(a.slots[c]), rotation(parent)),
                 a.joint_memory[c].angle);
}

void count_turns(const World& world, Island& a) {
  for (std::size_t c = 0; c < a.joints.size(); ++c)
    if (a.joints[c].stiff && is_actuated(a.joints[c]) && a.parents[c] != kFree)
      a.joint_memory[c].angle = angle_of(world, a, c);
}

}  // namespace pantin::detail::articulated
