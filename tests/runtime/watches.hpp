#pragma once
// What the tests of watches share: bodies are put where a solver would have left them.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

#include "engine/runtime/monitor.hpp"

namespace pantin::test {

inline constexpr Real kStep = 0.01;

/// The only finding of a kind, or null.
inline const Finding* find(const detail::FindingList& found, FindingKind kind) {
  const Finding* one = nullptr;
  for (const Finding& f : found.all())
    if (f.kind == kind) one = &f;
  return one;
}

inline Entity add_box(World& w, Vec3 at, Vec3 half, Motion motion = Motion::dynamic) {
  return w
      .add(RigidBody{.motion = motion,
                     .shape = BoxShape{.half_extents = half},
                     .mass = motion == Motion::dynamic ? std::optional<Real>(1) : std::nullopt,
                     .position = at,
                     .collision = Collision{},
                     .drag = 0})
      .value();
}

/// A World that has been compiled.
inline World built(World w, Solver solver = Solver::articulated) {
  w.gravity = Vec3(0);
  w.default_settings.solver = solver;
  Simulation sim(std::move(w), {1e-6});
  sim.step();
  return sim.world;
}

/// What the gaps of a World are found to be at the end of a step, after `change`.
template <class Change>
detail::FindingList gaps_after(const World& w, const Change& change) {
  detail::GapWatch watch;
  detail::FindingList found;
  found.open();
  World world = w;
  watch.compile(world);
  watch.end_step(world, kStep, found);  // as it stands
  CHECK(found.all().empty());
  change(world);
  watch.end_step(world, kStep, found);
  return found;
}

}  // namespace pantin::test
