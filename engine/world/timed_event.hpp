#pragma once
/// THE list of the kinds of timed events: changes to a World at one moment or over an interval
/// while it runs. A new kind is a file in engine/world/events, included here, and a word in the
/// list: steps, builders, scene files and their schema follow from the file.
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/world/events/cut.hpp"
#include "engine/world/events/drive.hpp"
#include "engine/world/events/gravity.hpp"
#include "engine/world/events/impulse.hpp"
#include "engine/world/events/motor.hpp"
#include "engine/world/events/pull.hpp"
#include "engine/world/events/push.hpp"
#include "engine/world/events/solver.hpp"
#include "engine/world/events/winch.hpp"
#include "engine/world/events/wind.hpp"
#include "engine/world/store.hpp"

#define PANTIN_EVENT_KINDS(KIND) \
  KIND(PushEvent)                \
  KIND(ImpulseEvent)             \
  KIND(WindEvent)                \
  KIND(PullEvent)                \
  KIND(CutEvent)                 \
  KIND(MotorEvent)               \
  KIND(DriveEvent)               \
  KIND(WinchEvent)               \
  KIND(GravityEvent)             \
  KIND(SolverEvent)

namespace pantin {
namespace detail {

template <class None, class... Kinds>
struct EventList {
  using Variant = std::variant<Kinds...>;
  static constexpr std::string_view names[] = {Kinds::name...};
  template <class T>
  static constexpr bool has = (std::is_same_v<T, Kinds> || ...);
};
#define PANTIN_NEXT(kind) , kind
using AllEvents = EventList<void PANTIN_EVENT_KINDS(PANTIN_NEXT)>;
#undef PANTIN_NEXT
using EventKinds = AllEvents::Variant;

/// The words of scene files, by kind.
inline constexpr const auto& kEventNames = AllEvents::names;

template <class T>
concept EventKind = AllEvents::has<T>;

}  // namespace detail

/// One event of a World: `world.add(PushEvent{...})`. The step carries it out, and the World stores
/// its progress: a copy or a saved World continues bit for bit. `world.destroy(event)` cancels it.
///
/// A lasting event acts from `from` to `to`; on a part of a step it acts in proportion, so that its
/// impulse does not depend on the step. An instantaneous event happens at the substep boundary
/// nearest to `at`. With `over` the change takes that long: a pull and a winch start and stop
/// smoothly, numbers change linearly. At one boundary the earlier event comes first; ties go to the
/// one that was added first.
struct TimedEvent {
  detail::EventKinds kind;
  detail::EventProgress progress = {};

  static constexpr std::string_view name = "timed event";  // in saved Worlds

  static void fields(auto& self, auto&& field) {
    field("kind", self.kind);
    field("progress", self.progress);
  }
  /// Checks a saved event; returns null, or the fault.
  const char* restored() const;
};

namespace detail {

/// Whether it acts throughout an interval; otherwise it begins at one time.
template <class E>
concept Lasts = requires(const E& e, const EventStep& step) {
  e.act(step, Real(1));
};
/// Whether it is an impulse, or several.
template <class E>
concept Strikes = requires(const E& e, const EventStep& step) {
  e.strike(step, Real(1));
};
/// Whether it changes an existing value over a time.
template <class E>
concept Changes = requires(const E& e, const EventStep& step, EventProgress& progress) {
  e.change(step, progress, EventChange{});
};
/// Whether it continues until it sets `done`.
template <class E>
concept GoesOn = requires(const E& e, const EventStep& step, EventProgress& progress) {
  e.go_on(step, progress);
};

/// The entity it acts on; null: the whole World, or a list of bodies.
template <class E>
auto* target_of(E& event) {
  if constexpr (requires { event.body; })
    return &event.body;
  else if constexpr (requires { event.joint; })
    return &event.joint;
  else if constexpr (requires { event.cable; })
    return &event.cable;
  else if constexpr (requires { event.tie; })
    return &event.tie;
  else
    return static_cast<Entity*>(nullptr);
}
template <class E>
inline constexpr bool kHasTarget = requires(E& e) {
  e.body;
}
|| requires(E& e) { e.joint; }
|| requires(E& e) { e.cable; }
|| requires(E& e) { e.tie; };

/// Its start time, s.
template <class E>
Real start_of(const E& event) {
  if constexpr (requires { event.at; })
    return event.at;
  else
    return event.from;
}
Real start_of(const TimedEvent& event);
/// The name of its kind.
std::string_view name_of(const TimedEvent& event);

/// Calls `see(key, member)` for each of its keys in scene files.
void each_event_key(auto& event, auto&& see) {
  std::visit([&](auto& kind) { kind.scene_keys(kind, see); }, event.kind);
}

/// The first invalid member, or none. Checks only what needs no World.
std::optional<EventFault> fault_of(const TimedEvent& event);

/// All events of a World, in the order they were added.
Store<TimedEvent>& events_of(World& world);
const Store<TimedEvent>* events_of(const World& world);

/// Adds an event that was checked. The steps in which it acts allocate nothing, unless it changes
/// the structure.
Entity add_event(World& world, const TimedEvent& event);

/// The time within `from` .. `to` (s) during which a lasting event acts.
struct EventTimes {
  Real from, to, every;
};
Real active_time(const EventTimes& event, Real from, Real to);

}  // namespace detail
}  // namespace pantin
