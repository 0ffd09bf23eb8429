#pragma once
/// Timed events: what is done to a World while it runs.
///
///   world.add(PushEvent{.body = chest, .force = {1200, 0, 0}, .to = 0.3});
///
/// pushes for the first 0.3 s. Scene files have the same under "events". The steps make them
/// happen; they belong to the World, are copied and saved with it.
#include <pantin/world.hpp>

#include "engine/world/timed_event.hpp"

namespace pantin {

/// Adds an event; an error, and the World as it was, if it is about something else than its kind
/// acts on, if its numbers cannot be meant, or if the solver does not know what it asks for.
Result<Entity> add_to(World& world, const TimedEvent& event);

/// The same of one kind: PushEvent, ImpulseEvent, WindEvent, PullEvent, CutEvent, MotorEvent,
/// DriveEvent, WinchEvent, GravityEvent, SolverEvent.
Result<Entity> add_to(World& world, const detail::EventKind auto& event) {
  return add_to(world, TimedEvent{event});
}

}  // namespace pantin
