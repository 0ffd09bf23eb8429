#pragma once
/// Pulls a point of a body to a target.
#include "engine/world/events/event.hpp"

namespace pantin {

/// From `from` on a point of a body is pulled to `target` within `over`, from rest to rest, and
/// released at `to`. Joints stay closed: the point gets as near as joints and pins allow.
struct PullEvent {
  Entity body = {};
  Vec3 anchor{0};      // the point, in the body's mass-centre frame
  Vec3 target{0};      // m
  Real stiffness = 0;  // N/m, of a compliant pull; 0: exact
  Real damping = 0;    // N s/m, likewise
  Real from = 0;       // s
  Real to = 1e300;     // s
  Real over = 0;       // s

  static constexpr std::string_view name = "pull";
  static constexpr std::string_view about = "Pulls a point of a body to a target and releases it.";
  /// The default anchor in a scene file is the origin of the body's frame, not its mass centre.
  static constexpr bool anchors_at_origin = true;

  static void fields(auto& self, auto&& field) {
    field("body", self.body);
    field("anchor", self.anchor);
    field("target", self.target);
    field("stiffness", self.stiffness);
    field("damping", self.damping);
    field("from", self.from);
    field("to", self.to);
    field("over", self.over);
  }
  static void scene_keys(auto& self, auto&& key) {
    using namespace detail::event_keys;
    using enum detail::EventForm;
    key(kBody, self.body);
    key({"anchor", "m", "The pulled point, in the body's own frame. Default: its origin.",
         detail::EventForm::anchor},
        self.anchor);
    key({"target", "m", "Target of the point.", point, "the target of the point"}, self.target);
    key({.key = "stiffness",
         .unit = "N/m",
         .about = "Of a compliant pull by a spring; 0: it reaches the target exactly.",
         .form = not_negative,
         .tells_default = true},
        self.stiffness);
    key({.key = "damping",
         .unit = "N s/m",
         .about = "Of that spring's damper.",
         .form = not_negative,
         .tells_default = true},
        self.damping);
    key(kFrom, self.from);
    key({"to", "s", "Time of release. Default: never.", moment}, self.to);
    key({"over", "s",
         "Duration of the motion, from rest to rest. Default: until the release, or 1.", moment},
        self.over);
  }

  void begin(const detail::EventStep& step, detail::EventProgress& progress) const;
  void go_on(const detail::EventStep& step, detail::EventProgress& progress) const;
  std::optional<detail::EventFault> fault() const;
};

}  // namespace pantin
