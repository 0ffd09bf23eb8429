#pragma once
/// What a joint may have besides its point, its axes and its limits: measures of the kinds that
/// need one, and what acts along its freedoms. Only the Lagrangian solver knows them.
#include <cstdint>
#include <memory>
#include <span>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/joints/limits.hpp"

namespace pantin {

/// effort = -stiffness (coordinate - rest) - damping rate
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

/// effort = -viscous rate - dry tanh(rate / slip): dry friction whose step at rest is rounded off.
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

/// velocity: effort = gain (target - rate); position: gain (target - coordinate) - damping rate.
/// At most `cap` either way.
struct Motor {
  MotorKind kind = MotorKind::none;
  Real target = 0;   // rad/s or m/s; rad or m
  Real gain = 0;     // N m s/rad or N s/m; N m/rad or N/m
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

/// What acts along one freedom of a joint.
struct Freedom {
  SpringDamper spring = {};
  JointFriction friction = {};
  Motor motor = {};
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

/// A kind of joint from outside: its residual is all it needs, the rest comes by differences.
class CustomJoint {
 public:
  virtual ~CustomJoint() = default;
  /// Rows, 1 to 6; always the same.
  virtual int rows() const = 0;
  /// What the joint lacks, `rows` numbers, for bodies at these mass-centre poses. Smooth; all zero
  /// where the joint is closed; independent of anything but its arguments.
  virtual void residual(const Pose& a, const Pose& b, std::span<Real> c) const = 0;
  /// A number that differs where the residual differs, for state_hash. Joints of this kind cannot
  /// be saved: see save_world.
  virtual std::uint64_t fingerprint() const { return static_cast<std::uint64_t>(rows()); }
};

struct JointExtras {
  Real length = 0;      // m, of kinds with such a parameter: distance, spring
  Real pitch = 0;       // m/rad, likewise: screw, along x for each rad of turn
  Freedom turn = {};    // about x: hinge, universal (of a), cylindrical, screw
  Freedom slide = {};   // along x: cylindrical, prismatic; along the line: distance-like `spring`
  AngleLimit travel = {};  // m along x: cylindrical, prismatic, screw
  Real restitution = 0;    // part of the speed with which a limit is left again, 0 to 1
  std::shared_ptr<const CustomJoint> custom = nullptr;

  static void fields(auto& self, auto&& field) {
    field("length", self.length);
    field("pitch", self.pitch);
    field("turn", self.turn);
    field("slide", self.slide);
    field("travel", self.travel);
    field("restitution", self.restitution);
    field("custom", self.custom);
  }
};

}  // namespace pantin
