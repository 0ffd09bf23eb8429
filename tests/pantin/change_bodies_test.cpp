// Blows, sleep, collision and places of bodies in a World that runs; where they are drawn.
#include <catch2/catch.hpp>
#include <cmath>
#include <pantin/pantin.hpp>

#include "tests/pantin/bodies.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kStep = 1.0 / 240;

void run(Simulation& sim, int steps) {
  for (int i = 0; i < steps; ++i) REQUIRE(sim.step().status == Status::ok);
}

Entity add_floor(World& world, Vec3 at = Vec3(0)) {
  return world
      .add(RigidBody{.motion = Motion::fixed,
                     .shape = BoxShape{{2, 0.5, 2}},
                     .position = at - Vec3(0, 0.5, 0),
                     .collision = Collision{}})
      .value();
}

Entity add_box(World& world, Vec3 at) {
  return world
      .add(RigidBody{.shape = BoxShape{{0.2, 0.2, 0.2}}, .position = at, .collision = Collision{}})
      .value();
}

/// Two boxes that sleep, joined by a hinge, and one by itself far away.
struct Sleepers {
  Simulation sim;
  Entity floor, one, two, other, hinge;

  explicit Sleepers(Solver solver) : sim(World{}, {kStep}) {
    World& world = sim.world;
    world.default_settings.solver = solver;
    floor = add_floor(world);
    one = add_box(world, {0, 0.2, 0}), two = add_box(world, {0.5, 0.2, 0});
    other = add_box(world, {-1.5, 0.2, 0});
    hinge = world.add(HingeJoint{.a = one, .b = two, .anchor = {0.25, 0.2, 0}, .axis = {0, 0, 1}})
                .value();
    for (int i = 0; i < 2400 && !(is_asleep(world, one) && is_asleep(world, other)); ++i)
      sim.step();
    REQUIRE(is_asleep(world, one));
    REQUIRE(is_asleep(world, two));
    REQUIRE(is_asleep(world, other));
  }
};

}  // namespace

TEST_CASE("A blow changes momentum at once, where and by how much it says") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian, Solver::planar})
    for (const int substeps : {1, 3}) {
      CAPTURE(name_of(solver), substeps);
      World world;
      world.default_settings.solver = solver;
      world.gravity = Vec3(0);
      const Entity ball = add_ball(world, {0, 0, 0});
      Simulation sim(std::move(world), {kStep, substeps});
      run(sim, 2);
      const Body& b = sim.world.bodies[ball];
      const Real close = solver == Solver::planar ? 1e-6 : 1e-12;  // Box2D reckons in floats
      REQUIRE(impulse(sim.world, ball, {3, 0, 0}, {0, 0.05, 0}));
      REQUIRE(impulse(sim.world, ball, {0, 1, 0}, b.pose.position));
      CHECK(b.velocity == Vec3(0));
      run(sim, 1);
      CHECK(glm::length(b.velocity - Vec3(1.5, 0.5, 0)) < close);
      CHECK(b.angular_velocity.z == Approx(-3 * 0.05 / b.inertia.z).epsilon(1e-6));
      run(sim, 10);
      CHECK(glm::length(b.velocity - Vec3(1.5, 0.5, 0)) < close);  // once
    }
}

TEST_CASE("A blow on one of several jointed bodies moves them as an event's does") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian, Solver::planar}) {
    CAPTURE(name_of(solver));
    World world;
    world.default_settings.solver = solver;
    const Chain chain =
        build_chain(world, {.from = {0, 0, 0}, .to = {0, -1, 0}, .links = 4, .drag = 0}).value();
    const Vec3 point = world.bodies[chain.links[3]].pose.position;
    Simulation by_call = Simulation::copy_of(world, {kStep}), by_event(std::move(world), {kStep});
    REQUIRE(impulse(by_call.world, chain.links[3], {0.02, 0, 0}, point));
    REQUIRE(by_event.world.add(ImpulseEvent{.body = chain.links[3], .impulse = {0.02, 0, 0}}));
    run(by_call, 50), run(by_event, 50);
    for (const Entity e : chain.links)
      CHECK(by_call.world.bodies[e].pose.position == by_event.world.bodies[e].pose.position);
    CHECK(glm::length(by_call.world.bodies[chain.links[3]].velocity) > 0.01);
  }
}

TEST_CASE("A World that is saved between a blow and its step has the blow") {
  World world;
  const Entity ball = add_ball(world, {0, 0, 0});
  REQUIRE(impulse(world, ball, {3, 0, 0}, {0, 0, 0}));
  const std::string file = "blow.world";
  REQUIRE(save_world(world, file));
  World loaded = load_world(file).value();
  std::remove(file.c_str());
  Simulation one(std::move(world), {kStep}), two(std::move(loaded), {kStep});
  run(one, 1), run(two, 1);
  CHECK(one.world.bodies[ball].velocity == two.world.bodies[ball].velocity);
  CHECK(two.world.bodies[ball].velocity.x == Approx(1.5));
}

