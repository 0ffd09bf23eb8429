#pragma once
/// A cut.
#include "engine/world/events/event.hpp"

namespace pantin {

/// A joint, a cable, a pin or a gear is destroyed.
struct CutEvent {
  Entity tie = {};
  Real at = 0;  // s

  static constexpr std::string_view name = "cut";
  static constexpr std::string_view about = "Removes a joint, cable, pin or gear.";
  static constexpr detail::EventNeed needs{
      "joint cable pin gear",
      "found no \"joint\", expected the name of a joint, or a \"cable\", \"pin\" or \"gear\""};
  static constexpr detail::EventPair pairs[] = {
      {"joint", "cable pin gear"}, {"cable", "pin gear"}, {"pin", "gear"}};

  static void fields(auto& self, auto&& field) {
    field("tie", self.tie);
    field("at", self.at);
  }
  static void scene_keys(auto& self, auto&& key) {
    using enum detail::EventForm;
    key({.key = "joint",
         .about = "Name of a joint, or of a chain, an instance or a grid: all of its joints.",
         .form = reference,
         .names = "the name of a joint"},
        self.tie);
    key({.key = "cable",
         .about = "Likewise of a cable.",
         .form = reference,
         .names = "the name of a cable"},
        self.tie);
    key({.key = "pin",
         .about = "Likewise of a pin.",
         .form = reference,
         .names = "the name of a pin"},
        self.tie);
    key({.key = "gear",
         .about = "Likewise of a gear.",
         .form = reference,
         .names = "the name of a gear"},
        self.tie);
    key(detail::event_keys::kAt, self.at);
  }

  void begin(const detail::EventStep& step, detail::EventProgress&) const {
    step.world.destroy(tie);
  }
};

}  // namespace pantin
