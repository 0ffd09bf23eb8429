#pragma once
/// Internal (pantin::detail); installed because the public kinds of events are built on it.
///
/// The interface of a kind of timed event. A kind is a struct in a file of its own here, named in
/// the list of timed_event.hpp. Steps, scene files and their schema, copies and mirror images of
/// prefabs, hashes and saved Worlds follow from it:
///
///   static constexpr std::string_view name, about;   // "push", for scene files
///   static void fields(auto& self, auto&& field);    // its data, as of every component
///   static void scene_keys(auto& self, auto&& key);  // its keys in scene files, see EventKey
///
/// its targets, which are recognised, checked and looked up by these member names:
///
///   Entity body, joint, cable, tie;                  // one of them; none: the whole World
///   std::vector<Entity> bodies;
///
/// its times, recognised by name as well:
///
///   Real from, to, every;                            // s, see TimedEvent
///   Real at, over, every;
///
/// and one of these ways to act:
///
///   void act(const EventStep&, Real part) const;     // for a part of a substep: `from` .. `to`
///   void strike(const EventStep&, Real times) const; // this often in a substep: `at`, `every`
///   void begin(const EventStep&, EventProgress&) const;  // once, at its time
///
/// An event with `begin` may continue in later substeps, as a change that takes `over`, or until it
/// sets EventProgress::done:
///
///   void change(const EventStep&, EventProgress&, const EventChange&) const;
///   void go_on(const EventStep&, EventProgress&) const;
///
/// Optional:
///
///   std::optional<EventFault> fault() const;         // of numbers other than times and vectors
///   static constexpr EventNeed needs;                // keys of which at least one is given
///   static constexpr EventPair pairs[];              // keys that exclude one another
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

/// The next substep.
struct EventStep {
  World& world;
  Real from, h;  // s

  Real to() const { return from + h; }
  /// Whether a moment is nearest to the start of this substep, or earlier.
  bool begins(Real moment) const { return moment < from + h / 2; }
};

/// The fraction of a change that has been made, in [0, 1]. A position or length takes the value at
/// the end of the substep; a force or a speed takes that at its middle.
struct EventChange {
  Real at_end, in_middle;
};

/// A change that begins at a time and has a duration, s.
struct EventRamp {
  Real at, over;
};
/// The fraction of it that has been made, in [0, 1].
inline Real progress_at(const EventRamp& ramp, Real time) {
  return ramp.over == 0 ? 1 : std::clamp((time - ramp.at) / ramp.over, Real(0), Real(1));
}
/// The same fraction, eased so that the change starts and ends at rest.
inline Real eased(Real progress) { return progress * progress * (3 - 2 * progress); }
/// Its derivative by the progress.
inline Real eased_slope(Real progress) { return 6 * progress * (1 - progress); }

/// The progress of an event.
struct EventProgress {
  std::uint64_t fired = 0;  // how many times it has begun
  bool done = false;
  Vec3 start{0};    // before the change: a position, a gravity; the numbers of a motor or drive
  Entity pin = {};  // the pin of a PullEvent

  static void fields(auto& self, auto&& field) {
    field("fired", self.fired);
    field("done", self.done);
    field("start", self.start);
    field("pin", self.pin);
  }
};

/// Two contradictory members or an invalid number: the member, what was found, what was expected.
struct EventFault {
  const char *member, *found, *expected;
};

// ---- What scene files say ----

/// The type of the value under a key of a scene file. Copies and mirror images of prefabs transform
/// vectors by it.
enum class EventForm : std::uint8_t {
  direction,         // of a force
  axial,             // of a torque
  point,             // a place
  anchor,            // in the frame of the body; or under "point" in the scene
  vector,            // not transformed with copies
  vector_or_number,  // likewise
  number,
  degrees,       // at most 1e6
  not_negative,  // a number from 0 on
  positive,      // a number above 0
  size,          // m
  moment,        // s, from 0 on
  repeat,        // s, from kShortestRepeat on
  whole,         // up to 1e9
  solver,        // its name
  reference,     // the name of what it acts on, of a group as well
  references,    // names of bodies
  motion         // of an exact drive
};

struct EventKey {
  std::string_view key = {}, unit = {}, about = {};
  EventForm form = EventForm::direction;
  std::string_view needed = {};  // the key is required; what is expected
  std::string_view names = {};   // of a reference: what is expected
  bool tells_default = false;    // the schema states the default of the member
  Real scale = 1;                // factor from the number in the file to the member
};

/// Keys, separated by spaces, of which at least one must be given; and the error text if none is.
struct EventNeed {
  std::string_view keys, complaint;
};

/// Keys that exclude one another: `one`, and any of `others`, separated by spaces.
struct EventPair {
  std::string_view one, others;
};

/// The shortest period of a repeated event, and between gusts, s.
inline constexpr Real kShortestRepeat = 1e-3;
/// The end time of an event that never ends, s.
inline constexpr Real kNever = 1e300;

/// Keys that several kinds share.
namespace event_keys {

inline constexpr EventKey kAt{"at", "s", "Time, rounded to the nearest step boundary.",
                              EventForm::moment, "a time in seconds"};
inline constexpr EventKey kOver{.key = "over",
                                .unit = "s",
                                .about = "Duration of the change.",
                                .form = EventForm::moment,
                                .tells_default = true};
inline constexpr EventKey kFrom{.key = "from",
                                .unit = "s",
                                .about = "Start time.",
                                .form = EventForm::moment,
                                .tells_default = true};
inline constexpr EventKey kTo{"to", "s", "End time. Default: never.", EventForm::moment};
inline constexpr EventKey kEvery{"every", "s", "Period after which it starts again. Default: once.",
                                 EventForm::repeat};
inline constexpr EventKey kBody{"body", "", "A dynamic body.", EventForm::reference,
                                "the name of a body"};
inline constexpr EventKey kAnchor{
    "anchor", "m",
    "Point of the body that it acts on, in the body's own frame. Default: its mass centre.",
    EventForm::anchor};

}  // namespace event_keys

/// Whether a number from a file is finite and not negative, so that a step can use it.
inline bool is_amount(Real x) { return x >= 0 && std::isfinite(x); }

/// Whether a body responds to forces.
bool can_be_pushed(const World& world, Entity body);
/// Adds a force (N) at a body-fixed point and a torque (N m) to those of this substep.
struct EventPush {
  Entity body;
  Vec3 anchor, force, torque;
};
void push_on(const EventStep& step, const EventPush& push);

}  // namespace pantin::detail
