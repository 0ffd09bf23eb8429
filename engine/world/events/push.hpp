#pragma once
/// A push: a force that acts for a while.
#include "engine/world/events/event.hpp"

namespace pantin {

/// `force` and `torque` act on a body from `from` to `to`.
struct PushEvent {
  Entity body = {};
  Vec3 force{0};    // N, world axes
  Vec3 torque{0};   // N m, world axes
  Vec3 anchor{0};   // the point, in the body's mass-centre frame
  Real from = 0;    // s
  Real to = 1e300;  // s
  Real every = 0;   // s, the period; 0: once

  static constexpr std::string_view name = "push";
  static constexpr std::string_view about =
      "A force on a body between two times; a fraction of a step in proportion.";
  static constexpr detail::EventNeed needs{"force torque",
                                           "found no \"force\", expected a force or a torque"};

  static void fields(auto& self, auto&& field) {
    field("body", self.body);
    field("force", self.force);
    field("torque", self.torque);
    field("anchor", self.anchor);
    field("from", self.from);
    field("to", self.to);
    field("every", self.every);
  }
  static void scene_keys(auto& self, auto&& key) {
    using namespace detail::event_keys;
    using enum detail::EventForm;
    key(kBody, self.body);
    key({.key = "force", .unit = "N", .about = "In the axes of the scene.", .tells_default = true},
        self.force);
    key({.key = "torque",
         .unit = "N m",
         .about = "Likewise.",
         .form = axial,
         .tells_default = true},
        self.torque);
    key(kAnchor, self.anchor);
    key(kFrom, self.from);
    key(kTo, self.to);
    key(kEvery, self.every);
  }

  void act(const detail::EventStep& step, Real part) const {
    push_on(step, {body, anchor, part * force, part * torque});
  }
};

}  // namespace pantin
