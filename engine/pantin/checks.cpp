// Valid numbers of joints and bodies.
#include "engine/pantin/detail/checks.hpp"

#include "engine/joints/kinds.hpp"

namespace pantin::detail {

AngleLimit limit_of(Findings& findings, const char* member, const std::optional<Interval>& range) {
  if (!range) return {};
  if (!std::isfinite(range->low) || !std::isfinite(range->high) || range->low > range->high)
    findings.add(member, shown(range->low) + " to " + shown(range->high),
                 "two finite numbers, the lower one first");
  return {true, range->low, range->high};
}

void soften(Findings& findings, const std::optional<SoftStop>& soft, JointLimits& limits) {
  if (!soft) return;
  findings.above_zero("soft_stop.zone", soft->zone);
  findings.not_negative("soft_stop.stiffness", soft->stiffness);
  findings.not_negative("soft_stop.damping", soft->damping);
  if (!limits.any()) findings.add("soft_stop", "one", "limits beside it");
  limits.soft_zone = soft->zone, limits.soft_stiffness = soft->stiffness;
  limits.soft_damping = soft->damping;
}

SwingLimit swing_of(Findings& findings, const ConeLimit& cone) {
  findings.within("cone.y", cone.y, 0, kPi);
  findings.within("cone.z", cone.z, 0, kPi);
  return {true, cone.y, cone.z};
}

void check(Findings& findings, const std::optional<JointDrive>& drive) {
  if (!drive) return;
  findings.rotation("drive.target", drive->target);
  findings.not_negative("drive.stiffness", drive->stiffness);
  findings.not_negative("drive.damping", drive->damping);
  if (!(drive->max_torque >= 0))
    findings.add("drive.max_torque", shown(drive->max_torque), "0 or a number above it");
  for (std::size_t i = 0; i < drive->keys.size(); ++i) {
    findings.finite("drive.keys.time", drive->keys[i].time);
    findings.rotation("drive.keys.turn", drive->keys[i].rotation);
    if (i > 0 && !(drive->keys[i].time > drive->keys[i - 1].time))
      findings.add("drive.keys", "times that do not increase", "each key after the one before");
  }
  if (!drive->exact) return;
  const DriveMotion& motion = drive->motion;
  findings.finite("drive.motion.offset", motion.offset);
  findings.finite("drive.motion.speed", motion.speed);
  findings.finite("drive.motion.amplitude", motion.amplitude);
  findings.finite("drive.motion.frequency", motion.frequency);
  findings.finite("drive.motion.phase", motion.phase);
  for (std::size_t i = 0; i < motion.knots.size(); ++i) {
    findings.finite("drive.motion.knots.value", motion.knots[i].value);
    if (!std::isfinite(motion.knots[i].time) ||
        (i > 0 && !(motion.knots[i].time > motion.knots[i - 1].time)))
      findings.add("drive.motion.knots", "times that do not increase",
                   "each knot after the one before");
  }
}

void check_drive(Findings& findings, const JointDrive& drive, JointKind kind) {
  const JointKindInfo& info = info_of(kind);
  const std::string found = "a drive of a joint of kind " + std::string(info.name);
  if (drive.exact &&
      !info.is_used(drive.motion.travels ? Coordinate::travel : Coordinate::angle, kActuated))
    findings.add(
        "drive.motion", found,
        std::string("one of a kind with ") + (drive.motion.travels ? "a travel" : "one angle"));
  if (!drive.exact &&
      (!info.holds_point || info.rotations == Turns::nowhere || info.rotations == Turns::own))
    findings.add("drive", found, "one of kind ball, hinge or universal, or an exact motion");
}

void check(Findings& findings, const SpringDamper& spring) {
  findings.not_negative("spring.stiffness", spring.stiffness);
  findings.not_negative("spring.damping", spring.damping);
  findings.finite("spring.rest", spring.rest);
}

void check(Findings& findings, const JointFriction& friction) {
  findings.not_negative("friction.viscous", friction.viscous);
  findings.not_negative("friction.dry", friction.dry);
  findings.above_zero("friction.slip", friction.slip);
}

void check(Findings& findings, const JointMotor& motor) {
  if (motor.kind == MotorKind::none) {
    if (motor.target != 0 || motor.gain != 0)
      findings.add("motor.kind", "none, with a target or a gain", "velocity or position");
    return;
  }
  findings.finite("motor.target", motor.target);
  findings.not_negative("motor.gain", motor.gain);
  if (motor.gain == 0 && motor.damping != 0)
    findings.add("motor.damping", shown(motor.damping) + " without a gain",
                 "both, or neither: they are then chosen");
  findings.not_negative("motor.damping", motor.damping);
  if (!(motor.cap >= 0)) findings.add("motor.cap", shown(motor.cap), "0 or a number above it");
}

void check(Findings& findings, const Collision& collision) {
  findings.not_negative("collision.friction", collision.friction);
  findings.within("collision.restitution", collision.restitution, 0, 1);
  findings.not_negative("collision.rolling", collision.rolling);
  findings.not_negative("collision.spinning", collision.spinning);
  findings.finite("collision.surface_velocity", collision.surface_velocity);
  findings.finite("collision.one_way", collision.one_way);
}

}  // namespace pantin::detail
