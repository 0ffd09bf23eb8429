#include "engine/world/events/wind.hpp"

#include <algorithm>
#include <cmath>

namespace pantin {

using namespace detail;

namespace {

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

/// The mean velocity of the air in this substep, m/s.
Vec3 air_of(const EventStep& step, const WindEvent& e) {
  Vec3 air = e.velocity;
  const bool once = e.every == 0;
  const Real from = once ? std::max(step.from, e.from) : step.from,
             to = once ? std::min(step.to(), e.to) : step.to();
  for (int i = 0; i < 3; ++i)
    if (e.gusts[i] != 0)
      air[i] +=
          e.gusts[i] * mean_of({e.seed, static_cast<std::uint64_t>(i), e.gust_time}, from, to);
  return air;
}

}  // namespace

void WindEvent::act(const EventStep& step, Real part) const {
  World& world = step.world;
  const Vec3 air = air_of(step, *this);
  const auto on_body = [&](Entity owner) {
    if (!can_be_pushed(world, owner)) return;
    const Body& b = world.bodies[owner];
    // The step applies the body's own drag by itself. A drag rate of the wind must not accelerate a
    // body beyond the velocity of the air in a long step, hence the exponential.
    const Vec3 acceleration =
        drag < 0 ? b.drag * air
                 : -std::expm1(-drag * part * step.h) / (part * step.h) * (air - b.velocity);
    world.push(owner, part * b.mass * acceleration, b.pose.position);
  };
  if (bodies.empty())
    for (const Entity owner : world.bodies.owners()) on_body(owner);
  for (const Entity owner : bodies) on_body(owner);
}

std::optional<EventFault> WindEvent::fault() const {
  constexpr EventFault kGusts{"gust_time", "a time below 1e-3 s", "1e-3 s or more"};
  constexpr EventFault kDrag{"drag", "a number that is not finite", "a finite number"};
  if (!(gust_time >= kShortestRepeat && std::isfinite(gust_time))) return kGusts;
  return std::isfinite(drag) ? std::nullopt : std::optional(kDrag);
}

namespace detail {

Real mean_of(const Noise& noise, Real from, Real to) {
  const Real first = from / noise.period, last = to / noise.period;
  constexpr Real kMostCells = 4096;  // the mean over more cells is close to zero
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

}  // namespace detail
}  // namespace pantin
