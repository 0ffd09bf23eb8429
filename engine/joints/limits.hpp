#pragma once
/// Limits of joint rotations.
///
/// A rotation Q of a ball joint is decomposed into a twist about x followed by a swing about an
/// axis in the y-z plane: Q = swing twist [Lee 2000, sec. 4, which leaves it open]. A universal
/// joint is decomposed into two angles: Q = rotation about y by the first, then about its z by the
/// second.
///
/// Internal (pantin::detail); installed because World::links holds it.
#include <memory>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin::detail {

/// A range of angles, rad. Equal bounds lock the angle. The range need not contain zero.
struct AngleLimit {
  bool on = false;
  Real low = 0, high = 0;

  static void fields(auto& self, auto&& field) {
    field("on", self.on);
    field("low", self.low);
    field("high", self.high);
  }
};

/// An elliptic cone: the rotation vector (0, y, z) of the swing satisfies (y / `y`)^2 + (z / `z`)^2
/// <= 1. Half angles in rad, from 0 (locked) to pi. Equal ones make a circular cone.
struct SwingLimit {
  bool on = false;
  Real y = 0, z = 0;

  static void fields(auto& self, auto&& field) {
    field("on", self.on);
    field("y", self.y);
    field("z", self.z);
  }
};

struct JointLimits {
  AngleLimit angle{};   // hinge: its angle; ball: twist; universal: about y of a
  AngleLimit second{};  // universal: about z of b
  SwingLimit swing{};   // ball
  // Soft zone: within `soft_zone` of a limit a spring and damper act, with torque up to
  // soft_stiffness * soft_zone.
  Real soft_zone = 0;       // rad
  Real soft_stiffness = 0;  // N m/rad
  Real soft_damping = 0;    // N m s/rad, within the zone
  bool any() const { return angle.on || second.on || swing.on; }

  static void fields(auto& self, auto&& field) {
    field("angle", self.angle);
    field("second", self.second);
    field("swing", self.swing);
    field("soft_zone", self.soft_zone);
    field("soft_stiffness", self.soft_stiffness);
    field("soft_damping", self.soft_damping);
  }
};

/// Limits that need no memory where there are none, as in most joints. Copies are deep.
class BoxedLimits {
 public:
  BoxedLimits() = default;
  BoxedLimits(const JointLimits& limits) {
    if (limits.any()) held_ = std::make_unique<JointLimits>(limits);
  }
  BoxedLimits(const BoxedLimits& o) { *this = o; }
  BoxedLimits(BoxedLimits&&) = default;
  BoxedLimits& operator=(const BoxedLimits& o) {
    held_ = o.held_ ? std::make_unique<JointLimits>(*o.held_) : nullptr;
    return *this;
  }
  BoxedLimits& operator=(BoxedLimits&&) = default;

  const JointLimits& operator*() const {
    static const JointLimits kNone;
    return held_ ? *held_ : kNone;
  }
  const JointLimits* operator->() const { return &**this; }
  operator const JointLimits&() const { return **this; }
  bool any() const { return held_ && held_->any(); }

  /// For changing them; allocates memory.
  JointLimits& edit() {
    if (!held_) held_ = std::make_unique<JointLimits>();
    return *held_;
  }

  static void fields(auto& self, auto&& field) { field("held", self.held_); }

 private:
  std::unique_ptr<JointLimits> held_;
};

/// Q = swing * twist. `angle` of the twist in (-pi, pi]; `swing` as a rotation vector, its x is 0.
/// Where the swing is half a revolution, the twist is zero.
struct SwingTwist {
  Real twist = 0;
  Vec3 swing{0};
};
SwingTwist swing_twist(Quat q);
Quat rotation_of(const SwingTwist& parts);

/// The two angles of a universal joint whose rotation is nearest.
struct UniversalAngles {
  Real first = 0, second = 0;
};
UniversalAngles universal_angles(Quat q);
Quat rotation_of(const UniversalAngles& angles);

/// Sufficient conditions, without trigonometric functions, for angles to be within limits: of the
/// angle 2 atan(x / w), w > 0; of the swing and the twist of a unit quaternion.
bool is_within(const AngleLimit& limit, Real x, Real w);
bool is_within(const JointLimits& limits, Quat q);

/// The angle within a limit that is nearest on the circle. A range of more than a revolution allows
/// every angle.
Real clamped(const AngleLimit& limit, Real angle);

/// Scales a swing beyond the cone back to its boundary.
Vec3 clamped(const SwingLimit& limit, Vec3 swing);

}  // namespace pantin::detail
