// Compensates the compression of contact springs under lasting loads, over some seconds.
#include <algorithm>

#include "engine/solvers/articulated/impulses/group_points.hpp"

namespace pantin::detail::articulated {
namespace {

/// s: time constants of the compensation; fraction of the compression that is compensated.
constexpr Real kTakeUpTime = 0.1, kTakeUpTimeOfTrees = 2, kTakenUp = 0.998;
/// m/s: slower bodies have their compression compensated; above the second, that is undone.
constexpr Real kCalmSpeed = 0.005, kWildSpeed = 0.02;
/// In shallow overlaps: the largest compression that is compensated. Among trees those above the
/// third are compensated faster, in proportion, so that heavy bodies do not sleep before.
constexpr Real kMostTakenUp = 3, kHaste = 8, kHeavy = 0.5;
/// Overlaps of trees this many times deeper than shallow ones are accepted over this time, s:
/// interlocked bodies would be pushed back and forth for ever.
constexpr Real kInterlocked = 4, kGiveUpTime = 2;
/// m: above 0 it tells contact detection that the contact is soft.
constexpr Real kLeastRest = 1e-12;

/// m: compression of a contact's spring.
Real compression(const Group& g, const GroupContact& c, const Substep& s) {
  const Softness& spring = spring_of(g, c, s);
  PANTIN_ASSERT(spring.rate > 0 && spring.by_mass > 0);
  return spring.by_impulse * c.impulse.x * c.along / (spring.by_mass * spring.rate);
}

}  // namespace

void take_up(const Group& g, const Substep& s, Real h) {
  const bool jointed = !g.trees.empty();
  const Real usual = h / (jointed ? kTakeUpTimeOfTrees : kTakeUpTime);
  const Real give_up = g.trees.empty() ? 0 : h / kGiveUpTime;
  const auto speed_of = [&](std::uint32_t i) {
    const GroupBody& b = g.bodies[i];
    return b.per_mass > 0 ? glm::length(b.velocity) : 0;
  };
  Real fastest = 0;
  for (std::uint32_t i = 0; g.trees.empty() && i < g.bodies.size(); ++i)
    fastest = std::max(fastest, speed_of(i));
  for (std::size_t from = 0, to = 0; from < g.contacts.size(); from = to) {
    Real sum = 0, bearing = 0;
    for (to = from; to < g.contacts.size() && have_same_bodies(g.contacts[to], g.contacts[from]);
         ++to) {
      sum += compression(g, g.contacts[to], s);
      bearing += g.contacts[to].impulse.x > 0;
    }
    const Real speed =
        std::max({fastest, speed_of(g.contacts[from].a), speed_of(g.contacts[from].b)});
    const bool lasts = speed < kCalmSpeed;
    const bool wild = speed > kWildSpeed;
    const Real mean = bearing > 0 ? sum / bearing : 0;
    for (std::size_t i = from; i < to; ++i) {
      GroupContact& c = g.contacts[i];
      c.rest = std::max(kLeastRest, c.rest);
      if (-c.gap > kInterlocked * c.shallow) {
        c.rest = std::min(-c.gap, c.rest + give_up * -c.gap);
        continue;
      }
      if (!lasts && !wild) continue;
      const Real heavy = mean / std::max(c.shallow, kLeastRest) - kHeavy;
      const Real haste = jointed && heavy > 0 ? 1 + kHaste * heavy : 1;
      const Real part = 1 - std::exp(-usual * haste);
      const Real rest = lasts ? std::clamp(kTakenUp * mean, Real(0), kMostTakenUp * c.shallow) : 0;
      c.settling = (1 - part) * std::abs(rest - c.rest);
      c.rest = std::max(kLeastRest, c.rest + part * (rest - c.rest));
    }
  }
}

}  // namespace pantin::detail::articulated
