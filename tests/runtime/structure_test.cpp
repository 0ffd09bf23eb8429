// Structural changes while a World runs: safe at every place of a step, and felt only by the
// islands whose own structure changes.
#include <catch2/catch.hpp>
#include <functional>
#include <string>
#include <vector>

#include "engine/runtime/simulation.hpp"
#include "engine/solvers/articulated/island.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/ties.hpp"
#include "tests/runtime/puppets.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Stage kEverywhere[] = {Stage::before_drive,    Stage::before_update,
                                 Stage::before_contacts, Stage::before_adjust,
                                 Stage::before_measure,  Stage::after_step};

Entity add_ball(World& w, Vec3 at, bool solid = true, Motion motion = Motion::dynamic) {
  Body b;
  b.motion = motion, b.pose.position = at, b.mass = 0.5, b.inertia = Vec3(0.002), b.drag = 0.1;
  const Entity e = w.add_body(b);
  Shape ball;
  ball.size = {0.1, 0, 0};
  w.shapes.add(e, {{ball}});
  Collision c;
  c.others = true, c.restitution = 0.3;
  if (solid) w.collisions.add(e, c);
  return e;
}

Entity add_floor(World& w, Vec3 at = Vec3(0)) {
  Body b;
  b.motion = Motion::fixed, b.pose.position = at;
  const Entity e = w.add_body(b);
  Shape plane;
  plane.kind = ShapeKind::plane, plane.size = {5, 0, 0};
  w.shapes.add(e, {{plane}});
  w.collisions.add(e, {});
  return e;
}

/// A bit of everything: a puppet, balls on a floor and on one another, an exact double pendulum
/// that a rope hangs on.
struct Zoo {
  World world;
  std::vector<Entity> puppet, balls, exact, rope, links;
  Entity bar, pin;

  Zoo() {
    Puppet p = swaying_puppet();
    world = std::move(p.world);
    puppet = {p.trunk, p.left, p.right, p.free}, bar = p.bar, links = {p.link};
    add_floor(world, {0, -1, 0});
    for (int i = 0; i < 6; ++i) balls.push_back(add_ball(world, {5 + 0.3 * (i % 3), 0.2 * i, 0}));
    Body hook;
    hook.motion = Motion::fixed, hook.pose.position = {-5, 2, 0};
    Entity above = world.add_body(hook);
    Vec3 end(0);
    SolverSettings lagrangian;
    lagrangian.solver = Solver::lagrangian;
    for (int i = 0; i < 2; ++i) {
      exact.push_back(world.add_body(rod({-5 + kHalfLink * (2 * i + 1), 2, 0})));
      links.push_back(add_link(world, {above, exact.back(), {end, {-kHalfLink, 0, 0}}}));
      world.settings.add(exact.back(), lagrangian);
      above = exact.back(), end = {kHalfLink, 0, 0};
    }
    for (int i = 0; i < 3; ++i) {
      rope.push_back(world.add_body(rod({-5 + kHalfLink * (2 * i + 5), 2, 0})));
      if (i > 0)
        links.push_back(add_link(world, {rope[i - 1], rope[i], {end, {-kHalfLink, 0, 0}}}));
    }
    Pin hold;
    hold.body = rope[0], hold.anchor = {-kHalfLink, 0, 0}, hold.to = exact[1];
    hold.target = {kHalfLink, 0, 0};
    pin = world.add_pin(hold);
  }
};

struct Change {
  const char* what;
  std::function<void(Zoo&, World&, int)> apply;  // on the World in the step; how often it ran
};

