// Rings of NURBS surfaces that hang in one another: a place of contact that slides far over both
// faces in a step, and overlaps of tubes.
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/geometry/collide.hpp"
#include "engine/nurbs/makers.hpp"
#include "tests/base/random.hpp"
#include "tests/geometry/creased.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kRadius = 0.04;

Shape ring_shape(Real tube) { return skin_shape({nurbs::torus({}, kRadius, tube)}); }

/// The first is fixed; each next one is in the one before and lies beside it, so that it falls.
World chain_of_rings(int count, Real tube, Real last_density) {
  World w;
  Collision solid;
  solid.friction = 0.3, solid.others = true;
  const Shape shape = ring_shape(tube);
  for (int i = 0; i < count; ++i) {
    const Quat turn = i % 2 == 0 ? kIdentity : glm::angleAxis(kPi / 2, Vec3(1, 0, 0));
    add_solid(w, shape, {{i * (2 * (kRadius - tube) - 0.004), 0, 0}, turn},
              i == 0 ? Motion::fixed : Motion::dynamic, solid,
              i + 1 == count ? last_density : 7800);
  }
  return w;
}

/// Points of the circle in the middle of a ring's tube.
std::vector<Vec3> circle(const Pose& at, int count) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const Real angle = 2 * kPi * i / count;
    points.push_back(to_world(at, kRadius * Vec3(std::cos(angle), std::sin(angle), 0)));
  }
  return points;
}
/// The distance of two such circles to some 1e-6 m.
Real apart(const Pose& a, const Pose& b) {
  Real least = 1e300;
  for (const Vec3 p : circle(a, 2000)) {
    // The nearest point of the other circle, in its own frame.
    const Vec3 q = to_local(b, p);
    least = std::min(least, std::hypot(std::hypot(q.x, q.y) - kRadius, q.z));
  }
  return least;
}

}  // namespace

TEST_CASE("linked rings: an overlap of tubes is found at any depth below their thickness") {
  Random dice(5);
  const Real tube = 0.006;
  const Shape shape = ring_shape(tube);
  NarrowPhaseScratch scratch;
  int deep = 0;
  for (int n = 0; n < 400; ++n) {
    const Pose a{dice.in_cube(0.05), dice.rotation()};
    const Real gap = apart(a, {}) - 2 * tube;
    if (gap < -0.8 * tube || gap > 0.002) continue;
    std::vector<ContactPoint> points;
    collide({shape, a}, {shape, {}}, scratch, {0.003, points});
    Real found = 1e300;
    for (const ContactPoint& p : points) found = std::min(found, p.gap);
    INFO(n << ": a gap of " << gap << " m, found " << found);
    CHECK(std::abs(found - gap) < 2e-6);
    deep += gap < -0.3 * tube;
  }
  CHECK(deep > 5);
}

TEST_CASE("linked rings: a chain of them falls and hangs, at any step, thin, and heavy below") {
  struct Case {
    Real h, tube, density;
  };
  for (const auto& [h, tube, density] :
       {Case{1.0 / 60, 0.006, 7800}, Case{1.0 / 30, 0.006, 7800}, Case{1.0 / 240, 0.006, 7800},
        Case{1.0 / 60, 0.003, 7800}, Case{1.0 / 60, 0.006, 78000}}) {
    Simulation sim(chain_of_rings(5, tube, density), {h, 1, 1, true});
    const Real start = measure(sim.world).energy();
    Real gained = 0;
    for (int i = 0; i < 1.5 / h; ++i) {
      const StepReport report = sim.step();
      REQUIRE(report.status == Status::ok);
      gained = std::max(gained, report.measures.energy() - start);
    }
    INFO("step " << h << " s, tube " << tube << " m, density " << density);
    CHECK(gained < 1e-6);
    const auto bodies = sim.world.bodies.values();
    for (std::size_t i = 1; i < bodies.size(); ++i)
      CHECK(glm::distance(bodies[i].pose.position, bodies[i - 1].pose.position) < 2 * kRadius);
  }
}

TEST_CASE("linked rings: where a ring hangs does not depend on the step") {
  std::vector<Real> energies;
  for (const Real h : {1.0 / 30, 1.0 / 60, 1.0 / 240, 1.0 / 1000}) {
    World w = chain_of_rings(3, 0.006, 7800);
    for (Body& b : w.bodies.values()) b.drag = 5;
    Simulation sim(std::move(w), {h, 1, 1, true});
    for (int i = 0; i < 4 / h; ++i) sim.step();
    energies.push_back(measure(sim.world).energy());
  }
  for (const Real e : energies) CHECK(e == Approx(energies.back()).epsilon(2e-3));
}

TEST_CASE("linked rings: one that flies fast is held, whatever the step") {
  for (const Real speed : {1.0, 5.0, 10.0, 20.0})
    for (const Real h : {1.0 / 60, 1.0 / 240}) {
      World w = chain_of_rings(2, 0.006, 1000);
      w.gravity = Vec3(0);
      w.bodies.values()[1].velocity = Vec3(0, -speed, 0);
      Simulation sim(std::move(w), {h, 1, 1, true});
      for (int i = 0; i < 0.3 / h; ++i) sim.step();
      INFO(speed << " m/s at steps of " << h << " s");
      CHECK(glm::length(sim.world.bodies.values()[1].pose.position) < 2 * kRadius);
      CHECK(measure(sim.world).energy() <= 0.5 * sim.world.bodies.values()[1].mass * speed * speed);
    }
}
