#pragma once
/// A winch.
#include "engine/world/events/event.hpp"

namespace pantin {

/// Changes the length of a cable, from rest to rest.
struct WinchEvent {
  Entity cable = {};
  Real length = 1;  // m
  Real at = 0;      // s
  Real over = 0;    // s

  static constexpr std::string_view name = "winch";
  static constexpr std::string_view about = "Winds a cable in or out.";

  static void fields(auto& self, auto&& field) {
    field("cable", self.cable);
    field("length", self.length);
    field("at", self.at);
    field("over", self.over);
  }
  static void scene_keys(auto& self, auto&& key) {
    using namespace detail::event_keys;
    using enum detail::EventForm;
    key({"cable", "", "Name of a cable, or of a group of them.", reference, "the name of a cable"},
        self.cable);
    key({"length", "m", "Its length afterwards.", size, "a size from 1e-9 to 1e9 m"}, self.length);
    key(kAt, self.at);
    key({.key = "over",
         .unit = "s",
         .about = "Duration, from rest to rest.",
         .form = moment,
         .tells_default = true},
        self.over);
  }

  void begin(const detail::EventStep& step, detail::EventProgress& progress) const {
    if (const detail::Cable* c = step.world.cables.find(cable)) progress.start.x = c->joint.length;
  }
  void change(const detail::EventStep& step, detail::EventProgress& progress,
              const detail::EventChange& made) const {
    detail::Cable* c = step.world.cables.find(cable);
    if (!c) return;
    c->joint.length = std::lerp(progress.start.x, length, detail::eased(made.at_end));
    c->joint.rate =
        over > 0 ? (length - progress.start.x) * detail::eased_slope(made.at_end) / over : 0;
  }
  std::optional<detail::EventFault> fault() const {
    constexpr detail::EventFault kFault{"length", "a number that is not above 0",
                                        "a finite length above 0, in m"};
    return length > 0 && std::isfinite(length) ? std::nullopt : std::optional(kFault);
  }
};

}  // namespace pantin