std::vector<Change> changes() {
  const auto once = [](int n, int at) { return n == at; };
  return {
      {"destroy a ball",
       [=](Zoo& z, World& w, int n) {
         if (n < 6) w.destroy(z.balls[n]);
       }},
      {"add balls",
       [=](Zoo&, World& w, int n) {
         add_ball(w, {5, 3 + 0.3 * n, 0});
         add_ball(w, {5.05, 0.1 + 0.25 * n, 0.02});
       }},
      {"add and destroy a body",
       [](Zoo&, World& w, int n) {
         w.destroy(add_ball(w, {5.1, 0.1 * n, 0}));
       }},
      {"destroy the trunk",
       [=](Zoo& z, World& w, int n) {
         if (once(n, 2)) w.destroy(z.puppet[0]);
       }},
      {"destroy a joint",
       [=](Zoo& z, World& w, int n) {
         if (once(n, 2)) w.destroy(z.links[0]);
       }},
      {"destroy the bar",
       [=](Zoo& z, World& w, int n) {
         if (once(n, 2)) w.destroy(z.bar);
       }},
      {"destroy an exact body",
       [=](Zoo& z, World& w, int n) {
         if (once(n, 2)) w.destroy(z.exact[1]);
       }},
      {"destroy an exact joint",
       [=](Zoo& z, World& w, int n) {
         if (once(n, 2)) w.destroy(z.links[1]);
       }},
      {"let the rope go",
       [=](Zoo& z, World& w, int n) {
         if (once(n, 2)) w.destroy(z.pin);
       }},
      {"cut the rope",
       [=](Zoo& z, World& w, int n) {
         if (once(n, 2)) w.destroy(z.links[3]);
       }},
      {"another solver",
       [](Zoo&, World& w, int n) {
         w.default_settings.solver = n % 2 ? Solver::lagrangian : Solver::articulated;
         w.mark_dirty();
       }},
      {"a new exact body",
       [](Zoo& z, World& w, int n) {
         SolverSettings lagrangian;
         lagrangian.solver = Solver::lagrangian;
         const Entity e = w.add_body(rod({-7, 0.3 * n, 0}));
         w.settings.add(e, lagrangian);
         if (n == 3) add_link(w, {z.exact[1], e, {Vec3(0, 0.3, 0), Vec3(0)}});
       }},
      {"another pin",
       [](Zoo& z, World& w, int n) {
         Pin hold;
         hold.body = z.rope[2], hold.to = z.exact[0], hold.kind = PinKind::spring;
         if (n < 3) w.add_pin(hold);
       }},
      {"everything goes",
       [=](Zoo&, World& w, int n) {
         const std::vector<Entity> all(w.bodies.owners().begin(), w.bodies.owners().end());
         if (once(n, 2)) w.destroy(all);
       }},
      {"another World",
       [](Zoo&, World& w, int n) {
         const World copy = w;
         if (n % 2) w = copy;
       }},
      {"an older World",
       [](Zoo& z, World& w, int n) {
         if (n == 3) w = z.world;
       }},
  };
}

bool is_sound(const World& w) {
  for (const Body& b : w.bodies.values())
    if (!is_finite(b.pose) || !is_finite(b.velocity) || !is_finite(b.angular_velocity))
      return false;
  return true;
}

}  // namespace

TEST_CASE("anything may be created and destroyed by a system at any place") {
  for (const Change& change : changes())
    for (Stage place : kEverywhere)
      for (int substeps : {1, 3}) {
        INFO(change.what << " at place " << static_cast<int>(place) << ", substeps " << substeps);
        Zoo zoo;
        Simulation sim = Simulation::copy_of(zoo.world, {1.0 / 60, substeps, 1, true});
        int ran = -2;
        sim.insert(place, [&](World& w, Real) {
          if (++ran >= 0) change.apply(zoo, w, ran);
        });
        for (int i = 0; i < 20; ++i) {
          const StepReport report = sim.step();
          REQUIRE((report.status == Status::ok || report.status == Status::inconsistent));
          REQUIRE(is_sound(sim.world));
        }
        for (const auto& a : articulated::islands_of(std::as_const(sim.world)))
          for (Entity e : a.bodies) REQUIRE(sim.world.bodies.find(e));
      }
}

TEST_CASE("islands that a change does not concern go on in the same bits, wherever it happens") {
  // Bodies come first in the store and go, so that all the others get other slots.
  for (Stage place : kEverywhere)
    for (int substeps : {1, 2}) {
      INFO("place " << static_cast<int>(place) << ", substeps " << substeps);
      const auto make = [] {
        World first;
        for (int i = 0; i < 3; ++i) add_ball(first, {20 + 2.0 * i, 5, 0}, i != 1);
        return first;
      };
      World start = make();
      Zoo zoo;
      // The zoo after them, entity by entity the same.
      std::vector<Entity> early;
      {
        const World& z = zoo.world;
        early.assign(start.bodies.owners().begin(), start.bodies.owners().end());
        std::vector<Entity> now(z.bodies.size());
        for (std::size_t i = 0; i < z.bodies.size(); ++i) {
          const Entity was = z.bodies.owners()[i];
          now[i] = start.add_body(z.bodies.values()[i]);
          if (const auto* s = z.shapes.find(was)) start.shapes.add(now[i], *s);
          if (const auto* s = z.collisions.find(was)) start.collisions.add(now[i], *s);
          if (const auto* s = z.settings.find(was)) start.settings.add(now[i], *s);
          if (const auto* s = z.paths.find(was)) start.paths.add(now[i], *s);
        }
        const auto of = [&](Entity e) { return e ? now[z.bodies.slot(e)] : Entity{}; };
        for (const Link& l : z.links.values()) add_link(start, {of(l.a), of(l.b), l.joint});
        for (const Cable& s : z.cables.values()) add_cable(start, {of(s.a), of(s.b), s.joint});
        for (Pin p : z.pins.values()) p.body = of(p.body), p.to = of(p.to), start.add_pin(p);
      }
      Simulation changed = Simulation::copy_of(start, {1.0 / 60, substeps}),
                 calm = Simulation::copy_of(start, {1.0 / 60, substeps});
      int ran = 0;
      changed.insert(place, [&](World& w, Real) {
        ++ran;
        if (ran == 20) w.destroy(early[0]);
        if (ran == 31) w.destroy(early[1]);
        if (ran == 40) add_ball(w, {20, 9, 0});
      });
      for (int i = 0; i < 60; ++i) changed.step(), calm.step();
      REQUIRE(ran >= 41);
      for (std::size_t i = 3; i < calm.world.bodies.size(); ++i) {
        const Entity e = calm.world.bodies.owners()[i];
        INFO("body " << i);
        CHECK(changed.world.bodies[e].pose.position == calm.world.bodies[e].pose.position);
        CHECK(changed.world.bodies[e].velocity == calm.world.bodies[e].velocity);
        CHECK(changed.world.bodies[e].angular_velocity == calm.world.bodies[e].angular_velocity);
      }
    }
}

