#pragma once
/// Changes a joint drive, such as stronger or weaker muscles.
#include "engine/world/events/event.hpp"

namespace pantin {

/// Sets the stiffness, the damping and the torque limit of a joint drive.
struct DriveEvent {
  Entity joint = {};
  Real stiffness = 0;       // N m/rad
  Real damping = 0;         // N m s/rad
  Real max_torque = 1e300;  // N m
  Real at = 0;              // s
  Real over = 0;            // s, in which they change linearly

  static constexpr std::string_view name = "drive";
  static constexpr std::string_view about =
      "Changes the stiffness, damping or maximum torque of a joint drive.";
  static constexpr detail::EventNeed needs{
      "stiffness damping max_torque",
      "found no \"stiffness\", expected a stiffness, a damping or a maximum torque"};

  static void fields(auto& self, auto&& field) {
    field("joint", self.joint);
    field("stiffness", self.stiffness);
    field("damping", self.damping);
    field("max_torque", self.max_torque);
    field("at", self.at);
    field("over", self.over);
  }
  static void scene_keys(auto& self, auto&& key) {
    using namespace detail::event_keys;
    using enum detail::EventForm;
    key({"joint", "", "Name of a joint with a drive, or of a group of them.", reference,
         "the name of a joint"},
        self.joint);
    key({"stiffness", "N m/rad", "Of its spring. Default: unchanged.", not_negative},
        self.stiffness);
    key({"damping", "N m s/rad", "Of its damper. Default: unchanged.", not_negative}, self.damping);
    key({"max_torque", "N m", "Maximum torque; 0 disables it. Default: unchanged.", not_negative},
        self.max_torque);
    key(kAt, self.at);
    key(kOver, self.over);
  }

  void begin(const detail::EventStep& step, detail::EventProgress& progress) const {
    if (const JointDrive* d = step.world.joint_drives.find(joint))
      progress.start = {d->stiffness, d->damping, d->max_torque};
  }
  void change(const detail::EventStep& step, detail::EventProgress& progress,
              const detail::EventChange& made) const {
    JointDrive* d = step.world.joint_drives.find(joint);
    if (!d) return;
    const Vec3& start = progress.start;
    d->stiffness = std::lerp(start.x, stiffness, made.in_middle);
    d->damping = std::lerp(start.y, damping, made.in_middle);
    d->max_torque = std::lerp(start.z, max_torque, made.in_middle);
  }
  std::optional<detail::EventFault> fault() const {
    constexpr detail::EventFault kFault{"stiffness", "a number that is not finite or below 0",
                                        "numbers from 0 on"};
    using detail::is_amount;
    return is_amount(stiffness) && is_amount(damping) && is_amount(max_torque)
               ? std::nullopt
               : std::optional(kFault);
  }
};

}  // namespace pantin
