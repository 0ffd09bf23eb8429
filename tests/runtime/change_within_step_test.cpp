// What is tied to a body that asks for another solver, and islands that change within a step.
#include <catch2/catch.hpp>

#include "engine/contact/contact.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/solvers/lagrangian/island.hpp"
#include "engine/world/ties.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

Entity add_exact(World& w, Vec3 at, Real mass) {
  SolverSettings lagrangian;
  lagrangian.solver = Solver::lagrangian;
  Body b;
  b.drag = 0, b.mass = mass, b.inertia = mass * Vec3(0.01, 0.09, 0.09), b.pose.position = at;
  const Entity e = w.add_body(b);
  w.settings.add(e, lagrangian);
  return e;
}

Entity add_ball(World& w, Vec3 at, const Collision& collision) {
  Body b;
  b.drag = 0, b.mass = 0.5, b.inertia = Vec3(0.002), b.pose.position = at;
  const Entity e = w.add_body(b);
  Shape ball;
  ball.size = {0.1, 0, 0};
  w.shapes.add(e, {{ball}});
  w.collisions.add(e, collision);
  return e;
}

Entity add_floor(World& w) {
  Body b;
  b.motion = Motion::fixed;
  const Entity e = w.add_body(b);
  Shape plane;
  plane.kind = ShapeKind::plane, plane.size = {5, 0, 0};
  w.shapes.add(e, {{plane}});
  w.collisions.add(e, {});
  return e;
}

/// How high a ball jumps that falls from a metre; tied by a slack cable to a body that stays, to a
/// heavy one of the exact solver, or to nothing.
Real jump(int tied, Real restitution) {
  World w;
  add_floor(w);
  Collision c;
  c.restitution = restitution;
  const Entity ball = add_ball(w, {0, 1.1, 0}, c);
  Entity above;
  if (tied == 1) {
    Body hook;
    hook.motion = Motion::fixed, hook.pose.position = {0, 3, 0};
    above = w.add_body(hook);
  }
  if (tied == 2) {
    above = add_exact(w, {0, 3, 0}, 20);
    w.bodies[above].gravity_scale = 0;
  }
  if (tied > 0) add_cable(w, {above, ball, {Vec3(0), Vec3(0), 3.5, 0}});
  Simulation sim = Simulation::copy_of(w, {1.0 / 240});
  Real highest = 0;
  bool hit = false;
  for (int i = 0; i < 300; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    const Body& b = sim.world.bodies[ball];
    hit = hit || b.velocity.y > 0;
    if (hit) highest = std::max(highest, b.pose.position.y - 0.1);
  }
  return highest;
}

/// A beam that flies free and turns, with a rope of three links at its end; all told.
struct Flyer {
  Entity beam, tip;
  std::vector<Entity> all;
};
Flyer add_flyer(World& w, Vec3 at) {
  Flyer f;
  f.beam = add_exact(w, at + Vec3(0.5, 0, 0), 2);
  w.bodies[f.beam].velocity = {0, 1, 0}, w.bodies[f.beam].angular_velocity = {0, 0, 2};
  f.all.push_back(f.beam);
  Entity above = f.beam;
  for (int i = 0; i < 3; ++i) {
    Body b;
    b.drag = 0, b.mass = 0.1, b.inertia = Vec3(1e-4);
    b.pose.position = at + Vec3(1, -0.05 - 0.1 * i, 0);
    f.tip = w.add_body(b);
    f.all.push_back(f.tip);
    if (i > 0) {
      add_link(w, {above, f.tip, {{0, -0.05, 0}, {0, 0.05, 0}}});
    } else {
      Pin p;
      p.body = f.tip, p.anchor = {0, 0.05, 0}, p.to = above, p.target = {0.5, 0, 0};
      w.add_pin(p);
    }
    above = f.tip;
  }
  return f;
}

/// Momentum of a flyer.
Vec3 momentum_of(const World& w, const Flyer& f) {
  Vec3 sum(0);
  for (Entity e : f.all) sum += w.bodies[e].mass * w.bodies[e].velocity;
  return sum;
}

}  // namespace

TEST_CASE("what hangs on a body of the exact solver bounces as it would alone") {
  for (Real restitution : {0.4, 0.8}) {
    const Real alone = jump(0, restitution), fixed = jump(1, restitution);
    INFO("restitution " << restitution);
    CHECK(alone == Approx(restitution * restitution).epsilon(0.01));
    CHECK(fixed == Approx(alone).epsilon(0.005));
    CHECK(jump(2, restitution) == Approx(fixed).epsilon(0.05));  // another method's
  }
}