TEST_CASE("what sleeps goes on sleeping when something else comes or goes, and wakes for its own") {
  World w;
  const Entity floor = add_floor(w), step = add_ball(w, {0, 0.1, 0}, true, Motion::fixed);
  const Entity far = add_ball(w, {10, 4, 0}), ball = add_ball(w, {3, 0.1, 0});
  const Entity other = add_ball(w, {6, 0.1, 0});
  w.bodies[far].gravity_scale = 0;
  for (Entity e : {far, ball, other}) {  // what touches other dynamic bodies does not sleep
    Collision c = w.collisions[e];
    c.others = false, c.restitution = 0;
    w.collisions[e] = c;
  }
  Simulation sim = Simulation::copy_of(w);
  StepReport report;
  for (int i = 0; i < 120; ++i) report = sim.step();
  REQUIRE(report.asleep == 2);
  const auto rests = [&](Entity e) {
    for (const auto& a : articulated::islands_of(std::as_const(sim.world)))
      if (a.bodies.front() == e) return a.asleep;
    return false;
  };

  sim.world.destroy(far);
  CHECK(sim.step().asleep == 2);
  add_ball(sim.world, {-10, 5, 0});
  CHECK(sim.step().asleep == 2);
  sim.world.destroy(step);
  CHECK(sim.step().asleep == 2);
  // Something solid that comes where one sleeps wakes that one.
  add_ball(sim.world, {3.15, 0.1, 0}, true, Motion::fixed);
  sim.step();
  CHECK_FALSE(rests(ball));
  CHECK(rests(other));
  // When the floor goes nothing floats.
  for (int i = 0; i < 120; ++i) sim.step();
  REQUIRE(rests(other));
  sim.world.destroy(floor);
  for (int i = 0; i < 30; ++i) sim.step();
  CHECK(sim.world.bodies[other].pose.position.y < -0.5);
}

namespace {

/// Balls at rest on a floor and on a plate above it, all asleep.
struct Sleepers {
  Entity floor, plate;
  std::vector<Entity> on_floor, on_plate;
  Simulation sim;

  Sleepers() : sim(World{}) {
    World w;
    floor = add_floor(w);
    Body b;
    b.motion = Motion::fixed, b.pose.position = {0, 1, 0};
    plate = w.add_body(b);
    Shape board;
    board.kind = ShapeKind::box, board.size = {2, 0.1, 1};
    w.shapes.add(plate, {{board}}), w.collisions.add(plate, {});
    for (int i = 0; i < 3; ++i) on_floor.push_back(add_ball(w, {5.0 + i, 0.1, 0}));
    for (int i = 0; i < 3; ++i) on_plate.push_back(add_ball(w, {-1.0 + i, 1.2, 0}));
    for (Collision& c : w.collisions.values()) c.restitution = 0;
    sim = Simulation(std::move(w));
    for (int i = 0; i < 120; ++i) sim.step();
    REQUIRE(sim.step().asleep == 6);
  }
  void check_falls_alone(Entity e) {
    CHECK(sim.step().asleep == 5);
    for (int i = 0; i < 30; ++i) sim.step();
    CHECK(sim.world.bodies[e].pose.position.y < 0);
  }
  void check_plate_is_gone() {
    CHECK(sim.step().asleep == 3);
    for (int i = 0; i < 25; ++i) sim.step();
    for (const Entity e : on_plate) CHECK(sim.world.bodies[e].pose.position.y < 0.8);
  }
};

}  // namespace

TEST_CASE("what goes wakes only what touched it, not all that stands on the same ground") {
  Sleepers s;
  s.sim.world.destroy(s.on_floor[0]);
  CHECK(s.sim.step().asleep == 5);
  s.sim.world.destroy(s.on_plate[1]);
  CHECK(s.sim.step().asleep == 4);
}

