// Torques between the two bodies of a joint: drives and soft stops.
#include <algorithm>
#include <array>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/joints/stops.hpp"
#include "engine/solvers/lagrangian/internal.hpp"
#include "engine/world/joint_drive.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// s: half the interval of the finite difference for a drive target's angular velocity.
constexpr Real kDifference = 1e-3;

Mat3 along_itself(Vec3 v) { return glm::outerProduct(v, v); }

void add_drive(const World& world, const Island& m, const BodyPairForce& p, JointTorque& sum) {
  const JointDrive* drive = world.joint_drives.find(world.links.owners()[p.source]);
  if (!drive || drive->exact) return;
  const Joint& joint = world.links.values()[p.source].joint;
  const BodyState &a = m.scratch.body_states[p.body[0]], &b = m.scratch.body_states[p.body[1]];
  const Quat axes = a.rotation * joint.frames.a();
  const Real time = m.scratch.time;
  const Quat target = target_at(*drive, time),
             now = relative_rotation(joint, a.rotation, b.rotation);
  const Vec3 own =
      drive->keys.empty()
          ? Vec3(0)
          : axes * angular_velocity_between(target_at(*drive, time - kDifference),
                                            target_at(*drive, time + kDifference), 2 * kDifference);
  const Vec3 torque = drive->stiffness * (axes * rotation_vector(target * glm::conjugate(now))) -
                      drive->damping * (b.angular_velocity - a.angular_velocity - own);
  const Real size = glm::length(torque);
  if (size > drive->max_torque) {
    sum.torque += drive->max_torque / size * torque;
    return;
  }
  sum.torque += torque;
  sum.stiffness += Mat3(drive->stiffness), sum.damping += Mat3(drive->damping);
}

void add_soft_stops(const World& world, const Island& m, const BodyPairForce& p, JointTorque& sum) {
  const Joint& joint = world.links.values()[p.source].joint;
  if (!joint.limits.any() || !(joint.limits->soft_zone > 0)) return;
  const SoftStopLoad load =
      soft_stop_load({joint, m.scratch.body_states[p.body[0]], m.scratch.body_states[p.body[1]]});
  sum.torque += load.torque;
  for (const int k : {1, 0}) {
    if (!load.acts[k]) continue;
    sum.stiffness += joint.limits->soft_stiffness * along_itself(load.along[k]);
    sum.damping += joint.limits->soft_damping * along_itself(load.along[k]);
    const Vec3 x = load.along[k];
    const Vec3 aside = std::abs(x.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    sum.axes[0] = x, sum.axes[1] = glm::normalize(glm::cross(x, aside));
    sum.axes[2] = glm::cross(x, sum.axes[1]);
  }
}

/// Relative angular acceleration of b by a unit torque, if both bodies were free.
Mat3 mobility_of(const Island& m, const BodyPairForce& p) {
  Mat3 mobile(0);
  for (const std::uint32_t body : p.body)
    if (body < m.count()) mobile += m.scratch.inverse_inertia[body];
  return mobile;
}

/// The axes about which a joint may rotate, world axes; zero vectors otherwise.
std::array<Vec3, 3> turning_directions(const World& world, const Island& m,
                                       const BodyPairForce& p) {
  const Joint& joint = world.links.values()[p.source].joint;
  const Turns turns = turns_of(joint.kind);
  if (turns == Turns::freely || turns == Turns::own) return {Vec3(1, 0, 0), {0, 1, 0}, {0, 0, 1}};
  const FreeAxes axes =
      free_axes(joint.kind, m.scratch.body_states[p.body[0]].rotation * joint.frames.a(),
                m.scratch.body_states[p.body[1]].rotation * joint.frames.b());
  return {axes.first, axes.second, Vec3(0)};
}

}  // namespace

JointTorque torque_of(const World& world, const Island& m, const BodyPairForce& p) {
  JointTorque sum;
  add_drive(world, m, p, sum);
  add_soft_stops(world, m, p, sum);
  return sum;
}

void add_joint_torques(const World& world, Island& m) {
  const Real h = m.scratch.forces_over;
  for (const BodyPairForce& p : m.joint_torques) {
    const JointTorque of = torque_of(world, m, p);
    Vec3 torque = of.torque;
    if (h > 0) {
      const Vec3 spin = m.scratch.body_states[p.body[1]].angular_velocity -
                        m.scratch.body_states[p.body[0]].angular_velocity;
      const Mat3 by_rate = of.damping + h * of.stiffness;
      torque = glm::inverse(Mat3(1) + h * by_rate * mobility_of(m, p)) *
               (torque - h * (of.stiffness * spin));
    }
    for (int k = 0; k < 2; ++k)
      if (p.body[k] < m.count())
        m.scratch.force[2 * p.body[k] + 1] += (k == 0 ? -1.0 : 1.0) * torque;
  }
}

Stiffness stiffness_of_torques(const World& world, const Island& m) {
  Stiffness most;
  for (const BodyPairForce& p : m.joint_torques) {
    const JointTorque of = torque_of(world, m, p);
    const Mat3 mobile = mobility_of(m, p);
    for (const Vec3 about : turning_directions(world, m, p)) {
      const Real gives = glm::dot(about, mobile * about);
      most.spring = std::max(most.spring, gives * glm::dot(about, of.stiffness * about));
      most.damper = std::max(most.damper, gives * glm::dot(about, of.damping * about));
    }
  }
  return most;
}

}  // namespace pantin::detail::lagrangian
