#pragma once
/// Changes a joint drive, such as stronger or weaker muscles.
#include "engine/world/events/event.hpp"

namespace pantin {

/// Sets the stiffness, the damping and the torque limit of a joint drive, or the motion of an exact
/// one. NaN: as before. A motion alone leaves the torque limit, too.
struct DriveEvent {
  Entity joint = {};
  std::optional<DriveMotion> motion = {};  // of an exact drive; its time counts from the event
  Real stiffness = 0;                      // N m/rad
  Real damping = 0;                        // N m s/rad
  Real max_torque = 1e300;                 // N m; N along a travel
  Real at = 0;                             // s
  Real over = 0;                           // s, in which they change linearly

  static constexpr std::string_view name = "drive";
  static constexpr std::string_view about =
      "Changes the stiffness, damping, maximum torque or exact motion of a joint drive.";
  static constexpr detail::EventNeed needs{
      "stiffness damping max_torque motion",
      "found no \"stiffness\", expected a stiffness, a damping, a maximum torque or a motion"};
  static constexpr detail::EventPair pairs[] = {{"motion", "stiffness damping over"}};

  static void fields(auto& self, auto&& field) {
    field("joint", self.joint);
    field("motion", self.motion);
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
    key({.key = "motion",
         .about = "Of an exact drive. Its time 0 is that of the event. Default: unchanged.",
         .form = motion},
        self.motion);
    key({"max_torque", "N m", "Maximum torque; 0 disables it. Default: unchanged.", not_negative},
        self.max_torque);
    key(kAt, self.at);
    key(kOver, self.over);
  }

  void begin(const detail::EventStep& step, detail::EventProgress& progress) const;
  void change(const detail::EventStep& step, detail::EventProgress& progress,
              const detail::EventChange& made) const;
  std::optional<detail::EventFault> fault() const;
};

}  // namespace pantin