TEST_CASE("a body that is no longer solid falls, the others sleep on") {
  Sleepers s;
  s.sim.world.collisions.remove(s.on_floor[1]);
  s.check_falls_alone(s.on_floor[1]);
}

TEST_CASE("a plate that can be touched no more keeps nobody asleep on it") {
  SECTION("without its Collision") {
    Sleepers s;
    s.sim.world.collisions.remove(s.plate);
    s.check_plate_is_gone();
  }
  SECTION("as a sensor") {
    Sleepers s;
    s.sim.world.collisions[s.plate].sensor = true;
    s.check_plate_is_gone();
  }
  SECTION("of another group") {
    Sleepers s;
    s.sim.world.collisions[s.plate].groups = 2, s.sim.world.collisions[s.plate].with = 2;
    s.check_plate_is_gone();
  }
  SECTION("passed by one ball alone") {
    Sleepers s;
    s.sim.world.collisions[s.on_floor[2]].with = 2;
    s.check_falls_alone(s.on_floor[2]);
  }
}

TEST_CASE("changing what is asleep wakes it") {
  World w;
  add_floor(w);
  const Entity ball = add_ball(w, {0, 0.1, 0});
  Simulation sim = Simulation::copy_of(w);
  for (int i = 0; i < 120; ++i) sim.step();
  REQUIRE(sim.step().asleep == 1);
  sim.world.bodies[ball].gravity_scale = -1;
  sim.world.mark_dirty();
  for (int i = 0; i < 30; ++i) sim.step();
  CHECK(sim.world.bodies[ball].pose.position.y > 0.3);
}

TEST_CASE("building the structure once more changes nothing") {
  // A record or a check may look at the structure before the first step.
  for (int steps : {0, 1, 7}) {
    Simulation once(Zoo().world), often(Zoo().world);
    for (int i = 0; i < steps; ++i) once.step(), often.step();
    for (int i = 0; i < 3; ++i) often.world.mark_dirty(), compile_if_changed(often.world);
    for (int i = 0; i < 30; ++i) {
      once.step(), often.step();
      // The touch is part of no state: but what had begun to calm down is not to begin again.
      for (std::size_t b = 0; b < once.world.bodies.size(); ++b)
        REQUIRE(once.world.bodies.values()[b].pose.position ==
                often.world.bodies.values()[b].pose.position);
    }
    CHECK(state_hash(once.world) == state_hash(often.world));
  }
}

TEST_CASE("measures of a World whose structure changed since the last step are of what there is") {
  Zoo zoo;
  Simulation sim = Simulation::copy_of(zoo.world);
  for (int i = 0; i < 5; ++i) sim.step();
  sim.world.destroy(zoo.balls), sim.world.destroy(zoo.links), sim.world.destroy(zoo.puppet);
  const Measures m = measure(sim.world);
  Real kinetic = 0;
  for (const Body& b : sim.world.bodies.values())
    if (b.motion == Motion::dynamic) kinetic += 0.5 * b.mass * glm::dot(b.velocity, b.velocity);
  CHECK(m.kinetic >= kinetic);
  CHECK(m.worst_gap < 1e-6);
}

TEST_CASE("a force pushed by a system in every substep is as strong as it says") {
  for (int substeps : {1, 2, 5})
    for (Stage place : kEverywhere)
      for (Solver solver : {Solver::articulated, Solver::sweep, Solver::lagrangian}) {
        INFO(substeps << " substeps, place " << static_cast<int>(place) << ", " << name_of(solver));
        World w;
        w.gravity = Vec3(0), w.default_settings.solver = solver;
        Body b;
        b.drag = 0, b.mass = 2;
        const Entity e = w.add_body(b);
        Simulation sim = Simulation::copy_of(w, {0.01, substeps});
        sim.insert(place, [=](World& world, Real) {
          world.push(e, {3, 0, 0}, world.bodies[e].pose.position);
        });
        const int steps = 200;
        for (int i = 0; i < steps; ++i) sim.step();
        // Late in a step it comes to act in the next.
        const Real whole = 3.0 / 2 * 0.01 * steps;
        CHECK(sim.world.bodies[e].velocity.x == Approx(whole).epsilon(0.008));
      }
}

TEST_CASE("a force pushed before a step acts in all its substeps, and in no other step") {
  for (int substeps : {1, 2, 5}) {
    World w;
    w.gravity = Vec3(0), w.default_settings.solver = Solver::lagrangian;
    Body b;
    b.drag = 0, b.mass = 2;
    const Entity e = w.add_body(b);
    Simulation sim = Simulation::copy_of(w, {0.01, substeps});
    sim.world.push(e, {3, 0, 0}, Vec3(0));
    for (int i = 0; i < 3; ++i) sim.step();
    INFO(substeps);
    CHECK(sim.world.bodies[e].velocity.x == Approx(0.015).epsilon(1e-9));
  }
}
