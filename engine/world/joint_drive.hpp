#pragma once
/// A joint drive: a spring and damper towards a target pose, or an exact motion along a coordinate.
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin {

/// One key pose: the joint axes of b in those of a (see Joint).
struct PoseKey {
  Real time = 0;  // s
  Quat rotation{1, 0, 0, 0};

  static void fields(auto& self, auto&& field) {
    field("time", self.time);
    field("rotation", self.rotation);
  }
};

/// How a coordinate moves from a knot to the next. With u from 0 to 1 between them:
enum class MotionLaw : std::uint8_t {
  linear,      // u
  spline,      // the cubic with continuous curvature; at rest at both ends, or periodic
  cycloidal,   // u - sin(2 pi u) / (2 pi): acceleration 0 at both ends
  polynomial,  // 10 u^3 - 15 u^4 + 6 u^5: likewise; the 3-4-5 polynomial of cams
};
constexpr MotionLaw last_of(MotionLaw) { return MotionLaw::polynomial; }

struct MotionKnot {
  Real time = 0;   // s
  Real value = 0;  // rad or m
  Real rate = 0;   // of a spline, rad/s or m/s: found by fit_spline()

  static void fields(auto& self, auto&& field) {
    field("time", self.time);
    field("value", self.value);
    field("rate", self.rate);
  }
};

/// A coordinate of a joint as a function of time,
///
///   x(t) = offset + speed t + amplitude sin(2 pi frequency t + phase) + k(t)
///
/// where k follows the knots, whose times increase strictly: constant before the first and after
/// the last. With `loop`, k repeats, and advances by the difference of its ends each time.
struct DriveMotion {
  bool travels = false;  // along the travel, m; false: the angle, rad
  bool at_start = true;  // offset is such that the joint starts where it stands: the first step
                         // sets it
  bool loop = false;
  MotionLaw law = MotionLaw::linear;
  Real offset = 0;     // rad or m
  Real speed = 0;      // rad/s or m/s
  Real amplitude = 0;  // rad or m
  Real frequency = 0;  // Hz
  Real phase = 0;      // rad
  std::vector<MotionKnot> knots = {};

  static void fields(auto& self, auto&& field) {
    field("travels", self.travels);
    field("at_start", self.at_start);
    field("loop", self.loop);
    field("law", self.law);
    field("offset", self.offset);
    field("speed", self.speed);
    field("amplitude", self.amplitude);
    field("frequency", self.frequency);
    field("phase", self.phase);
    field("knots", self.knots);
  }
};

/// A coordinate with its derivatives by time.
struct CoordinateMotion {
  Real value = 0, rate = 0, acceleration = 0;
};
CoordinateMotion motion_at(const DriveMotion& motion, Real time);
/// Sets the rates of the knots of a spline.
void fit_spline(DriveMotion& motion);

/// A component of links: a spring and damper between the bodies of a joint, capped.
///
///   torque = stiffness * (shortest rotation vector to the target)
///            - damping * (relative angular velocity - the target's own)        at most max_torque
///
/// The spring is integrated implicitly: no stiffness makes it unstable. With `keys` the target
/// follows them (slerp between keys, times strictly increasing). Otherwise the target is `target`,
/// which may be changed at any time.
///
/// An `exact` drive is a constraint instead: the coordinate follows `motion`, by whatever torque
/// (or force) that takes, up to max_torque. Where it would take more, the drive exerts max_torque
/// and the coordinate falls behind; it catches up without overshoot, as far as max_torque allows.
/// `lagrangian` has both; `planar` has exact ones of hinges and sliders.
struct JointDrive {
  Quat target{1, 0, 0, 0};
  Real stiffness = 0;       // N m/rad
  Real damping = 0;         // N m s/rad
  Real max_torque = 1e300;  // N m; N along a travel
  std::vector<PoseKey> keys = {};
  bool loop = false;        // the last key is the first one again
  bool exact = false;       // a constraint: stiffness, damping, target and keys do not count
  DriveMotion motion = {};  // of an exact drive
  // Results of the last step:
  Real torque =
      0;  // N m, size of the torque exerted; exact: along the coordinate, signed, N m or N
  bool capped = false;

  static void fields(auto& self, auto&& field) {
    field("target", self.target);
    field("stiffness", self.stiffness);
    field("damping", self.damping);
    field("max_torque", self.max_torque);
    field("keys", self.keys);
    field("loop", self.loop);
    field("exact", self.exact);
    field("motion", self.motion);
    field("torque", passive(self.torque));
    field("capped", passive(self.capped));
  }
};

/// The target of a spring at `time` (s).
Quat target_at(const JointDrive& drive, Real time);

}  // namespace pantin
