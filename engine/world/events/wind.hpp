#pragma once
/// Wind.
#include "engine/world/events/event.hpp"

namespace pantin {

/// From `from` to `to` the air moves with `velocity`; dynamic bodies follow by their drag.
struct WindEvent {
  Vec3 velocity{0};                 // m/s
  Vec3 gusts{0};                    // m/s, the largest change by gusts along each axis
  Real gust_time = 1;               // s, from one gust to the next
  std::uint64_t seed = 1;           // of the gusts; equal seeds give equal gusts, whatever the step
  Real drag = -1;                   // 1/s, besides the body's own drag; below 0: the body's own
                                    // drag acts
  std::vector<Entity> bodies = {};  // the bodies it acts on; none: all
  Real from = 0;                    // s
  Real to = 1e300;                  // s
  Real every = 0;                   // s, the period; 0: once

  static constexpr std::string_view name = "wind";
  static constexpr std::string_view about = "Wind that acts on bodies by their drag.";
  static constexpr detail::EventNeed needs{
      "velocity gusts", "found no \"velocity\", expected the velocity of the air, or \"gusts\""};

  static void fields(auto& self, auto&& field) {
    field("velocity", self.velocity);
    field("gusts", self.gusts);
    field("gust_time", self.gust_time);
    field("seed", self.seed);
    field("drag", self.drag);
    field("bodies", self.bodies);
    field("from", self.from);
    field("to", self.to);
    field("every", self.every);
  }
  static void scene_keys(auto& self, auto&& key) {
    using namespace detail::event_keys;
    using enum detail::EventForm;
    key({.key = "velocity",
         .unit = "m/s",
         .about = "Velocity of the air.",
         .form = vector,
         .tells_default = true},
        self.velocity);
    key({.key = "gusts",
         .unit = "m/s",
         .about = "Maximum velocity change by gusts, along all axes or along each.",
         .form = vector_or_number,
         .tells_default = true},
        self.gusts);
    key({.key = "gust_time",
         .unit = "s",
         .about = "Time from one gust to the next.",
         .form = repeat,
         .tells_default = true},
        self.gust_time);
    key({.key = "seed",
         .about = "Of the gusts: the same seed gives the same gusts, at any step length.",
         .form = whole,
         .tells_default = true},
        self.seed);
    key({"drag", "1/s",
         "Rate at which bodies approach the velocity of the air, beside their own drag. Default: "
         "their own drag only; bodies without drag are not affected.",
         not_negative},
        self.drag);
    key({"bodies", "",
         "Names of bodies, or of chains, instances and grids: all their bodies. Default: every "
         "body.",
         references},
        self.bodies);
    key(kFrom, self.from);
    key(kTo, self.to);
    key(kEvery, self.every);
  }

  void act(const detail::EventStep& step, Real part) const;
  std::optional<detail::EventFault> fault() const;
};

namespace detail {

/// Mean over a time interval of smooth value noise: it passes from one random number in [-1, 1] to
/// the next. The numbers follow from `seed`, `axis` and their index.
struct Noise {
  std::uint64_t seed, axis;
  Real period;  // s
};
Real mean_of(const Noise& noise, Real from, Real to);

}  // namespace detail
}  // namespace pantin
