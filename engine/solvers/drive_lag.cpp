#include "engine/solvers/drive_lag.hpp"

#include <algorithm>
#include <cmath>

namespace pantin::detail {
namespace {

/// Least time constant of catching up, in steps.
constexpr Real kCatchUpSteps = 4;
/// Acceleration by which it catches up, by that of the maximum torque: it brakes with a third of it
/// then, and the rest is for loads.
constexpr Real kPace = 2;
/// A smaller lag is caught up in the least time, rad or m, relative to the coordinate.
constexpr Real kBehind = 1e-9;
/// Relative excess of the torque that counts as rounding.
constexpr Real kRounding = 1e-9;
/// rad or m: a coordinate that is farther from where it should be could not follow.
constexpr Real kFollowed = 1e-8;
constexpr Real kUnlimited = 1e299;

}  // namespace

bool has_most(const JointDrive& drive) { return drive.max_torque < kUnlimited; }

DriveLag lag_at(const JointDrive& drive, const CoordinateMotion& now, Real time, Real h) {
  const CoordinateMotion target = motion_at(drive.motion, time);
  return {.value = target.value - now.value,
          .rate = target.rate - now.rate,
          .from = time,
          .decay = 1 / (kCatchUpSteps * h)};
}

bool is_behind(const JointDrive& drive, const DriveLag& lag) {
  return std::abs(lag.value) > kBehind * (1 + std::abs(motion_at(drive.motion, lag.from).value));
}

void set_pace(const JointDrive& drive, Real mobility, DriveLag& lag) {
  const Real able = kPace * drive.max_torque * mobility;
  if (lag.value != 0) lag.decay = std::min(lag.decay, std::sqrt(able / std::abs(lag.value)));
}

CoordinateMotion motion_behind(const JointDrive& drive, const DriveLag& lag, Real time) {
  CoordinateMotion x = motion_at(drive.motion, time);
  if (lag.value == 0 && lag.rate == 0) return x;
  const Real t = time - lag.from, k = lag.decay, faded = std::exp(-k * t);
  const Real slope = lag.rate + k * lag.value, now = lag.value + slope * t;
  x.value -= now * faded;
  x.rate -= (slope - k * now) * faded;
  x.acceleration -= k * (k * now - 2 * slope) * faded;
  return x;
}

Real beyond_limit(const JointDrive& drive, const DriveLag& lag, const DrivenJoint& of, Real time) {
  const bool travels = drive.motion.travels;
  const AngleLimit& range = travels ? of.joint.parameters->travel : of.joint.limits->angle;
  if (!range.on) return 0;
  // Whole turns do not count in limits of angles.
  const Real middle = 0.5 * (range.low + range.high);
  const Real turns = travels ? 0 : std::round((of.now - middle) / (2 * kPi)) * 2 * kPi;
  const Real next = motion_behind(drive, lag, time).value - turns;
  return next - std::clamp(next, range.low, range.high);
}

void press(const JointDrive& drive, Real beyond, DriveLag& lag) {
  lag.yields = lag.limited = true;
  lag.force = std::copysign(drive.max_torque, beyond);
}

bool yield_to(const JointDrive& drive, const DriveNeed& need, DriveLag& lag) {
  if (lag.yields || !has_most(drive)) return false;
  // Against another law of its joint, as a limit, its multiplier moves nothing and is removed.
  const bool follows = std::abs(need.missed) <= kFollowed * (1 + std::abs(lag.value));
  Real needed = need.force;
  if (need.failed)
    needed = is_behind(drive, lag) ? lag.decay * lag.value + 2 * lag.rate
                                   : motion_at(drive.motion, lag.from).rate;
  if (!need.failed && !follows) needed = need.missed;
  if (!need.failed && follows && std::abs(needed) <= (1 + kRounding) * drive.max_torque)
    return false;
  lag.yields = lag.limited = true;
  lag.force = needed == 0 ? 0 : std::copysign(drive.max_torque, needed);
  return true;
}

}  // namespace pantin::detail
