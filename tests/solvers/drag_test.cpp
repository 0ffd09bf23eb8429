// Drag takes velocities down as exp(-c t), by any method of the default solver and from any start.
#include <catch2/catch.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/chains.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kDrag = 2;  // 1/s

/// A wheel on a hinge: a joint that the energy-momentum method does not know.
World wheel(Entity* body) {
  World w;
  w.default_settings.solver = Solver::articulated;
  w.gravity = Vec3(0);
  Body wall;
  wall.motion = Motion::fixed;
  const Entity hub = w.add_body(wall);
  Body b;
  b.mass = 2, b.inertia = {0.04, 0.02, 0.02}, b.drag = kDrag;
  b.angular_velocity = {3, 0, 0};
  *body = w.add_body(b);
  Joint hinge;
  hinge.kind = JointKind::hinge;
  add_link(w, {hub, *body, hinge});
  return w;
}

/// Relative errors after a second.
struct Errors {
  Real speed, angle;
};
Errors errors_of_wheel(Real rate) {
  Entity e;
  Simulation sim(wheel(&e), {1 / rate});
  Real angle = 0;
  for (int i = 0; i < static_cast<int>(rate); ++i) {
    const Quat before = sim.world.bodies[e].pose.rotation;
    sim.step();
    angle += rotation_vector(sim.world.bodies[e].pose.rotation * glm::conjugate(before)).x;
  }
  const Real kept = std::exp(-kDrag);
  return {std::abs(sim.world.bodies[e].angular_velocity.x / (3 * kept) - 1),
          std::abs(angle / (3 * (1 - kept) / kDrag) - 1)};
}

}  // namespace

TEST_CASE("a wheel that starts turning loses its speed to drag as exp(-c t), to second order") {
  const Errors coarse = errors_of_wheel(60), fine = errors_of_wheel(240);
  INFO("speed off by " << coarse.speed << ", " << fine.speed << "; angle by " << coarse.angle
                       << ", " << fine.angle);
  CHECK(coarse.speed < 2e-3);
  CHECK(coarse.angle < 2e-3);
  CHECK(fine.speed < std::max(coarse.speed / 12, 1e-12));  // exact, but for rounding
  CHECK(fine.angle < coarse.angle / 12);
}

TEST_CASE("drag stops a motion and does not turn it round, however strong it is") {
  Entity e;
  World w = wheel(&e);
  w.bodies[e].drag = 1000;
  Simulation sim(std::move(w), {1.0 / 60});
  for (int i = 0; i < 5; ++i) {
    sim.step();
    const Real speed = sim.world.bodies[e].angular_velocity.x;
    CHECK(speed > -1e-6);
    CHECK(speed < 0.1);
  }
}
