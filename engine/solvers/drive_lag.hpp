#pragma once
/// Exact drives with a maximum torque: what all solvers that have them do.
///
/// Each step is first taken as if there were no maximum. The coordinate may be behind its motion by
/// a lag e then; it is required to catch up like a critically damped oscillator, from the present
/// lag and its rate:
///
///   e(t) = (e0 + (e0' + k e0) t) exp(-k t),   k^2 = a / |e0|, at most 1 / (4 h)^2
///
/// where a is twice the acceleration by the maximum torque. With this k, which grows as e falls, it
/// brakes by (3 - 2 sqrt 2) a, a third of that torque.
///
/// If that takes more than the maximum torque in the mean of the step, the step is repeated with
/// the maximum torque as a constant force.
#include "engine/joints/joint.hpp"
#include "engine/world/joint_drive.hpp"

namespace pantin::detail {

/// How an exact drive with a maximum torque acts in a step.
struct DriveLag {
  // Its coordinate is behind its motion by (value + (rate + decay value) t) exp(-decay t), at the
  // time t since `from`: rad or m, rad/s or m/s, s, 1/s.
  Real value = 0, rate = 0, from = 0, decay = 0;
  bool yields = false;   // it exerts `force` instead
  Real force = 0;        // N m or N
  bool limited = false;  // it yields for want of torque; others do while contacts are resolved
};

bool has_most(const JointDrive& drive);

/// The lag of a drive whose joint has this coordinate and rate, at the start of a step of h
/// seconds.
DriveLag lag_at(const JointDrive& drive, const CoordinateMotion& now, Real time, Real h);
/// Whether it is more than rounding.
bool is_behind(const JointDrive& drive, const DriveLag& lag);
/// Sets how fast it catches up; `mobility` is the acceleration by a unit force, with all other
/// laws.
void set_pace(const JointDrive& drive, Real mobility, DriveLag& lag);

/// The motion that a drive follows in a step.
CoordinateMotion motion_behind(const JointDrive& drive, const DriveLag& lag, Real time);

/// The joint of a drive, and its coordinate now, rad or m.
struct DrivenJoint {
  const Joint& joint;
  Real now = 0;
};
/// How far the motion at a time is beyond the limits of the joint, rad or m: below its least value
/// negative, 0 within them.
Real beyond_limit(const JointDrive& drive, const DriveLag& lag, const DrivenJoint& of, Real time);
/// Lets a drive press on that limit in the step, by its maximum.
void press(const JointDrive& drive, Real beyond, DriveLag& lag);

enum class StepOutcome : bool { taken, failed };
/// A step that was taken as if there were no maximum: its mean force along the coordinate, N m or
/// N, and how far it remained from the motion, rad or m, as where a limit stops the joint.
struct DriveNeed {
  Real force = 0, missed = 0;
  bool failed = false;  // the step has no result
};
/// Lets a drive yield whose step needed more than its maximum. Returns whether it does.
bool yield_to(const JointDrive& drive, const DriveNeed& need, DriveLag& lag);

/// The same for several drives: `each` calls its argument with each drive, its need and its lag.
/// A step without a result is first repeated with those yielding that are behind.
template <class Each>
bool yield_any(StepOutcome outcome, Each&& each) {
  bool any = false;
  if (outcome == StepOutcome::failed)
    each([&](const JointDrive& drive, const DriveNeed& need, DriveLag& lag) {
      if (is_behind(drive, lag)) any = yield_to(drive, need, lag) || any;
    });
  if (any) return true;
  each([&](const JointDrive& drive, const DriveNeed& need, DriveLag& lag) {
    any = yield_to(drive, need, lag) || any;
  });
  return any;
}

}  // namespace pantin::detail