TEST_CASE("What sleeps is told, and wakes when it is asked to or changed, by itself") {
  for (const Solver solver : {Solver::articulated}) {
    CAPTURE(name_of(solver));
    Sleepers s(solver);
    World& w = s.sim.world;
    CHECK(s.sim.awake_bodies().empty());
    CHECK(!is_asleep(w, s.floor));
    const auto is_awake_alone = [&] {
      run(s.sim, 1);
      CHECK(!is_asleep(w, s.one));
      CHECK(is_asleep(w, s.other));
      return s.sim.awake_bodies().size() == 2;
    };
    SECTION("by wake") {
      CHECK(wake(w, s.one));
      CHECK(!wake(w, s.floor));
      CHECK(is_awake_alone());
    }
    SECTION("by a motor where there was none") {
      REQUIRE(set_motor(w, s.hinge, {MotorKind::velocity, 1, 5000}));
      CHECK(is_awake_alone());
      run(s.sim, 20);
      CHECK(std::abs(joint_angle(w, s.hinge)) > 0.01);
    }
    SECTION("by a limit") {
      REQUIRE(set_limits(w, s.hinge, Interval{0.1, 0.3}));
      CHECK(is_awake_alone());
      run(s.sim, 120);
      CHECK(joint_angle(w, s.hinge) > 0.09);
    }
    SECTION("by a blow") {
      REQUIRE(impulse(w, s.two, {0, 30, 0}, w.bodies[s.two].pose.position));
      CHECK(is_awake_alone());
    }
    SECTION("by gravity") {
      REQUIRE(set_gravity_scale(w, s.two, -1));
      CHECK(is_awake_alone());
      run(s.sim, 60);
      CHECK(w.bodies[s.two].pose.position.y > 0.25);
    }
  }
}

TEST_CASE("A floor that is made a ghost lets go of what slept on it") {
  Sleepers s(Solver::articulated);
  REQUIRE(set_collision(s.sim.world, s.floor, Collision{.with = 0}));
  run(s.sim, 60);
  for (const Entity e : {s.one, s.other}) CHECK(s.sim.world.bodies[e].pose.position.y < 0);
}

TEST_CASE("What sleeps within a body that begins to collide is woken and pushed out") {
  World world;
  const Entity floor = add_floor(world), ghost = add_floor(world, {0, 0.15, 0});
  world.collisions[ghost].with = 0;
  const Entity ball = add_ball(world, {0, 0.1, 0});
  Simulation sim(std::move(world), {kStep});
  run(sim, 240);
  REQUIRE(is_asleep(sim.world, ball));
  SECTION("as its own groups change") {
    REQUIRE(set_collision(sim.world, ghost, sim.world.collisions[floor]));
  }
  SECTION("but not if it collides with none") {
    REQUIRE(set_collision(sim.world, ghost, Collision{.groups = 2, .with = 0}));
    run(sim, 2);
    CHECK(is_asleep(sim.world, ball));
    return;
  }
  run(sim, 2);
  CHECK(!is_asleep(sim.world, ball));
  run(sim, 240);
  CHECK(sim.world.bodies[ball].pose.position.y > 0.24);
}

TEST_CASE("Two bodies ignore each other for a while") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian, Solver::planar}) {
    CAPTURE(name_of(solver));
    World world;
    world.default_settings.solver = solver;
    const Entity upper = add_floor(world), lower = add_floor(world, {0, -2, 0});
    const Entity ball = add_ball(world, {0, 0.1, 0}), stays = add_ball(world, {1, 0.1, 0});
    Simulation sim(std::move(world), {kStep});
    run(sim, 60);
    REQUIRE(ignore(sim.world, ball, upper, 0.6));
    run(sim, 120);
    CHECK(sim.world.bodies[ball].pose.position.y < -0.9);
    run(sim, 240);
    CHECK(sim.world.bodies[ball].pose.position.y == Approx(-1.9).margin(5e-3));
    CHECK(sim.world.bodies[stays].pose.position.y == Approx(0.1).margin(5e-3));
    sim.world.teleport(ball, {{0, 0.1, 0}, kIdentity});
    sim.world.bodies[ball].velocity = Vec3(0);
    run(sim, 120);
    CHECK(sim.world.bodies[ball].pose.position.y == Approx(0.1).margin(5e-3));
    REQUIRE(ignore(sim.world, upper, ball, std::numeric_limits<Real>::infinity()));
    REQUIRE(ignore(sim.world, ball, upper, 0));  // not any more
    run(sim, 120);
    CHECK(sim.world.bodies[ball].pose.position.y == Approx(0.1).margin(5e-3));
    CHECK(lower);
  }
}

