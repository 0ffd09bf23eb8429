#pragma once
/// Internal (pantin::detail); installed because the kinds of events, which are public, are made of
/// it.
///
/// What a kind of timed event tells of itself. A kind is a struct in a file of its own here, named
/// in the list of timed_event.hpp; steps, scene files and their schema, copies and mirror images
/// of prefabs, hashes and saved Worlds follow:
///
///   static constexpr std::string_view name, about;   // "push", for scene files
///   static void fields(auto& self, auto&& field);    // its data, as of every component
///   static void scene_keys(auto& self, auto&& key);  // what scene files say, see EventKey
///
/// what it acts on, by the name of the member, which is checked and looked up by it:
///
///   Entity body, joint, cable, tie;                  // one of them; none: the whole World
///   std::vector<Entity> bodies;
///
/// its times, by their names too:
///
///   Real from, to, every;                            // s, see TimedEvent
///   Real at, over, every;
///
/// and one of these ways to act:
///
///   void act(const EventStep&, Real part) const;     // in this part of a substep: `from` .. `to`
///   void strike(const EventStep&, Real times) const; // so often in a substep: `at`, `every`
///   void begin(const EventStep&, EventProgress&) const;  // once, at its time
///
/// of which the last may go on, substep by substep: as a change that takes `over`, or until it sets
/// EventProgress::done:
///
///   void change(const EventStep&, EventProgress&, const EventChange&) const;
///   void go_on(const EventStep&, EventProgress&) const;
///
/// Where there is anything to tell,
///
///   std::optional<EventFault> fault() const;         // of numbers beside times and vectors
///   static constexpr EventNeed needs;                // keys of which one at least is given
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

/// The substep to come.
struct EventStep {
  World& world;
  Real from, h;  // s

  Real to() const { return from + h; }
  /// Whether a moment belongs to its start: to no boundary it is nearer.
  bool begins(Real moment) const { return moment < from + h / 2; }
};

/// How much of a change has been made, in [0, 1]. What is held at the end of the substep goes by
/// its end; a force or a speed by its middle.
struct EventChange {
  Real at_end, in_middle;
};

/// A change that begins at a time and takes so long, s.
struct EventRamp {
  Real at, over;
};
/// How much of it has been made, in [0, 1].
inline Real progress_at(const EventRamp& ramp, Real time) {
  return ramp.over == 0 ? 1 : std::clamp((time - ramp.at) / ramp.over, Real(0), Real(1));
}
/// The same that starts and ends at rest.
inline Real eased(Real progress) { return progress * progress * (3 - 2 * progress); }

/// How far an event has come.
struct EventProgress {
  std::uint64_t fired = 0;  // how often it began
  bool done = false;
  Vec3 start{0};    // what was there before: a place, a gravity; the numbers of a motor or drive
  Entity pin = {};  // of the hand

  static void fields(auto& self, auto&& field) {
    field("fired", self.fired);
    field("done", self.done);
    field("start", self.start);
    field("pin", self.pin);
  }
};

/// Of two members that contradict each other or a number that is none: the member, what was found,
/// what was expected.
struct EventFault {
  const char *member, *found, *expected;
};

// ---- What scene files say ----

/// What a scene file gives under a key. Copies and mirror images of prefabs take vectors along by
/// it.
enum class EventForm : std::uint8_t {
  direction,         // of a force
  axial,             // of a torque
  point,             // a place
  anchor,            // in the frame of the body; or under "point" in the scene
  vector,            // which belongs to no copy
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
  references     // names of bodies
};

struct EventKey {
  std::string_view key = {}, unit = {}, about = {};
  EventForm form = EventForm::direction;
  std::string_view needed = {};  // it must be there; what is expected
  std::string_view names = {};   // of a reference: what is expected
  bool tells_default = false;    // what the member is by default
  Real scale = 1;                // of the numbers given
};

/// Keys of which one at least must be given, words between spaces; what to complain of otherwise.
struct EventNeed {
  std::string_view keys, complaint;
};

/// Keys that exclude one another: `one`, and any of `others`, words between spaces.
struct EventPair {
  std::string_view one, others;
};

/// The shortest time after which an event starts again, and from gust to gust, s.
inline constexpr Real kShortestRepeat = 1e-3;
/// The end of what never ends, s.
inline constexpr Real kNever = 1e300;

/// Keys that several kinds have.
namespace event_keys {

inline constexpr EventKey kAt{"at", "s", "When: at the step boundary nearest to it.",
                              EventForm::moment, "a time in seconds"};
inline constexpr EventKey kOver{.key = "over",
                                .unit = "s",
                                .about = "How long the change takes.",
                                .form = EventForm::moment,
                                .tells_default = true};
inline constexpr EventKey kFrom{.key = "from",
                                .unit = "s",
                                .about = "When it begins.",
                                .form = EventForm::moment,
                                .tells_default = true};
inline constexpr EventKey kTo{"to", "s", "When it ends. Default: never.", EventForm::moment};
inline constexpr EventKey kEvery{
    "every", "s", "It starts again so long after it started, again and again. Default: once.",
    EventForm::repeat};
inline constexpr EventKey kBody{"body", "", "A dynamic body.", EventForm::reference,
                                "the name of a body"};
inline constexpr EventKey kAnchor{
    "anchor", "m",
    "Point of the body that it acts on, in the body's own frame. Default: its mass centre.",
    EventForm::anchor};

}  // namespace event_keys

/// The range of numbers that are read from a file and go into a step as they are.
inline bool is_amount(Real x) { return x >= 0 && std::isfinite(x); }

/// Whether forces move a body.
bool can_be_pushed(const World& world, Entity body);
/// Adds a force (N) at a point fixed in a body, and a torque (N m), to what acts in the substep.
struct EventPush {
  Entity body;
  Vec3 anchor, force, torque;
};
void push_on(const EventStep& step, const EventPush& push);

}  // namespace pantin::detail
