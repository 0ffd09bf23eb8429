#pragma once
/// Changes gravity.
#include "engine/world/events/event.hpp"

namespace pantin {

/// Sets the gravity of the World.
struct GravityEvent {
  Vec3 gravity{0, -9.81, 0};  // m/s^2
  Real at = 0;                // s
  Real over = 0;              // s, in which it changes linearly

  static constexpr std::string_view name = "gravity";
  static constexpr std::string_view about = "Changes gravity.";

  static void fields(auto& self, auto&& field) {
    field("gravity", self.gravity);
    field("at", self.at);
    field("over", self.over);
  }
  static void scene_keys(auto& self, auto&& key) {
    key({"gravity", "m/s^2", "Acceleration of gravity from then on.", detail::EventForm::vector,
         "an acceleration in m/s^2"},
        self.gravity);
    key(detail::event_keys::kAt, self.at);
    key(detail::event_keys::kOver, self.over);
  }

  void begin(const detail::EventStep& step, detail::EventProgress& progress) const {
    progress.start = step.world.gravity;
  }
  void change(const detail::EventStep& step, detail::EventProgress& progress,
              const detail::EventChange& made) const {
    step.world.gravity = progress.start + made.in_middle * (gravity - progress.start);
    if (made.in_middle == 1) step.world.gravity = gravity;
  }
};

}  // namespace pantin