TEST_CASE("a rope that touches others leaves the momentum of another rope alone") {
  World w;
  w.gravity = Vec3(0);
  const Flyer quiet = add_flyer(w, {0, 0, 0}), busy = add_flyer(w, {20, 0, 0});
  Shape ball;
  ball.size = {0.05, 0, 0};
  Collision c;
  c.others = true;
  w.shapes.add(busy.tip, {{ball}});
  w.collisions.add(busy.tip, c);
  Body b = w.bodies[busy.tip];
  b.pose.position -= Vec3(0, 0.0999, 0), b.mass = 0.4, b.inertia = Vec3(4e-4);
  const Entity other = w.add_body(b);
  w.shapes.add(other, {{ball}});
  w.collisions.add(other, c);
  b.velocity = {0, 3, 0};

  Simulation sim = Simulation::copy_of(w, {1.0 / 240});
  const Vec3 start = momentum_of(sim.world, quiet);
  Real worst = 0;
  bool edit_count = false;
  for (int i = 0; i < 600; ++i) {
    // The other ball is kept against the rope.
    Body& o = sim.world.bodies[other];
    o.pose.position = sim.world.bodies[busy.tip].pose.position - Vec3(0, 0.0999, 0);
    o.velocity = sim.world.bodies[busy.tip].velocity + Vec3(0, 0.05, 0), o.restart = true;
    REQUIRE(sim.step().status == Status::ok);
    for (const Contact& contact : contacts_of(sim.world)) edit_count = edit_count || contact.active;
    worst = std::max(worst, glm::length(momentum_of(sim.world, quiet) - start));
  }
  CHECK(edit_count);
  CHECK(worst <= 1e-11);
}

TEST_CASE("an island that changes within a step goes on alike, whatever changes after it") {
  const auto run = [](bool at_once) {
    World w;
    w.gravity = Vec3(0);
    const Flyer grown = add_flyer(w, {0, 0, 0}), other = add_flyer(w, {20, 0, 0});
    const Entity load = add_exact(w, {0, 2, 0}, 1), spare = add_exact(w, {40, 0, 0}, 1);
    Simulation sim = Simulation::copy_of(w, {1.0 / 240});
    const Vec3 start = momentum_of(sim.world, other);
    int ran = 0;
    const auto remove = [&](World& world) {
      if (ran == 20) world.destroy(spare);
    };
    sim.insert(Stage::before_contacts, [&](World& world, Real) {
      if (++ran == 20) {
        const Pose &beam = world.bodies[grown.beam].pose, &end = world.bodies[load].pose;
        add_link(world, {grown.beam, load, {to_local(beam, end.position), Vec3(0)}});
      }
      if (at_once) remove(world);
    });
    sim.insert(Stage::before_adjust, [&](World& world, Real) {
      if (!at_once) remove(world);
    });
    for (int i = 0; i < 60; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      CHECK(glm::length(momentum_of(sim.world, other) - start) <= 1e-11);
    }
    return sim.world;
  };
  const World one = run(true), two = run(false);
  REQUIRE(one.bodies.size() == two.bodies.size());
  for (std::size_t i = 0; i < one.bodies.size(); ++i)
    CHECK(one.bodies.values()[i].pose.position == two.bodies.values()[i].pose.position);
}

TEST_CASE("a body feels the rope on it from when it is let go until it is held again") {
  World w;
  const Entity beam = add_exact(w, {0, 0, 0}, 2);
  w.bodies[beam].gravity_scale = 0, w.bodies[beam].motion = Motion::fixed;
  Body b;
  b.drag = 0, b.mass = 1, b.inertia = Vec3(1e-2), b.pose.position = {0, -0.5, 0};
  const Entity load = w.add_body(b);
  add_cable(w, {beam, load, {Vec3(0), Vec3(0), 0.5, 0}});
  Simulation sim = Simulation::copy_of(w, {1.0 / 240});
  const auto speed_after = [&](Motion motion) {
    sim.world.bodies[beam].motion = motion, sim.world.mark_dirty();
    for (int i = 0; i < 48; ++i) REQUIRE(sim.step().status == Status::ok);
    return sim.world.bodies[load].velocity.y;
  };
  CHECK(std::abs(speed_after(Motion::fixed)) < 1e-9);
  // The load draws the beam along, which weighs nothing but is twice as inert.
  CHECK(speed_after(Motion::dynamic) == Approx(-9.81 * 0.2 / 3).epsilon(0.02));
  CHECK(sim.world.bodies[beam].velocity.y == Approx(-9.81 * 0.2 / 3).epsilon(0.02));
  sim.world.bodies[beam].velocity = Vec3(0);
  CHECK(std::abs(speed_after(Motion::fixed)) < 1e-6);
}

TEST_CASE("what is tied to a body that cannot be stepped stays where it was, and is named") {
  for (const bool tied : {false, true}) {  // the body with the mass that is none, or its neighbour
    World w;
    const Entity beam = add_exact(w, Vec3(0), 2);
    Body b;
    b.pose.position = {0, -1, 0}, b.mass = tied ? -200 : 0.1;
    const Entity first = w.add_body(b);
    b.pose.position = {0, -2, 0}, b.mass = tied ? 0.1 : -200;
    const Entity second = w.add_body(b);
    add_link(w, {first, second, {{0, -0.5, 0}, {0, 0.5, 0}}});
    Pin p;
    p.body = first, p.anchor = {0, 1, 0}, p.to = beam;
    w.add_pin(p);
    Simulation sim(std::move(w), {1.0 / 60});
    for (int i = 0; i < 60; ++i) CHECK(sim.step().body == (tied ? first : second));
    CHECK(sim.world.bodies[beam].pose.position == Vec3(0));
  }
}
