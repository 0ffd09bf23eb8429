#pragma once
/// Joints drawn at random and their equations, for tests. Poses are drawn with open joints: nothing
/// here may hold on the solution only.
#include <memory>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/joints/rows.hpp"
#include "tests/base/random.hpp"
#include "tests/joints/equations.hpp"

namespace pantin::test {

using namespace detail;

inline Equations rows_of(const Joint& joint, const BodyState& a, const BodyState& b,
                         Real before = 0) {
  Equations block;
  write_rows({joint, a, b, before}, block.out());
  return block;
}
inline Equations coordinate(const Joint& joint, Coordinate which, const BodyState& a,
                            const BodyState& b, Real before = 0) {
  Equations block;
  write_coordinate({joint, a, b, before}, which, block.out());
  return block;
}

inline Quat about_x(Real angle) { return from_rotation_vector({angle, 0, 0}); }
inline Quat about_y(Real angle) { return from_rotation_vector({0, angle, 0}); }
inline Quat about_z(Real angle) { return from_rotation_vector({0, 0, angle}); }

/// A ball joint as a user would write it, and one row more: how x axes of the bodies stand.
class UserBall : public CustomJoint {
 public:
  UserBall(Vec3 a, Vec3 b) : a_(a), b_(b) {}
  int rows() const override { return 4; }
  void residual(const Pose& a, const Pose& b, std::span<Real> c) const override {
    const Vec3 d = to_world(a, a_) - to_world(b, b_), x(1, 0, 0);
    c[0] = d.x, c[1] = d.y, c[2] = d.z;
    c[3] = glm::dot(a.rotation * x, b.rotation * x);
  }

 private:
  Vec3 a_, b_;
};

inline Joint any_joint(JointKind kind, Random& dice) {
  Joint joint;
  joint.kind = kind;
  joint.anchor_a = dice.in_cube(1), joint.anchor_b = dice.in_cube(1);
  const Quat frame_a = dice.rotation(), frame_b = dice.rotation();
  joint.frames.set(frame_a, frame_b);
  JointLimits limits;
  limits.swing.on = true;
  limits.swing.y = dice.between(0.5, 2), limits.swing.z = dice.between(0.5, 2);
  joint.limits = limits;
  JointParameters& parameters = joint.parameters.edit();
  parameters.length = dice.between(0.5, 2), parameters.pitch = dice.between(-0.5, 0.5);
  parameters.custom = std::make_shared<UserBall>(joint.anchor_a, joint.anchor_b);
  return joint;
}

/// Body b where its axes stand by `q` in those of a and its anchor `d` away (world axes).
inline BodyState standing(const Joint& joint, const BodyState& a, Quat q, Vec3 d) {
  const Quat rotation = a.rotation * joint.frames.a() * q * glm::conjugate(joint.frames.b());
  return placed(a.position + a.rotation * joint.anchor_a + d - rotation * joint.anchor_b, rotation);
}

/// Two bodies under way; constant v', and R = exp(t p) exp(t t q / 2) R0, so w' = q at first.
struct Flow {
  BodyState start;
  Vec3 push{0}, twist{0};
  BodyState after(Real t) const {
    const Quat first = from_rotation_vector(t * start.angular_velocity);
    return placed(start.position + t * start.velocity + t * t / 2 * push,
                  first * from_rotation_vector(t * t / 2 * twist) * start.rotation,
                  start.velocity + t * push, start.angular_velocity + first * (t * twist));
  }
};

/// A joint ajar: its angles anywhere, off its solution by half a radian and half a metre.
struct Ajar {
  Joint joint;
  Flow a, b;
  Real first = 0, second = 0;  // the turns that were drawn
};
inline Ajar ajar(JointKind kind, Random& dice) {
  Ajar s;
  s.joint = any_joint(kind, dice);
  s.first = dice.between(-3, 3), s.second = dice.between(-3, 3);
  const Vec3 place = dice.in_cube(1);
  s.a.start = placed(place, dice.rotation());
  const Vec3 off = dice.between(0.1, 0.5) * dice.direction();
  const Quat q = kind == JointKind::universal
                     ? about_y(s.first) * about_x(off.x) * about_z(s.second)
                     : rotation_of(SwingTwist{s.first, {0, off.y, off.z}});
  const Vec3 apart = dice.between(0.5, 1) * dice.direction();
  s.b.start = standing(s.joint, s.a.start, q, apart);
  for (Flow* flow : {&s.a, &s.b}) {
    flow->start.velocity = dice.in_cube(1), flow->start.angular_velocity = dice.in_cube(1);
    flow->push = dice.in_cube(1), flow->twist = dice.in_cube(1);
  }
  return s;
}

struct Misses {
  Real rate = 0, second = 0;
};

/// dC/dt against J V, and d(J V)/dt against J a - gamma, by sixth-order differences.
template <class Write>
Misses misses(const Ajar& s, int rows, Write write) {
  constexpr Real h = 1e-3, weights[] = {45, -9, 1};
  const auto at = [&](Real t) {
    const BodyState a = s.a.after(t), b = s.b.after(t);
    Equations block = write(a, b);
    for (int i = 0; i < rows; ++i) block.gamma[std::size_t(i)] = block.rate(i, a, b);
    return block;
  };
  Equations change;
  for (int n = 1; n <= 3; ++n) {
    const Equations ahead = at(n * h), behind = at(-n * h);
    for (std::size_t i = 0; i < 6; ++i) {
      change.c[i] += weights[n - 1] * (ahead.c[i] - behind.c[i]) / (60 * h);
      change.gamma[i] += weights[n - 1] * (ahead.gamma[i] - behind.gamma[i]) / (60 * h);
    }
  }
  const BodyState a = s.a.start, b = s.b.start;
  const BodyState push_a{{}, {}, {}, s.a.push, s.a.twist}, push_b{{}, {}, {}, s.b.push, s.b.twist};
  const Equations here = write(a, b);
  Misses out;
  for (int i = 0; i < rows; ++i) {
    const auto k = std::size_t(i);
    out.rate = std::max(out.rate, std::abs(change.c[k] - here.rate(i, a, b)));
    out.second = std::max(out.second,
                          std::abs(change.gamma[k] - here.rate(i, push_a, push_b) + here.gamma[k]));
  }
  return out;
}
inline Misses operator|(Misses p, Misses q) {
  return {std::max(p.rate, q.rate), std::max(p.second, q.second)};
}

}  // namespace pantin::test
