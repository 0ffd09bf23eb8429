#pragma once
/// A path at constant velocity and angular velocity.
#include "engine/base/fields.hpp"
#include "engine/world/paths/path.hpp"

namespace pantin {

/// A steady motion: rotation at a constant rate about a centre, which moves at constant velocity.
///
///   R(t) = exp(w t),  position(t) = c + v t + R(t) arm,  rotation(t) = R(t) q_0
///
/// `arm`, `velocity` and `angular_velocity` are along `axes`.
struct SteadyMotion {
  Pose centre;               // at time 0; the rotation is q_0, the body's
  Vec3 arm{0};               // m, from the centre to the body, at time 0
  Vec3 velocity{0};          // m/s, of the centre
  Vec3 angular_velocity{0};  // rad/s
  Quat axes{1, 0, 0, 0};     // from the path's axes to world axes

  static constexpr std::string_view name = "steady";
  static constexpr std::string_view about =
      "A constant velocity, and rotation at a constant rate about a centre.";
  static constexpr bool turns_smoothly = true;

  static void fields(auto& self, auto&& field) {
    field("centre", self.centre);
    field("arm", self.arm);
    field("velocity", self.velocity);
    field("angular_velocity", self.angular_velocity);
    field("axes", self.axes);
  }
  static void scene_keys(auto& self, auto&& key) {
    self.centre.position = self.arm = Vec3(detail::kLeftOpen);
    key({"centre", "m", "A point of the axis of rotation at time 0. Default: the body's origin."},
        self.centre.position);
    key({"velocity", "m/s", "Of the centre. Default 0."}, self.velocity);
    key({"angular_velocity", "rad/s", "Its direction is the axis. Default 0."},
        self.angular_velocity);
  }

  Pose at(Real time) const;
  void move(const Pose& by);
  void shift(Real ahead);
  void start_from(const Pose& start);
  detail::PathBounds bounds() const;

 private:
  /// R(t), world axes.
  Quat turn(Real time) const;
};

}  // namespace pantin
