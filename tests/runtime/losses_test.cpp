// What contacts, drag and blows of cables take is paid for; what is lost besides is told.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

#include "engine/base/rotation.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// How often a World has lost energy that nothing took, in `seconds`.
int losses_of(World world, Real h, Real seconds) {
  Simulation sim(std::move(world), {h, 1, 1, false, true});
  while (sim.world.time < seconds - h / 2) sim.step();
  int losses = 0;
  for (const Finding& f : sim.findings()) losses += f.kind == FindingKind::energy_lost;
  return losses;
}

Collision surface(Real friction, Real restitution) {
  Collision c;
  c.friction = friction, c.restitution = restitution, c.others = true;
  return c;
}

void ask(World& w, Solver solver, Integrator integrator) {
  w.default_settings.solver = solver, w.default_settings.integrator = integrator;
}

/// Asks that no energy is lost under the other methods, for `seconds` of steps of h.
void check_nothing_lost(World& w, std::initializer_list<Integrator> exact, Real h, Real seconds) {
  for (const Integrator by : exact) {
    ask(w, Solver::lagrangian, by);
    CHECK(losses_of(w, h, seconds) == 0);
  }
  ask(w, Solver::articulated, Integrator::rattle);
  CHECK(losses_of(w, h, seconds) == 0);
}

constexpr Real kRadius = 0.05, kHalf = 0.25;

/// Two rods, hinged by a ball at the origin, whirl against one another on a floor without friction.
World whirled_rods() {
  World w;
  add_ground(w, surface(0, 0));
  Entity rods[2];
  for (const int side : {0, 1}) {
    const Real x = side == 0 ? -kHalf : kHalf;
    rods[side] = add_solid(w, rod_shape(kRadius, kHalf - kRadius),
                           {{x, kRadius, 0}, from_rotation_vector({0, 0, kPi / 2})},
                           Motion::dynamic, surface(0, 0));
    Body& b = w.bodies[rods[side]];
    b.angular_velocity = {0, side == 0 ? 12 : -5, 0};
    b.velocity = glm::cross(b.angular_velocity, Vec3(x, 0, 0));
  }
  add_link(w, {rods[0], rods[1], {{0, -kHalf, 0}, {0, kHalf, 0}}});
  return w;
}

}  // namespace

TEST_CASE("energy that an integrator loses is told while bodies touch, too") {
  World w = whirled_rods();
  ask(w, Solver::lagrangian, Integrator::euler);
  CHECK(losses_of(w, 1.0 / 60, 2) > 0);
  check_nothing_lost(w, {Integrator::rattle, Integrator::rk4}, 1.0 / 240, 2);
}

TEST_CASE("energy that an integrator loses is told where cables act, blows of them are not") {
  World w;
  Body hook, rod, ball;
  hook.motion = Motion::fixed;
  rod.pose.position = {0.5, 0, 0}, rod.inertia = {1e-3, 1.0 / 12, 1.0 / 12};
  ball.pose.position = {1.5, 0, 0}, ball.inertia = Vec3(4e-3);
  const Entity hung = w.add_body(rod);
  add_link(w, {w.add_body(hook), hung, {{}, {-0.5, 0, 0}}});
  // From beside the rod to beside the ball: it lets go and goes taut again.
  add_cable(w, {hung, w.add_body(ball), {{0, 1, 0}, {1.5, 0, 0}, std::sqrt(7.25), 0}});
  for (const Real h : {1.0 / 240, 1.0 / 960}) {
    ask(w, Solver::lagrangian, Integrator::euler);
    CHECK(losses_of(w, h, 2) > 0);
    check_nothing_lost(w, {Integrator::rk4}, h, 3);
  }
}

TEST_CASE("what a blow of a cable is paid for is no more than its impulse can take") {
  for (const Real mass : {0.3, 0.8, 1.0, 1.5, 3.0}) {
    World w;
    const Entity rod = w.add(RigidBody{.shape = CapsuleShape{.radius = 0.02, .half_length = 0.45},
                                       .mass = 1.0,
                                       .position = {0.5, 0, 0},
                                       .rotation = from_rotation_vector({0, 0, kPi / 2}),
                                       .drag = 0})
                           .value();
    const Entity ball = w.add(RigidBody{.shape = SphereShape{.radius = 0.1},
                                        .mass = mass,
                                        .position = {1.5, 0, 0},
                                        .drag = 0})
                            .value();
    const Entity hook = w.add(RigidBody{.motion = Motion::fixed}).value();
    add_link(w, {hook, rod, {{}, {0, 0.5, 0}}});
    add_cable(w, {rod, ball, {{0, -0.5, 0}, {}, 0.5, 0}});  // taut from the start
    INFO(mass);
    ask(w, Solver::lagrangian, Integrator::euler);
    CHECK(losses_of(w, 1.0 / 60, 1) > 0);
    check_nothing_lost(w, {Integrator::rattle, Integrator::rk4}, 1.0 / 60, 1);
  }
}

TEST_CASE("what slides, bounces, rolls, topples and is piled up loses nothing that is not paid") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian})
    for (const Real h : {1.0 / 60, 1.0 / 240}) {
      World w;
      ask(w, solver, Integrator::rk4);
      add_ground(w, surface(0.5, 0));
      const auto put = [&](const Shape& shape, Vec3 at, Vec3 turn, Real restitution) {
        return add_solid(w, shape, {at, from_rotation_vector(turn)}, Motion::dynamic,
                         surface(0.5, restitution));
      };
      w.bodies[put(box_shape(Vec3(0.1)), {-3, 0.1, 0}, Vec3(0), 0)].velocity = {3, 0, 0};
      put(ball_shape(0.1), {0, 1, 2}, Vec3(0), 0.7);
      Body& rolls = w.bodies[put(ball_shape(0.1), {-3, 0.1, 3}, Vec3(0), 0)];
      rolls.velocity = {1, 0, 0}, rolls.angular_velocity = {0, 0, -10};
      put(box_shape({0.05, 0.4, 0.1}), {0, 0.42, -2}, {0, 0, 0.2}, 0);
      w.bodies[put(box_shape({0.1, 0.2, 0.05}), {0, 1, -3}, {0.5, 0.4, 0}, 0.3)]
          .angular_velocity = {4, -3, 9};
      for (int i = 0; i < 4; ++i) put(box_shape(Vec3(0.1)), {3, 0.1 + 0.21 * i, 0}, Vec3(0), 0);
      INFO(name_of(solver) << " " << h);
      CHECK(losses_of(w, h, 4) == 0);
    }
}
