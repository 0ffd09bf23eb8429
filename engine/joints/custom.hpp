#pragma once
/// User-defined joint with at most six rows; its derivatives are computed by finite differences.
///
/// Measured on a ball joint with arms of 1 m: J to 2e-12, gamma to 6e-10 of the speeds squared;
/// twenty times worse 100 m from the origin. The residual should not bend sharply within 0.1 m.
#include <algorithm>
#include <array>

#include "engine/base/rotation.hpp"
#include "engine/joints/kind.hpp"

namespace pantin::detail::joint_kinds {

struct custom : Kind, TurnsFreely {
  static constexpr std::string_view name = "custom";
  static constexpr int most = 6, rows = kOwnRows, degrees_of_freedom = 6;
  static constexpr bool in_files = false;

  static int own_rows(const Joint& joint) {
    const auto& from = joint.parameters->custom;
    return from ? std::clamp(from->rows(), 0, most) : 0;
  }
  static const char* fault(const Joint& joint) {
    const auto& from = joint.parameters->custom;
    const bool fits = from && from->rows() >= 1 && from->rows() <= most;
    return fits ? nullptr : "is a custom joint without rows, or with more than six";
  }
  static Real gap(const Joint& joint, const Pose& a, const Pose& b) {
    return glm::length(residual(joint, a, b));
  }

  static void write(const Joint& joint, const BodyState& a, const BodyState& b, RowsOut out) {
    const int n = own_rows(joint);
    if (n == 0) return;
    const Differences of{*joint.parameters->custom, a, b, n};
    if (out.c) of.values(0, {}, out.c);
    if (out.gamma) of.write_gamma(out.gamma);
    if (out.j) of.write_jacobian(out.j);
  }

 private:
  using Values = std::array<Real, most>;
  using Twists = std::array<Vec3, 4>;  // velocity and angular velocity of a, of b

  struct Differences {
    const CustomJoint& custom;
    const BodyState& a;
    const BodyState& b;
    int n;

    static Pose moved(const BodyState& at, Real t, Vec3 velocity, Vec3 angular_velocity) {
      if (t == 0) return {at.position, at.rotation};
      return {at.position + t * velocity, from_rotation_vector(t * angular_velocity) * at.rotation};
    }
    /// The residual after both bodies have moved at constant velocities for a time `t`.
    void values(Real t, const Twists& v, Real* c) const {
      custom.residual(moved(a, t, v[0], v[1]), moved(b, t, v[2], v[3]), {c, std::size_t(n)});
    }

    // Fourth order, step in m and rad: [8 (C(h) - C(-h)) - (C(2h) - C(-2h))] / 12 h.
    void write_jacobian(Vec3* j) const {
      constexpr Real h = 5e-4;
      for (int column = 0; column < 12; ++column) {
        Twists v{};
        v[std::size_t(column / 3)][column % 3] = 1;
        Values ahead, behind, far_ahead, far_behind;
        values(h, v, ahead.data()), values(-h, v, behind.data());
        values(2 * h, v, far_ahead.data()), values(-2 * h, v, far_behind.data());
        for (std::size_t i = 0; i < std::size_t(n); ++i)
          j[4 * i + std::size_t(column / 3)][column % 3] =
              (8 * (ahead[i] - behind[i]) - (far_ahead[i] - far_behind[i])) / (12 * h);
      }
    }

    // Along constant velocities C'' = J' V = -gamma. Sixth order, each step at most 0.01 m or rad:
    // [270 C(h) - 27 C(2h) + 2 C(3h), the same for negative steps, - 490 C(0)] / 180 h h.
    void write_gamma(Real* gamma) const {
      std::fill(gamma, gamma + n, Real(0));
      const Real speed = glm::length(a.angular_velocity) + glm::length(b.angular_velocity) +
                         glm::length(a.velocity - b.velocity);
      if (!(speed > 0)) return;
      constexpr Real kWeights[] = {-490, 270, -27, 2};
      const Real h = 0.01 / speed;
      const Twists v{a.velocity, a.angular_velocity, b.velocity, b.angular_velocity};
      for (int step = -3; step <= 3; ++step) {
        Values c;
        values(step * h, v, c.data());
        for (int i = 0; i < n; ++i)
          gamma[i] -= kWeights[std::abs(step)] * c[std::size_t(i)] / (180 * h * h);
      }
    }
  };
};

}  // namespace pantin::detail::joint_kinds
