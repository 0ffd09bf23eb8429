#include "engine/world/timed_event.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/check.hpp"
#include "engine/world/world.hpp"

namespace pantin {

using namespace detail;

namespace {

constexpr EventFault kFaults[] = {
    {"from", "a number that is not finite or below 0", "a time from 0 on, in s"},
    {"at", "a number that is not finite or below 0", "a time from 0 on, in s"},
    {"to", "a time before \"from\"", "a later one"},
    {"every", "a time below 1e-3 s that is not 0", "0, or 1e-3 s or more"},
    {"every", "a time shorter than from \"from\" to \"to\"", "at least as long a time"},
    {"over", "a number that is not finite or below 0", "a time from 0 s on"}};

template <class E>
std::optional<EventFault> fault_of_times(const E& e) {
  if (!is_amount(start_of(e))) return kFaults[requires { e.at; }];
  if constexpr (requires { e.to; })
    if (!(e.to >= e.from)) return kFaults[2];
  if constexpr (requires { e.every; }) {
    if (!(e.every == 0 || (e.every >= kShortestRepeat && std::isfinite(e.every))))
      return kFaults[3];
    if constexpr (Lasts<E>)
      if (e.every > 0 && !(e.to - e.from <= e.every)) return kFaults[4];
  }
  if constexpr (requires { e.over; })
    if (!is_amount(e.over)) return kFaults[5];
  return std::nullopt;
}

/// The first vector member with a number that is not finite.
template <class E>
std::optional<EventFault> fault_of_vectors(const E& e) {
  std::optional<EventFault> fault;
  E::fields(e, [&]<class T>(const char* name, const T& member) {
    if constexpr (std::is_same_v<T, Vec3>)
      if (!fault && !is_finite(member))
        fault = {name, "a number that is not finite", "finite numbers"};
  });
  return fault;
}

}  // namespace

const char* TimedEvent::restored() const {
  return fault_of(*this) || !is_finite(progress.start)
             ? "is an event with a number that is not finite or out of range"
             : nullptr;
}

namespace detail {

Real start_of(const TimedEvent& event) {
  return std::visit([](const auto& e) { return start_of(e); }, event.kind);
}

std::string_view name_of(const TimedEvent& event) { return kEventNames[event.kind.index()]; }

std::optional<EventFault> fault_of(const TimedEvent& event) {
  return std::visit(
      [](const auto& e) -> std::optional<EventFault> {
        if (const auto fault = fault_of_times(e)) return fault;
        if (const auto fault = fault_of_vectors(e)) return fault;
        if constexpr (requires { e.fault(); })
          return e.fault();
        else
          return std::nullopt;
      },
      event.kind);
}

Store<TimedEvent>& events_of(World& world) { return world.user.of<TimedEvent>(); }
const Store<TimedEvent>* events_of(const World& world) { return world.user.find<TimedEvent>(); }

bool can_be_pushed(const World& world, Entity body) {
  const Body* b = world.bodies.find(body);
  return b && b->motion == Motion::dynamic;
}

void push_on(const EventStep& step, const EventPush& push) {
  World& world = step.world;
  if (!can_be_pushed(world, push.body)) return;
  world.push(push.body, push.force, to_world(world.bodies[push.body].pose, push.anchor));
  world.forces[push.body].torque += push.torque;
}

namespace {

/// Bodies on which forces act get their Force component here, because steps allocate nothing.
template <class E>
void expect_forces(World& world, const E& event) {
  if constexpr (Lasts<E> || Strikes<E>) {
    const auto expect = [&](Entity body) {
      if (can_be_pushed(world, body) && !world.forces.find(body)) world.forces.add(body, {});
    };
    if constexpr (requires { event.body; }) expect(event.body);
    if constexpr (requires { event.bodies; }) {
      for (const Entity e : event.bodies) expect(e);
      if (event.bodies.empty())
        for (const Entity e : world.bodies.owners()) expect(e);
    }
  }
}

}  // namespace

Entity add_event(World& world, const TimedEvent& event) {
  std::visit([&](const auto& kind) { expect_forces(world, kind); }, event.kind);
  const Entity e = world.create();
  events_of(world).add(e, event);
  return e;
}

Real active_time(const EventTimes& e, Real from, Real to) {
  if (e.every == 0) return std::max(Real(0), std::min(to, e.to) - std::max(from, e.from));
  const Real length = e.to - e.from;
  const auto until = [&](Real time) {  // active time from the first start to `time`
    if (!(time > e.from)) return Real(0);
    const Real whole = std::floor((time - e.from) / e.every);
    return whole * length + std::min(length, time - e.from - whole * e.every);
  };
  return until(to) - until(from);
}

}  // namespace detail
}  // namespace pantin
