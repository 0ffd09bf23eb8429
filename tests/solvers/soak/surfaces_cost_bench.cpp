// What contacts of surfaces cost. Run by name: pantin_tests "surfaces: what they cost".
#include <catch2/catch.hpp>
#include <ctime>
#include <iostream>

#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr int kContacts = 100;

/// So many ellipsoids, each rolling in a bowl or on a plane of its own.
Simulation many(Integrator integrator, const SkinPtr& ground, bool touching, Real h) {
  World w = exact_world(integrator);
  const Entity floor = add_ground(w);
  const SkinPtr skin = ball_skin({0.12, 0.1, 0.11});
  for (int i = 0; i < kContacts; ++i) {
    const Entity body =
        w.add_body(solid_ellipsoid(1, {0.12, 0.1, 0.11}, {{0.01 * i - 0.5, 0.1, 0.2}, kIdentity}));
    w.bodies[body].angular_velocity = {0.5, 0.1 * (i % 5), 1};
    if (touching) touch(w, {body, skin, floor, ground}, SurfaceMotion::rolling);
  }
  return Simulation(std::move(w), {h});
}

/// CPU time of a step, the least of some rounds, us for each body.
Real cost(Simulation sim) {
  for (int i = 0; i < 20; ++i) REQUIRE(sim.step().status == Status::ok);
  Real least = 1e300;
  for (int round = 0; round < 15; ++round) {
    const std::clock_t start = std::clock();
    for (int i = 0; i < 20; ++i) sim.step();
    least = std::min(least, Real(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return least / 20 / kContacts * 1e6;
}

}  // namespace

TEST_CASE("surfaces: what they cost", "[.]") {
  const std::pair<const char*, SkinPtr> grounds[] = {{"plane", flat_skin(20)},
                                                     {"ellipsoid", ball_skin({30, 30, 30})}};
  for (const Integrator integrator : kAll)
    for (const auto& [name, skin] : grounds) {
      if (name[0] == 'e') continue;
      const Real with = cost(many(integrator, skin, true, 1.0 / 600));
      const Real without = cost(many(integrator, skin, false, 1.0 / 600));
      std::cout << name_of(integrator) << ", on a " << name << ": " << with << " us a step, "
                << without << " without the contact\n";
    }
  const Real frame = cost(many(Integrator::rk4, flat_skin(20), true, 1.0 / 60)) * kContacts * 1e-6;
  std::cout << kContacts << " contacts, rk4 at 60 Hz: " << 60 * frame << " s for a second\n";
  CHECK(60 * frame < 1);
}
