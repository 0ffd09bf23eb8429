#pragma once
/// How far a joint may turn.
///
/// A turn Q of ball joints is split into a twist about x and, after it, a swing about an axis in
/// the y-z plane: Q = swing twist [Lee 2000, sec. 4, which leaves it open]. A universal joint is
/// split into its two angles: Q = turn about y by the first, then about its z by the second.
#include <memory>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin {

/// An angle between two others, rad. Equal ones lock it. The range need not contain zero.
struct AngleLimit {
  bool on = false;
  Real low = 0, high = 0;

  static void fields(auto& self, auto&& field) {
    field("on", self.on);
    field("low", self.low);
    field("high", self.high);
  }
};

/// A cone of elliptic section: the swing's rotation vector (0, y, z) has (y / `y`)^2 + (z / `z`)^2
/// at most 1. Half angles in rad, from 0 (locked) to pi. Equal ones make a round cone.
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
  AngleLimit turn{};   // hinge: its angle; ball: twist; universal: about y of a
  AngleLimit second{}; // universal: about z of b
  SwingLimit swing{};  // ball
  // Before a stop comes a spring: within `soft_zone` of it a torque grows up to `soft_stiffness`
  // times that angle, and brakes.
  Real soft_zone = 0;       // rad
  Real soft_stiffness = 0;  // N m/rad
  Real soft_damping = 0;    // N m s/rad, within the zone
  bool any() const { return turn.on || second.on || swing.on; }

  static void fields(auto& self, auto&& field) {
    field("turn", self.turn);
    field("second", self.second);
    field("swing", self.swing);
    field("soft_zone", self.soft_zone);
    field("soft_stiffness", self.soft_stiffness);
    field("soft_damping", self.soft_damping);
  }
};

/// Limits that take no room where there are none, as with most joints. A value: copies are deep.
class RareLimits {
 public:
  RareLimits() = default;
  RareLimits(const JointLimits& limits) {
    if (limits.any()) held_ = std::make_unique<JointLimits>(limits);
  }
  RareLimits(const RareLimits& o) { *this = o; }
  RareLimits(RareLimits&&) = default;
  RareLimits& operator=(const RareLimits& o) {
    held_ = o.held_ ? std::make_unique<JointLimits>(*o.held_) : nullptr;
    return *this;
  }
  RareLimits& operator=(RareLimits&&) = default;

  const JointLimits& operator*() const {
    static const JointLimits kNone;
    return held_ ? *held_ : kNone;
  }
  const JointLimits* operator->() const { return &**this; }
  operator const JointLimits&() const { return **this; }
  bool any() const { return held_ && held_->any(); }

  /// For changing them; they take room from now on.
  JointLimits& edit() {
    if (!held_) held_ = std::make_unique<JointLimits>();
    return *held_;
  }

  static void fields(auto& self, auto&& field) { field("held", self.held_); }

 private:
  std::unique_ptr<JointLimits> held_;
};

/// Q = swing * twist. `angle` of the twist in (-pi, pi]; `swing` as a rotation vector, its x is 0.
/// Where the swing is a half turn, the twist is none.
struct SwingTwist {
  Real twist = 0;
  Vec3 swing{0};
};
SwingTwist swing_twist(Quat q);
Quat turn_of(const SwingTwist& parts);

/// The two angles of a universal joint for the nearest turn it can make.
struct UniversalAngles {
  Real first = 0, second = 0;
};
UniversalAngles universal_angles(Quat q);
Quat turn_of(const UniversalAngles& angles);

/// The angle within a limit that is nearest on the circle. Angles are told apart by whole turns
/// only as far as the limit reaches: a range of more than a turn allows all.
Real clamped(const AngleLimit& limit, Real angle);

/// A swing beyond the cone is drawn back along itself to its rim.
Vec3 clamped(const SwingLimit& limit, Vec3 swing);

}  // namespace pantin
