#include "engine/world/timed_event.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/check.hpp"
#include "engine/world/world.hpp"

namespace pantin {

using namespace detail;

namespace {

using enum TimedEventKind;

constexpr TimedEventFault kFaults[] = {
    {"from", "a number that is none or below 0", "a time from 0 on, in s"},
    {"to", "a time before \"from\"", "a later one"},
    {"every", "a time below 1e-3 s that is not 0", "0, or 1e-3 s or more"},
    {"every", "a time shorter than from \"from\" to \"to\"", "at least as long a time"},
    {"over", "a number that is none or below 0", "a time from 0 s on"},
    {"gust_time", "a time below 1e-3 s", "1e-3 s or more"},
    {"force", "a number that is not finite", "finite numbers"},
    {"stiffness", "a number that is none or below 0", "numbers from 0 on"},
    {"motor", "a number that is none or below 0", "finite numbers, from 0 on but for the target"},
    {"length", "a number that is not above 0", "a finite length above 0, in m"}};

/// The range of numbers that are read from a file and go into a step as they are.
bool is_amount(Real x) { return x >= 0 && std::isfinite(x); }

/// Whether all vectors are finite.
bool is_vectors_finite(const TimedEvent& e) {
  const Vec3* all[] = {&e.anchor,   &e.force, &e.torque, &e.impulse, &e.angular_impulse,
                       &e.velocity, &e.gusts, &e.target, &e.gravity};
  return std::all_of(std::begin(all), std::end(all), [](const Vec3* v) { return is_finite(*v); }) &&
         std::isfinite(e.drag);
}

/// A number within [-1, 1] (Steele, Lea & Flood's splitmix64).
Real random_number(std::uint64_t seed, std::uint64_t axis, std::uint64_t number) {
  std::uint64_t z = seed * 0x9e3779b97f4a7c15ull + axis * 0xd1b54a32d192ed03ull + number;
  for (int i = 0; i < 2; ++i) {
    z += 0x9e3779b97f4a7c15ull;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    z ^= z >> 31;
  }
  return static_cast<Real>(z >> 11) * (2.0 / 9007199254740992.0) - 1;
}

}  // namespace

const char* TimedEvent::restored() const {
  return fault_of(*this) || !is_finite(progress.start) ? "is an event with a number that is none"
                                                       : nullptr;
}

namespace detail {

const TimedEventFault* fault_of(const TimedEvent& e) {
  if (!is_amount(e.from)) return &kFaults[0];
  if (!(e.to >= e.from)) return &kFaults[1];
  if (!(e.every == 0 || (e.every >= kShortestRepeat && std::isfinite(e.every)))) return &kFaults[2];
  if (lasts(e.kind) && e.every > 0 && !(e.to - e.from <= e.every)) return &kFaults[3];
  if (!is_amount(e.over)) return &kFaults[4];
  if (!(e.gust_time >= kShortestRepeat && std::isfinite(e.gust_time))) return &kFaults[5];
  if (!is_vectors_finite(e)) return &kFaults[6];
  if (!is_amount(e.stiffness) || !is_amount(e.damping) || !is_amount(e.max_torque))
    return &kFaults[7];
  const JointMotor& m = e.motor;
  if (!std::isfinite(m.target) || !is_amount(m.gain) || !is_amount(m.damping) || !is_amount(m.cap))
    return &kFaults[8];
  if (!(e.length > 0 && std::isfinite(e.length))) return &kFaults[9];
  return nullptr;
}

Store<TimedEvent>& events_of(World& world) { return world.user.of<TimedEvent>(); }
const Store<TimedEvent>* events_of(const World& world) { return world.user.find<TimedEvent>(); }

Entity add_event(World& world, const TimedEvent& event) {
  const auto expect_force = [&](Entity body) {
    const Body* b = world.bodies.find(body);
    if (b && b->motion == Motion::dynamic && !world.forces.find(body)) world.forces.add(body, {});
  };
  if (event.kind == push || event.kind == impulse) expect_force(event.on);
  if (event.kind == wind) {
    for (const Entity e : event.bodies) expect_force(e);
    if (event.bodies.empty())
      for (const Entity e : world.bodies.owners()) expect_force(e);
  }
  const Entity e = world.create();
  events_of(world).add(e, event);
  return e;
}

Real mean_of(const Noise& noise, Real from, Real to) {
  const Real first = from / noise.period, last = to / noise.period;
  constexpr Real kMostCells = 4096;  // over so many the mean is next to nothing
  if (!(last > first) || !(last - first < kMostCells) || !(last < 1e15)) return 0;
  // Integral over a cell from its start to u: between a and b by the cubic 3 u^2 - 2 u^3.
  const auto integral = [](Real a, Real b, Real u) {
    return a * u + (b - a) * (u * u * u * (1 - u / 2));
  };
  Real sum = 0;
  for (Real cell = std::floor(first); cell < last; ++cell) {
    const auto number = static_cast<std::uint64_t>(static_cast<std::int64_t>(cell));
    const Real a = random_number(noise.seed, noise.axis, number),
               b = random_number(noise.seed, noise.axis, number + 1);
    const Real begin = std::max(Real(0), first - cell), end = std::min(Real(1), last - cell);
    sum += integral(a, b, end) - integral(a, b, begin);
  }
  return sum / (last - first);
}

Real active_time(const TimedEvent& e, Real from, Real to) {
  if (e.every == 0) return std::max(Real(0), std::min(to, e.to) - std::max(from, e.from));
  const Real length = e.to - e.from;
  const auto until = [&](Real time) {  // from the first start to `time`
    if (!(time > e.from)) return Real(0);
    const Real whole = std::floor((time - e.from) / e.every);
    return whole * length + std::min(length, time - e.from - whole * e.every);
  };
  return until(to) - until(from);
}

}  // namespace detail
}  // namespace pantin