TEST_CASE("A figure is set somewhere else as a whole") {
  World world;
  add_floor(world);
  const Ragdoll doll = build_ragdoll(world, {.position = {0, 0.2, 0}}).value();
  Simulation sim(std::move(world), {kStep});
  for (int i = 0; i < 60; ++i) sim.advance(kStep);
  World& w = sim.world;
  const Quat quarter(std::sqrt(0.5), 0, std::sqrt(0.5), 0);
  const Pose to{{5, 3, 1}, quarter}, pelvis = w.origin_pose(doll.pelvis);
  const std::vector<Entity> bodies = doll.bodies();
  REQUIRE(bodies.front() == doll.pelvis);
  const World before = w;
  REQUIRE(teleport(w, bodies, to));
  CHECK(glm::length(w.origin_pose(doll.pelvis).position - to.position) < 1e-12);
  const Quat turn = to.rotation * glm::conjugate(pelvis.rotation);
  for (const Entity e : bodies) {
    const Vec3 was = before.bodies[e].pose.position - pelvis.position;
    CHECK(glm::length(w.bodies[e].pose.position - (to.position + turn * was)) < 1e-12);
    CHECK(glm::length(w.bodies[e].velocity - turn * before.bodies[e].velocity) < 1e-12);
    CHECK(sim.interpolated(e, 0.5).position == w.bodies[e].pose.position);
  }
  const StepReport report = sim.step();
  CHECK(report.status == Status::ok);
  for (const Entity j : doll.joints()) CHECK(std::isfinite(joint_angle(w, j)));

  const Entity hook =
      w.add(PinConstraint{.body = doll.head, .point = {5, 4, 1}, .name = "hook"}).value();
  const auto torn = teleport(w, bodies, pelvis);
  REQUIRE(!torn);
  CHECK(torn.errors().front().message ==
        "teleport: bodies: found 'hook', which ties them to a place, expected all that it ties");
  w.destroy(hook);
  CHECK(!teleport(w, std::span(bodies).subspan(1), pelvis));
  CHECK(teleport(w, bodies, pelvis));
}

TEST_CASE("Bodies are drawn by the frames that they were placed by") {
  World world;
  // Its mass centre and principal axes lie elsewhere.
  const Entity foot = world
                          .add(RigidBody{.shapes = {BoxShape{{0.1, 0.02, 0.05}, {{0.08, 0, 0}}},
                                                    BoxShape{{0.02, 0.1, 0.02}, {{0, 0.1, 0.02}}}},
                                         .position = {1, 2, 3},
                                         .velocity = {4, 0, 0},
                                         .drag = 0})
                          .value();
  world.gravity = Vec3(0);
  Simulation sim(std::move(world), {0.25});
  const auto drawn = [&](Real fraction) {
    const std::span<const DrawnPose> all = sim.drawn_poses(fraction);
    REQUIRE(all.size() == 1);
    CHECK(all[0].body == foot);
    return all[0];
  };
  CHECK(std::abs(std::abs(drawn(0).rotation[3]) - 1) < 1e-6f);
  CHECK(std::abs(drawn(0).position[1] - 2) < 1e-6f);
  sim.advance(0.25);
  CHECK(drawn(0).position[0] == Approx(1).margin(1e-5));
  CHECK(drawn(0.5).position[0] == Approx(1.5).margin(1e-5));
  CHECK(drawn(1).position[0] == Approx(2).margin(1e-5));
}

TEST_CASE("A contact tells its shapes, their materials and how fast they met") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian, Solver::planar}) {
    CAPTURE(name_of(solver));
    World world;
    world.default_settings.solver = solver;
    world.materials = {{"stone"}, {"wood"}, {"iron"}};
    RigidBody floor{
        .motion = Motion::fixed,
        .shapes = {BoxShape{{1, 0.5, 1}, {{-1, -0.5, 0}}}, BoxShape{{1, 0.5, 1}, {{1, -0.5, 0}}}},
        .collision = Collision{}};
    floor.material = 1;
    const Entity ground = world.add(floor).value();
    const Entity ball =
        world
            .add(RigidBody{.shapes = {SphereShape{0.05, {{0, 0.2, 0}}}, SphereShape{0.1}},
                           .mass = 1,
                           .position = {0.5, 0.6, 0},
                           .collision = Collision{.restitution = 0.5},
                           .drag = 0,
                           .material = 2})
            .value();
    Simulation sim(std::move(world), {1.0 / 1000});
    ContactEvents events(sim.world);
    bool met = false;
    for (int i = 0; i < 500 && !met; ++i) {
      run(sim, 1);
      for (const ContactEvent& e : events.update(sim.world)) {
        met = true;
        CHECK(e.phase == ContactPhase::begin);
        CHECK(e.a == ground);
        CHECK(e.b == ball);
        CHECK(e.shape_a == 1);
        CHECK(e.shape_b == 1);
        CHECK(e.material_a == 1);
        CHECK(e.material_b == 2);
        CHECK(e.approach == Approx(std::sqrt(2 * 9.81 * 0.5)).margin(0.03));
      }
    }
    CHECK(met);
  }
}
