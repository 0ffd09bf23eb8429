#pragma once
/// Joints between two bodies: what every kind has. The kinds themselves are listed in kinds.hpp.
///
///   p_i = x_i + R_i anchor_i            anchors fixed in each body
///   Q = (R_a F_a)^-1 (R_b F_b)          how b's joint axes stand in a's
///
/// The joint axes F are x, y, z. x is the axis that a hinge turns about and that a ball joint
/// twists about; with limbs it runs along the bone.
#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/joints/extras.hpp"
#include "engine/joints/limits.hpp"
#include "engine/joints/rare.hpp"

namespace pantin {

/// Named by the list of kinds, kinds.hpp: JointKind::hinge. The first, 0, is the ball.
enum class JointKind : std::uint8_t;

/// Turns from the joint axes to the frames of both bodies. Takes no room while both are none, as
/// with most ball joints. A value: copies are deep.
class JointFrames {
 public:
  JointFrames() = default;
  JointFrames(Quat a, Quat b) { set(a, b); }
  JointFrames(const JointFrames& o) { *this = o; }
  JointFrames(JointFrames&&) = default;
  JointFrames& operator=(const JointFrames& o) {
    held_ = o.held_ ? std::make_unique<Both>(*o.held_) : nullptr;
    return *this;
  }
  JointFrames& operator=(JointFrames&&) = default;

  Quat a() const { return held_ ? held_->a : kNoTurn; }
  Quat b() const { return held_ ? held_->b : kNoTurn; }
  void set(Quat a, Quat b) { held_ = std::make_unique<Both>(Both{a, b}); }
  void set_a(Quat to) { set(to, b()); }
  void set_b(Quat to) { set(a(), to); }

  static void fields(auto& self, auto&& field) { field("held", self.held_); }

 private:
  struct Both {
    Quat a{1, 0, 0, 0}, b{1, 0, 0, 0};

    static void fields(auto& self, auto&& field) {
      field("a", self.a);
      field("b", self.b);
    }
  };
  std::unique_ptr<Both> held_;
};

struct Joint {
  Vec3 anchor_a{0};  // in body a's mass-centre frame, m
  Vec3 anchor_b{0};  // in body b's mass-centre frame, m
  JointKind kind{};      // ball
  JointFrames frames = {};
  RareLimits limits = {};
  Rare<JointExtras> extras = {};

  static void fields(auto& self, auto&& field) {
    field("anchor_a", self.anchor_a);
    field("anchor_b", self.anchor_b);
    field("kind", self.kind);
    field("frames", self.frames);
    field("limits", self.limits);
    field("extras", self.extras);
  }
};

/// From the point on body a to the point on body b, world axes, m.
inline Vec3 residual(const Joint& joint, const Pose& a, const Pose& b) {
  return to_world(b, joint.anchor_b) - to_world(a, joint.anchor_a);
}

/// How b's joint axes stand in a's: Q.
inline Quat relative_turn(const Joint& joint, Quat a, Quat b) {
  return glm::conjugate(a * joint.frames.a()) * (b * joint.frames.b());
}

/// The turn nearest to `q` (see closest_turn) that the kind allows, limits aside.
Quat allowed_by_kind(JointKind kind, Quat q);

/// ... and that the limits allow too; unit quaternions in and out. Within the limits it returns the
/// turn that the kind allows, bit for bit.
Quat allowed_turn(const Joint& joint, Quat q);

/// How far `q` is from what kind and limits allow, rad.
Real violation(const Joint& joint, Quat q);

}  // namespace pantin
