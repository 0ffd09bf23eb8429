#pragma once
/// Valid numbers of joints and bodies, for adding and for changing them. Not installed.
#include <optional>
#include <pantin/joints.hpp>

#include "engine/pantin/detail/findings.hpp"

namespace pantin::detail {

AngleLimit limit_of(Findings& findings, const char* member, const std::optional<Interval>& range);
/// Adds a soft stop to the limits.
void soften(Findings& findings, const std::optional<SoftStop>& soft, JointLimits& limits);
SwingLimit swing_of(Findings& findings, const ConeLimit& cone);
void check(Findings& findings, const std::optional<JointDrive>& drive);
/// Whether joints of the kind have what the drive acts on.
void check_drive(Findings& findings, const JointDrive& drive, JointKind kind);
void check(Findings& findings, const SpringDamper& spring);
void check(Findings& findings, const JointFriction& friction);
void check(Findings& findings, const JointMotor& motor);
void check(Findings& findings, const Collision& collision);

}  // namespace pantin::detail
