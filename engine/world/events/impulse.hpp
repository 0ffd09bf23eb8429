#pragma once
/// An impulse.
#include "engine/world/events/event.hpp"

namespace pantin {

/// `impulse` and `angular_impulse` act on a body at one moment.
struct ImpulseEvent {
  Entity body = {};
  Vec3 impulse{0};          // N s, world axes
  Vec3 angular_impulse{0};  // N m s, world axes
  Vec3 anchor{0};           // the point, in the body's mass-centre frame
  Real at = 0;              // s
  Real every = 0;           // s, the period; 0: once

  static constexpr std::string_view name = "impulse";
  static constexpr std::string_view about = "An impulse at one instant.";
  static constexpr detail::EventNeed needs{
      "impulse angular_impulse", "found no \"impulse\", expected an impulse or an angular impulse"};

  static void fields(auto& self, auto&& field) {
    field("body", self.body);
    field("impulse", self.impulse);
    field("angular_impulse", self.angular_impulse);
    field("anchor", self.anchor);
    field("at", self.at);
    field("every", self.every);
  }
  static void scene_keys(auto& self, auto&& key) {
    using namespace detail::event_keys;
    using enum detail::EventForm;
    key(kBody, self.body);
    key({.key = "impulse",
         .unit = "N s",
         .about = "Mass times the change of velocity, in the axes of the scene.",
         .tells_default = true},
        self.impulse);
    key({.key = "angular_impulse",
         .unit = "N m s",
         .about = "Likewise.",
         .form = axial,
         .tells_default = true},
        self.angular_impulse);
    key(kAnchor, self.anchor);
    key(kAt, self.at);
    key(kEvery, self.every);
  }

  /// An impulse is a force that lasts one substep.
  void strike(const detail::EventStep& step, Real times) const {
    push_on(step, {body, anchor, times / step.h * impulse, times / step.h * angular_impulse});
  }
};

}  // namespace pantin
