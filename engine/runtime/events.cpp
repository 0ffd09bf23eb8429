#include "engine/runtime/events.hpp"

#include <algorithm>
#include <cmath>

#include "engine/runtime/requests.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {
namespace {

/// Fractions of a step below this are rounding: a push that ends on a step boundary must not wake
/// bodies in the following step.
constexpr Real kSliver = 1e-9;

// ---- Instantaneous events ----

/// Whether it is due and has not begun.
bool is_due(const EventStep& step, const TimedEvent& event) {
  if (event.progress.done || event.progress.fired > 0) return false;
  return std::visit(
      [&]<class E>(const E& e) { return !Lasts<E> && !Strikes<E> && step.begins(start_of(e)); },
      event.kind);
}

void begin(const EventStep& step, TimedEvent& event) {
  EventProgress& progress = event.progress;
  progress.fired = 1;
  std::visit(
      [&]<class E>(const E& e) {
        if constexpr (!Lasts<E> && !Strikes<E>) {
          e.begin(step, progress);
          progress.done = progress.done || !(Changes<E> || GoesOn<E>);
        }
      },
      event.kind);
}

/// Begins due events, the earliest first; ties go to the one that was added first.
void begin_due(const EventStep& step, std::span<TimedEvent> events) {
  for (;;) {
    TimedEvent* next = nullptr;
    for (TimedEvent& e : events)
      if (is_due(step, e) && (!next || start_of(e) < start_of(*next))) next = &e;
    if (!next) return;
    begin(step, *next);
  }
}

// ---- Events that continue over time ----

/// Wakes the bodies that a joint or cable connects.
void rouse_ends(World& world, Entity tie) {
  if (const Link* l = world.links.find(tie)) rouse(world, l->a), rouse(world, l->b);
  if (const Cable* c = world.cables.find(tie)) rouse(world, c->a), rouse(world, c->b);
}

void change(const EventStep& step, const Changes auto& e, EventProgress& progress) {
  if (const Entity* tie = target_of(e)) rouse_ends(step.world, *tie);
  const EventRamp ramp{e.at, e.over};
  EventChange made;
  made.at_end = progress_at(ramp, step.to());
  made.in_middle = made.at_end == 1 && step.from >= e.at + e.over
                       ? Real(1)
                       : progress_at(ramp, step.from + step.h / 2);
  e.change(step, progress, made);
  progress.done = made.in_middle == 1;
}

// ---- Forces ----

/// Applies the impulses that are due and have not been applied yet.
void strike(const EventStep& step, const Strikes auto& e, EventProgress& progress) {
  if (!step.begins(e.at)) return;
  Real due = 1;
  if (e.every > 0) due += std::floor((step.from + step.h / 2 - e.at) / e.every);
  const Real left = due - static_cast<Real>(progress.fired);
  progress.done = e.every == 0;
  if (!(left >= 1) || !(due < 1e15)) return;
  progress.fired = static_cast<std::uint64_t>(due);
  e.strike(step, left);
}

/// Applies the event for its fraction of the substep.
void act(const EventStep& step, const Lasts auto& e, EventProgress& progress) {
  progress.done = e.every == 0 && step.from >= e.to;
  if (progress.done) return;
  const Real part = active_time({e.from, e.to, e.every}, step.from, step.to()) / step.h;
  if (part >= kSliver) e.act(step, std::min(part, Real(1)));
}

void go_on(const EventStep& step, TimedEvent& event) {
  EventProgress& progress = event.progress;
  std::visit(
      [&]<class E>(const E& e) {
        if constexpr (Strikes<E>)
          strike(step, e, progress);
        else if constexpr (Lasts<E>)
          act(step, e, progress);
        else if (progress.fired == 0)
          return;
        else if constexpr (Changes<E>)
          change(step, e, progress);
        else if constexpr (GoesOn<E>)
          e.go_on(step, progress);
      },
      event.kind);
}

}  // namespace

void apply_events(World& world, Real h) {
  if (!events_of(std::as_const(world)) || !std::isfinite(world.time)) return;
  const std::span<TimedEvent> events = events_of(world).values();
  const EventStep step{world, world.time, h};
  begin_due(step, events);
  for (TimedEvent& e : events)
    if (!e.progress.done) go_on(step, e);
}

}  // namespace pantin::detail
