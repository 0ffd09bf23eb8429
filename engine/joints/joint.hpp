#pragma once
/// Joints between two bodies: what every kind has. The kinds themselves are listed in kinds.hpp.
///
///   p_i = x_i + R_i anchor_i            anchors fixed in each body
///   Q = (R_a F_a)^-1 (R_b F_b) rotation of b's joint axes relative to a's
///
/// The joint axes F are x, y, z. x is the hinge axis, and the twist axis of a ball joint; in limbs
/// it runs along the bone.
///
/// Internal (pantin::detail); installed because World::links holds it.
#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/joints/boxed.hpp"
#include "engine/joints/limits.hpp"
#include "engine/joints/parameters.hpp"

namespace pantin::detail {

/// The names come from the list in kinds.hpp: JointKind::hinge. The first, 0, is the ball.
enum class JointKind : std::uint8_t;
constexpr JointKind last_of(JointKind);

/// Rotations from the joint axes to the frames of both bodies. Needs no memory while both are the
/// identity, as for most ball joints. Copies are deep.
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

  Quat a() const { return held_ ? held_->a : kIdentity; }
  Quat b() const { return held_ ? held_->b : kIdentity; }
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
  JointKind kind{};  // ball
  JointFrames frames = {};
  BoxedLimits limits = {};
  Boxed<JointParameters> parameters = {};

  static void fields(auto& self, auto&& field) {
    field("anchor_a", self.anchor_a);
    field("anchor_b", self.anchor_b);
    field("kind", self.kind);
    field("frames", self.frames);
    field("limits", self.limits);
    field("parameters", self.parameters);
  }
};

/// From the point on body a to the point on body b, world axes, m.
inline Vec3 residual(const Joint& joint, const Pose& a, const Pose& b) {
  return to_world(b, joint.anchor_b) - to_world(a, joint.anchor_a);
}

/// Q, the rotation of b's joint axes relative to a's.
inline Quat relative_rotation(const Joint& joint, Quat a, Quat b) {
  return glm::conjugate(a * joint.frames.a()) * (b * joint.frames.b());
}

/// The rotation nearest to `q` that the kind allows, without limits.
Quat allowed_by_kind(JointKind kind, Quat q);

/// The rotation nearest to `q` that kind and limits allow; unit quaternions. Within the limits it
/// equals allowed_by_kind bit for bit.
Quat allowed_rotation(const Joint& joint, Quat q);

/// Whether a unit quaternion is farther than `margin`, rad, from every limit: a sufficient
/// condition, without trigonometric functions.
bool is_far_from_limits(const Joint& joint, Quat q, Real margin);

/// Angle between `q` and the nearest allowed rotation, rad.
Real violation(const Joint& joint, Quat q);

}  // namespace pantin::detail
