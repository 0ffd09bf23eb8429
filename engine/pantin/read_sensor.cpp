// Readings of motors and sensors.
#include <algorithm>
#include <cmath>
#include <limits>
#include <pantin/measure.hpp>

#include "engine/base/rotation.hpp"
#include "engine/contact/contact.hpp"
#include "engine/joints/joint_force.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/articulated.hpp"

namespace pantin {

using namespace detail;

namespace {

constexpr Real kNoNumber = std::numeric_limits<Real>::quiet_NaN();

const Dof& dof_of(const Joint& joint, Coordinate which) {
  return which == Coordinate::angle ? joint.parameters->rotation : joint.parameters->translation;
}

/// What "auto" knows of a joint; null if it does not step it.
const articulated::JointMemory* articulated_memory(const World& world, std::uint32_t slot) {
  for (const articulated::Island& a : articulated::islands_of(world))
    for (std::size_t c = 0; c < a.count(); ++c)
      if (a.links[c] == slot) return &a.joint_memory[c];
  return nullptr;
}

Real force_of(const JointMotor& motor, Real coordinate, Real rate) {
  Dof alone;
  alone.motor = motor;
  return linearise(alone, coordinate, rate, Slope::tangent).force;
}

Real motor_force_of(const World& world, Entity joint, Coordinate which) {
  const Link& link = world.links[joint];
  const Dof& dof = dof_of(link.joint, which);
  const bool turns = which == Coordinate::angle;
  Real coordinate = turns ? joint_angle(world, joint) : joint_travel(world, joint);
  const Real rate = turns ? joint_angular_speed(world, joint) : joint_speed(world, joint);
  const std::uint32_t slot = world.links.slot_then(world.links.slot(joint));
  if (const articulated::JointMemory* m = turns ? articulated_memory(world, slot) : nullptr) {
    coordinate += 2 * kPi * std::round((m->angle - coordinate) / (2 * kPi));
    Dof others = dof;
    others.motor = {};
    if (std::isfinite(m->actuation))
      return m->actuation - linearise(others, coordinate, rate, Slope::tangent).force;
  }
  return force_of(dof.motor, coordinate, rate);
}

struct PointState {
  Vec3 position{kNoNumber}, velocity{kNoNumber};
};

PointState state_of(const World& world, const SensorPoint& point) {
  if (!point.on) return {point.at, Vec3(0)};
  const Body* body = world.bodies.find(point.on);
  if (!body) return {};
  const Vec3 at = to_world(body->pose, point.at);
  return {at, velocity_at(*body, at)};
}

/// Of the frame that the body was placed by.
Quat rotation_of(const World& world, Entity on) {
  if (!on) return kIdentity;
  if (!world.bodies.find(on)) return Quat(kNoNumber, kNoNumber, kNoNumber, kNoNumber);
  return world.origin_pose(on).rotation;
}

/// Velocity gained since the last reading, over the time.
Vec3 acceleration(const World& world, Sensor& sensor) {
  const Vec3 now = state_of(world, sensor.a).velocity, before = sensor.velocity;
  const Real since = world.time - sensor.time;
  sensor.velocity = now, sensor.time = world.time;
  return since > 0 ? (now - before) / since : Vec3(kNoNumber);
}

Real angle(const World& world, const Sensor& s) {
  if (!s.by_points) {
    const Quat turn = glm::conjugate(rotation_of(world, s.a.on)) * rotation_of(world, s.b.on);
    return glm::length(rotation_vector(turn));
  }
  const Vec3 vertex = state_of(world, s.b).position, one = state_of(world, s.a).position - vertex,
             two = state_of(world, s.c).position - vertex;
  return std::atan2(glm::length(glm::cross(one, two)), glm::dot(one, two));
}

Vec3 contact_force(const World& world, Entity body) {
  const std::uint32_t slot = world.bodies.slot(body);
  if (slot == kNoSlot) return Vec3(kNoNumber);
  Vec3 sum{0};
  for (const auto* list : {&contacts_of(world), &resting_contacts_of(world)})
    for (const Contact& c : *list) {
      if (c.slot_a == slot) sum += c.force;
      if (c.slot_b == slot) sum -= c.force;
    }
  return sum;
}

}  // namespace

Real motor_force(const World& world, Entity joint, std::optional<JointCoordinate> along) {
  const Link* link = world.links.find(joint);
  if (!link) return kNoNumber;
  const auto meant = [&](JointCoordinate which) { return !along || *along == which; };
  const JointDrive* drive = world.joint_drives.find(joint);
  if (drive && drive->exact &&
      meant(drive->motion.travels ? JointCoordinate::travel : JointCoordinate::angle))
    return drive->torque;
  for (const Coordinate which : {Coordinate::angle, Coordinate::travel})
    if (meant(which == Coordinate::travel ? JointCoordinate::travel : JointCoordinate::angle) &&
        link->joint.parameters.any() && dof_of(link->joint, which).motor.kind != MotorKind::none)
      return motor_force_of(world, joint, which);
  return kNoNumber;
}

Vec3 read_sensor(const World& world, Sensor& s) {
  const Vec3 none(kNoNumber);
  switch (s.kind) {
    case SensorKind::point:
      return state_of(world, s.a).position;
    case SensorKind::velocity:
      return state_of(world, s.a).velocity;
    case SensorKind::acceleration:
      return acceleration(world, s);
    case SensorKind::accelerometer:
      return glm::conjugate(rotation_of(world, s.a.on)) * (acceleration(world, s) - world.gravity);
    case SensorKind::distance:
      return {glm::length(state_of(world, s.b).position - state_of(world, s.a).position), 0, 0};
    case SensorKind::angle:
      return {angle(world, s), 0, 0};
    case SensorKind::force:
    case SensorKind::torque: {
      const auto reaction = joint_reaction(world, s.a.on);
      return !reaction ? none : s.kind == SensorKind::force ? reaction->force : reaction->torque;
    }
    case SensorKind::motor:
      return {motor_force(world, s.a.on), 0, 0};
    case SensorKind::contact:
      return contact_force(world, s.a.on);
  }
  return none;
}

}  // namespace pantin
