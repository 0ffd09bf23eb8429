// Rows and stacks of boxes that touch, as they strike and land: plastic impacts take energy, and
// give none. Contacts in lanes are solved colour by colour, and groups that glide as a whole.
#include <algorithm>

#include "tests/solvers/standing.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kSteps[] = {1.0 / 60, 1.0 / 240, 1.0 / 960};

/// What is left of a run: the largest energy, and the last world.
struct Run {
  Real most;
  World end;
};

Run run_of(const World& w, const StepSettings& settings, Real time) {
  Simulation sim = Simulation::copy_of(w, settings);
  Real most = measure(sim.world).energy();
  for (int i = 0; i < std::lround(time / settings.h); ++i) {
    REQUIRE(sim.step().status == Status::ok);
    most = std::max(most, measure(sim.world).energy());
  }
  return {most, sim.world};
}

/// A row of cubes of 0.2 m along x, that touch.
Standing row(int count, Real friction) {
  Standing s(friction);
  s.world.gravity = Vec3(0);
  for (int i = 0; i < count; ++i) s.add({0.2 * i, 5, 0}, Vec3(0.1));
  return s;
}

}  // namespace

TEST_CASE("a row of boxes that strikes a wall stops, and gains nothing on the way") {
  for (const Real h : kSteps)
    for (const Real friction : {0.0, 0.5})
      for (const int count : {4, 6, 7, 12}) {
        INFO(count << " boxes, friction " << friction << ", " << h);
        Standing s = row(count, friction);
        for (const Entity e : s.blocks) s.world.bodies[e].velocity = {5, 0, 0};
        add_solid(s.world, box_shape({0.1, 2, 2}), {{0.2 * count + 0.2, 5, 0}, kIdentity},
                  Motion::fixed, s.of);
        const Real start = 0.5 * 25 * s.mass();
        const Run run = run_of(s.world, {h}, 1);
        CHECK(run.most < start * (1 + 1e-9));
        // Sweeps leave long rows a remainder.
        CHECK(measure(run.end).kinetic < (count > 10 ? 0.04 : 5e-3) * start);
      }
}

TEST_CASE("a box that strikes a row moves it as a whole") {
  for (const Real h : kSteps)
    for (const int count : {4, 10, 20}) {
      INFO(count << " boxes, " << h);
      Standing s = row(count, 0.5);
      const Entity first = s.add({-0.5, 5, 0}, Vec3(0.1));
      s.world.bodies[first].velocity = {5, 0, 0};
      const Run run = run_of(s.world, {h}, 0.5);
      Vec3 momentum(0);
      for (const Body& b : run.end.bodies.values()) momentum += b.mass * b.velocity;
      const Real mass = s.mass(), own = mass / (count + 1);
      CHECK(momentum.x == Approx(5 * own).epsilon(1e-9));
      const Real least = 0.5 * momentum.x * momentum.x / mass;
      CHECK(measure(run.end).kinetic < least * (count > 10 ? 1.3 : 1.1));
    }
}

TEST_CASE("stacks of boxes land flat, without gain, and stand") {
  for (const Real h : kSteps)
    for (const int count : {4, 5, 8, 15})
      for (const Real height : {0.3, 1.0, 3.0}) {
        INFO(count << " boxes from " << height << " m, " << h);
        Standing s;
        for (int i = 0; i < count; ++i) s.add({0, 0.1 + 0.2 * i + height, 0}, Vec3(0.1));
        const Real start = measure(s.world).energy();
        const Run run = run_of(s.world, {h}, 2);
        CHECK(run.most < start * 1.001);
        if (count == 15 && height > 2) continue;  // it falls over
        const Real near = count == 15 ? 0.02 : 2e-3;
        for (std::size_t i = 0; i < s.blocks.size(); ++i) {
          const Vec3 at = run.end.bodies[s.blocks[i]].pose.position;
          CHECK(std::abs(at.y - (0.1 + 0.2 * static_cast<Real>(i))) < near);
        }
      }
}
