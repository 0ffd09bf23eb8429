#pragma once
/// Changes a motor.
#include "engine/world/events/event.hpp"

namespace pantin {

/// Sets the motor of a joint.
struct MotorEvent {
  Entity joint = {};
  JointMotor motor = {};  // along the joint's angle, or its travel if it has no angle; without a
                          // gain: that of the motor of this kind before, or one is chosen
  Real at = 0;            // s
  Real over = 0;          // s, in which the target changes linearly

  static constexpr std::string_view name = "motor";
  static constexpr std::string_view about = "Changes the target velocity or position of a motor.";
  static constexpr detail::EventNeed needs{
      "velocity velocity_deg position position_deg gain damping cap",
      "found no \"velocity\", expected a target rate, or a target \"position\""};
  static constexpr detail::EventPair pairs[] = {{"velocity", "position position_deg"},
                                                {"velocity_deg", "position position_deg"}};

  static void fields(auto& self, auto&& field) {
    field("joint", self.joint);
    field("motor", self.motor);
    field("at", self.at);
    field("over", self.over);
  }
  static void scene_keys(auto& self, auto&& key) {
    using namespace detail::event_keys;
    using enum detail::EventForm;
    constexpr Real kDegree = kPi / 180;
    auto& m = self.motor;
    key({"joint", "", "Name of a joint with a motor, or of a group of them.", reference,
         "the name of a joint"},
        self.joint);
    key({"velocity", "rad/s", "Target rate from then on; m/s for a translation.", number},
        m.target);
    key({.key = "velocity_deg",
         .unit = "degrees/s",
         .about = "The same for an angle.",
         .form = degrees,
         .scale = kDegree},
        m.target);
    key({"position", "rad", "Target coordinate; m for a translation.", number}, m.target);
    key({.key = "position_deg",
         .unit = "degrees",
         .about = "The same for an angle.",
         .form = degrees,
         .scale = kDegree},
        m.target);
    key({"gain", "", "As for a motor. Default: unchanged.", positive}, m.gain);
    key({"damping", "N m s/rad", "As for a motor. Default: unchanged.", not_negative}, m.damping);
    key({"cap", "N m", "Maximum torque; 0 disables it. Default: unchanged.", not_negative}, m.cap);
    key(kAt, self.at);
    key(kOver, self.over);
  }

  void begin(const detail::EventStep& step, detail::EventProgress& progress) const;
  void change(const detail::EventStep& step, detail::EventProgress& progress,
              const detail::EventChange& made) const;
  std::optional<detail::EventFault> fault() const;
};

}  // namespace pantin
