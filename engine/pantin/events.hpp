#pragma once
/// Timed events: changes to a World while it runs.
///
///   world.add(PushEvent{.body = chest, .force = {1200, 0, 0}, .to = 0.3});
///
/// pushes during the first 0.3 s. Scene files have them under "events". The steps carry them out.
/// They belong to the World and are copied and saved with it.
#include <pantin/world.hpp>

#include "engine/world/timed_event.hpp"

namespace pantin {

/// Adds an event. An error, with the World unchanged, if its target has the wrong type, a number is
/// invalid, or the solver does not support it.
Result<Entity> add_to(World& world, const TimedEvent& event);

/// The same of one kind: PushEvent, ImpulseEvent, WindEvent, PullEvent, CutEvent, MotorEvent,
/// DriveEvent, WinchEvent, GravityEvent, SolverEvent.
Result<Entity> add_to(World& world, const detail::EventKind auto& event) {
  return add_to(world, TimedEvent{event});
}

}  // namespace pantin
