#pragma once
/// Parameters of a joint besides its anchors, axes and limits: dimensions of certain kinds, and
/// forces along its degrees of freedom. world/faults.cpp lists which solver supports which.
#include <cstdint>
#include <memory>
#include <span>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/joints/limits.hpp"

namespace pantin {

/// force = -stiffness (coordinate - rest) - damping rate
struct SpringDamper {
  Real stiffness = 0;  // N m/rad or N/m
  Real damping = 0;    // N m s/rad or N s/m
  Real rest = 0;       // rad or m

  static void fields(auto& self, auto&& field) {
    field("stiffness", self.stiffness);
    field("damping", self.damping);
    field("rest", self.rest);
  }
};

/// force = -viscous rate - dry tanh(rate / slip): dry friction regularised near zero rate.
struct JointFriction {
  Real viscous = 0;  // N m s/rad or N s/m
  Real dry = 0;      // N m or N
  Real slip = 1e-2;  // rad/s or m/s, above zero

  static void fields(auto& self, auto&& field) {
    field("viscous", self.viscous);
    field("dry", self.dry);
    field("slip", self.slip);
  }
};

enum class MotorKind : std::uint8_t { none, velocity, position };
constexpr MotorKind last_of(MotorKind) { return MotorKind::position; }

/// velocity: force = gain (target - rate); position: force = gain (target - coordinate) - damping
/// rate. The magnitude is at most `cap`.
///
/// Without a gain, the first step chooses gain and damping, and stores them here: the motor is then
/// critically damped, as fast as steps of that length resolve (engine/solvers/motor_gains.hpp).
struct JointMotor {
  MotorKind kind = MotorKind::none;
  Real target = 0;   // rad/s or m/s; rad or m
  Real gain = 0;     // N m s/rad or N s/m; N m/rad or N/m; 0: chosen in the first step
  Real damping = 0;  // position: N m s/rad or N s/m
  Real cap = 1e300;  // N m or N

  static void fields(auto& self, auto&& field) {
    field("kind", self.kind);
    field("target", self.target);
    field("gain", self.gain);
    field("damping", self.damping);
    field("cap", self.cap);
  }
};

/// Interface of a user-defined joint: only the residual is required; derivatives are computed by
/// finite differences.
class CustomJoint {
 public:
  virtual ~CustomJoint() = default;
  /// Number of rows, 1 to 6; constant.
  virtual int rows() const = 0;
  /// The residual, `rows` numbers, for bodies at these mass-centre poses. Smooth; zero where the
  /// joint is closed; a function of its arguments only.
  virtual void residual(const Pose& a, const Pose& b, std::span<Real> c) const = 0;
  /// A number that differs where the residual differs, for state_hash. Joints of this kind cannot
  /// be saved: see save_world.
  virtual std::uint64_t fingerprint() const { return static_cast<std::uint64_t>(rows()); }
};

namespace detail {

/// Forces along one degree of freedom of a joint.
struct Dof {
  SpringDamper spring = {};
  JointFriction friction = {};
  JointMotor motor = {};
  bool any() const {
    return spring.stiffness != 0 || spring.damping != 0 || friction.viscous != 0 ||
           friction.dry != 0 || motor.kind != MotorKind::none;
  }

  static void fields(auto& self, auto&& field) {
    field("spring", self.spring);
    field("friction", self.friction);
    field("motor", self.motor);
  }
};

struct JointParameters {
  Real length = 0;         // m, of kinds with such a parameter: distance, spring, wheel (radius)
  Real pitch = 0;          // m/rad, likewise: screw, along x per rad of rotation
  Real grip = 0;           // N, likewise: skate, wheel; the force beyond which it slides, 0: none
  Real friction = 0;       // coefficient, likewise: skate, wheel; slides beyond friction times load
  Dof rotation = {};       // about x: hinge, universal (of a), cylindrical, screw
  Dof translation = {};    // along x: cylindrical, prismatic; along the line: kind `spring`
  AngleLimit travel = {};  // m along x: cylindrical, prismatic, screw
  Real restitution = 0;    // coefficient of restitution of the limits, 0 to 1
  std::shared_ptr<const CustomJoint> custom = nullptr;

  static void fields(auto& self, auto&& field) {
    field("length", self.length);
    field("pitch", self.pitch);
    field("grip", self.grip);
    field("friction", self.friction);
    field("rotation", self.rotation);
    field("translation", self.translation);
    field("travel", self.travel);
    field("restitution", self.restitution);
    field("custom", self.custom);
  }
};

}  // namespace detail

}  // namespace pantin
