// Cables over pulleys and through rings, by the exact solver.
#include <catch2/catch.hpp>
#include <filesystem>
#include <pantin/joints.hpp>
#include <pantin/measure.hpp>

#include "engine/runtime/save.hpp"
#include "engine/world/cable_route.hpp"
#include "tests/solvers/exact.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81;

Entity ball(World& w, Vec3 at, Real mass) {
  return w.add_body(solid(mass, Vec3(0.004 * mass), {at, kIdentity}));
}

/// Two weights over a fixed pulley.
struct Atwood {
  World world;
  Entity left, right, cable;
};

Atwood atwood(Integrator integrator, Real left, Real right, Vec3 shift = Vec3(0)) {
  Atwood a{exact_world(integrator), {}, {}, {}};
  const Entity ground = add_ground(a.world);
  a.left = ball(a.world, Vec3(-0.2, -1, 0) + shift, left);
  a.right = ball(a.world, {0.2, -1, 0}, right);
  CableJoint cable{.a = a.left, .b = a.right};
  cable.anchor_a = Vec3(-0.2, -1, 0) + shift, cable.anchor_b = {0.2, -1, 0};
  cable.over = {{.body = ground, .point = {0, 0, 0}, .axis = {0, 0, -1}, .radius = 0.2}};
  a.cable = a.world.add(cable).value();
  return a;
}

}  // namespace

TEST_CASE("an Atwood machine falls as it should, with every integrator") {
  for (const Integrator integrator : kAll) {
    Atwood a = atwood(integrator, 1, 3);
    Simulation sim(std::move(a.world), {1.0 / 100});
    for (int i = 0; i < 40; ++i) REQUIRE(sim.step().status == Status::ok);
    const Real acceleration = kG * 2 / 4;
    INFO(name_of(integrator));
    CHECK(sim.world.bodies[a.right].velocity.y == Approx(-acceleration * 0.4).epsilon(1e-9));
    CHECK(sim.world.bodies[a.left].velocity.y == Approx(acceleration * 0.4).epsilon(1e-9));
    CHECK(cable_tension(sim.world, a.cable) == Approx(2 * 1 * 3 / 4.0 * kG).epsilon(1e-8));
  }
}

TEST_CASE("a swinging Atwood machine keeps its energy and its cable's length") {
  for (const Integrator integrator : {Integrator::rattle, Integrator::radau}) {
    Atwood a = atwood(integrator, 1, 1.05, {-0.4, 0.1, 0});
    Simulation sim(std::move(a.world), {1.0 / 400});
    const Real start = measure(sim.world).energy();
    Real worst = 0, gap = 0;
    const auto pose_of = [&](Entity e) { return &sim.world.bodies[e].pose; };
    for (int i = 0; i < 800; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      worst = std::max(worst, std::abs(measure(sim.world).energy() - start));
      gap = std::max(gap, stretch_of(sim.world.cables[a.cable], pose_of));
    }
    INFO(name_of(integrator));
    CHECK(worst <= (integrator == Integrator::radau ? 1e-8 : 2e-4));
    CHECK(gap <= 1e-12);
  }
}

TEST_CASE("a block and tackle holds three times the weight of its counterweight") {
  World w = exact_world(Integrator::radau);
  const Entity ground = add_ground(w);
  const Entity hook = ball(w, {0, -1, 0}, 3);  // hangs from the moving pulley
  const Entity counter = ball(w, {0.5, -0.8, 0}, 1);
  // From the hook up over a fixed pulley, down round the hook's, up over the last to the weight:
  // three parts carry the hook.
  CableJoint c{.a = hook, .b = counter};
  c.anchor_a = {0, -1, 0}, c.anchor_b = {0.5, -0.8, 0};
  c.over = {{.body = ground, .point = {0.05, 0, 0}, .axis = {0, 0, -1}, .radius = 0.05},
            {.body = hook, .point = {0.15, -1, 0}, .axis = {0, 0, 1}, .radius = 0.05},
            {.body = ground, .point = {0.35, 0, 0}, .axis = {0, 0, -1}, .radius = 0.15}};
  const Entity cable = w.add(c).value();
  // What the parts do not hold by symmetry: the hook stays upright on its slide.
  PrismaticJoint guide{.a = ground, .b = hook};
  guide.axis = {0, 1, 0}, guide.anchor = {0, -1, 0};
  REQUIRE(w.add(guide));
  Simulation sim(std::move(w), {1.0 / 100});
  for (int i = 0; i < 300; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(std::abs(sim.world.bodies[hook].pose.position.y + 1) <= 1e-9);
  CHECK(cable_tension(sim.world, cable) == Approx(kG).epsilon(1e-9));
}

namespace {

/// Angular momentum of a ball whose cable is hauled in to half its length within a second.
Real drawn_in(Real rate) {
  World w = exact_world(Integrator::radau, Vec3(0));
  const Entity ground = add_ground(w);
  const Entity mass = ball(w, {1, 0, 0}, 1);
  w.bodies[mass].velocity = {0, 2, 0};
  CableJoint c{.a = mass, .b = ground};
  c.anchor_a = {1, 0, 0}, c.anchor_b = {0, 0, -1}, c.over = {{.body = ground, .point = {0, 0, 0}}};
  const Entity cable = w.add(c).value();
  Simulation sim(std::move(w), {1 / rate});
  REQUIRE(sim.step().status == Status::ok);
  for (int i = 0; i < rate; ++i) {
    const Real part = (i + 1) / rate;
    sim.world.cables[cable].joint.length = 2 - 0.5 * part * part * (3 - 2 * part);
    REQUIRE(sim.step().status == Status::ok);
  }
  const Body& b = sim.world.bodies[mass];
  CHECK(glm::length(b.pose.position) == Approx(0.5).epsilon(1e-9));
  return glm::cross(b.pose.position, b.velocity).z;
}

}  // namespace

TEST_CASE("a ball drawn in through a ring keeps its angular momentum, to first order") {
  const Real coarse = std::abs(drawn_in(400) - 2), fine = std::abs(drawn_in(800) - 2);
  CHECK(coarse <= 3e-3);
  CHECK(fine <= 0.55 * coarse);
}

TEST_CASE("an elastic cable over pulleys stretches by its compliance times its tension") {
  for (const Integrator integrator : {Integrator::rk4, Integrator::radau}) {
    World w = exact_world(integrator);
    const Entity ground = add_ground(w);
    const Entity mass = ball(w, {1, -1, 0}, 2);
    w.bodies[mass].drag = 6;
    CableJoint c{.a = ground, .b = mass};
    c.anchor_a = {0, -1, 0}, c.anchor_b = {1, -1, 0}, c.compliance = 1e-3;
    c.over = {{.body = ground, .point = {0.2, 0, 0}, .axis = {0, 0, -1}, .radius = 0.2},
              {.body = ground, .point = {0.8, 0, 0}, .axis = {0, 0, -1}, .radius = 0.2}};
    const Entity cable = w.add(c).value();
    Simulation sim(std::move(w), {1.0 / 400});
    for (int i = 0; i < 4000; ++i) REQUIRE(sim.step().status == Status::ok);
    INFO(name_of(integrator));
    CHECK(sim.world.bodies[mass].pose.position.y == Approx(-1 - 2 * kG * 1e-3).epsilon(1e-6));
    CHECK(cable_tension(sim.world, cable) == Approx(2 * kG).epsilon(1e-5));
    CHECK(measure(sim.world).elastic == Approx(0.5e-3 * 4 * kG * kG).epsilon(1e-4));
  }
}

TEST_CASE("a slack cable over a pulley does nothing until it is taut") {
  Atwood a = atwood(Integrator::rk4, 1, 1);
  a.world.cables[a.cable].joint.length += 0.5;
  Simulation sim(std::move(a.world), {1.0 / 100});
  for (int i = 0; i < 20; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(sim.world.bodies[a.left].velocity.y == Approx(-kG * 0.2).epsilon(1e-12));
  // Both fall 0.25 m; then the cable stops them, and equal weights balance.
  for (int i = 0; i < 60; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(std::abs(sim.world.bodies[a.left].velocity.y) <= 1e-9);
  CHECK(sim.world.bodies[a.left].pose.position.y == Approx(-1.25).epsilon(1e-9));
}

TEST_CASE("a ball winds its cable round a post at the speed it had, turn after turn") {
  World w = exact_world(Integrator::radau, Vec3(0));
  const Entity ground = add_ground(w);
  const Real radius = 0.03, speed = 2;
  const Entity mass = ball(w, {1, radius, 0}, 1);
  w.bodies[mass].velocity = {0, -speed, 0};
  CableJoint c{.a = ground, .b = mass};
  c.anchor_a = {-radius, -1, 0}, c.anchor_b = {1, radius, 0};
  c.over = {{.body = ground, .axis = {0, 0, -1}, .radius = radius}};
  const Entity cable = w.add(c).value();
  Simulation sim(std::move(w), {1.0 / 200});
  // What is not wound yet: l^2 = 1 - 2 radius speed t.
  const auto left = [&] {
    const Real r = glm::length(sim.world.bodies[mass].pose.position);
    return std::sqrt(r * r - radius * radius);
  };
  for (int i = 1; i <= 1200; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    if (i % 100 == 0)
      CHECK(left() == Approx(std::sqrt(1 - 2 * radius * speed * i / 200)).epsilon(1e-7));
  }
  CHECK(sim.world.cables[cable].guides[0].wrap > 2.5 * 2 * kPi);
  const std::string path = (std::filesystem::temp_directory_path() / "wound.world").string();
  REQUIRE(save_world(sim.world, path));
  Simulation again(load_world(path).value(), {1.0 / 200});
  // Thrown back, it unwinds to where it began.
  for (Simulation* one : {&sim, &again}) {
    one->world.bodies[mass].velocity *= -1;
    for (int i = 0; i < 1200; ++i) REQUIRE(one->step().status == Status::ok);
  }
  CHECK(glm::length(sim.world.bodies[mass].pose.position - Vec3(1, radius, 0)) <= 1e-6);
  CHECK(state_hash(again.world) == state_hash(sim.world));
}

TEST_CASE("a weight whirled round a post out of its plane keeps its cable and its energy") {
  World w = exact_world(Integrator::rattle);
  const Entity ground = add_ground(w);
  const Entity mass = ball(w, {-1, 0.03, 0}, 1);
  w.bodies[mass].velocity = {0, -8, 1};
  CableJoint c{.a = mass, .b = ground};
  c.anchor_a = {-1, 0.03, 0}, c.anchor_b = {0.03, -1, 0};
  c.over = {{.body = ground, .axis = {0, 0, -1}, .radius = 0.03}};
  const Entity cable = w.add(c).value();
  Simulation sim(std::move(w), {1.0 / 400});
  const auto pose_of = [&](Entity e) { return &sim.world.bodies[e].pose; };
  const Real energy = measure(sim.world).energy();
  Real most = 0, least = 10, gap = 0;
  for (int i = 0; i < 480; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    gap = std::max(gap, stretch_of(sim.world.cables[cable], pose_of));
    const Real wrap = sim.world.cables[cable].guides[0].wrap;
    most = std::max(most, wrap), least = std::min(least, wrap);
  }
  CHECK(gap <= 1e-9);
  INFO(least << " to " << most);
  CHECK(most - least > 2 * kPi);
  CHECK(measure(sim.world).energy() == Approx(energy).epsilon(1e-3));
}

TEST_CASE("a weight hauled into its pulley is told, not hidden") {
  for (const Real compliance : {0.0, 1e-4}) {
    Atwood a = atwood(Integrator::radau, 1, 4);
    a.world.cables[a.cable].joint.compliance = compliance;
    Simulation sim(std::move(a.world), {1.0 / 400});
    StepReport report;
    for (int i = 0; i < 400 && report.status == Status::ok; ++i) report = sim.step();
    CHECK(report.status == Status::inconsistent);
    CHECK(report.worst_residual_at == a.cable);
    // It hangs a metre below and rises at 3/5 of g.
    CHECK(report.time == Approx(std::sqrt(2 / (0.6 * kG))).margin(0.02));
  }
}

TEST_CASE("cables over pulleys are saved, and go with their bodies") {
  Atwood a = atwood(Integrator::rk4, 1, 3);
  Simulation sim(std::move(a.world), {1.0 / 100});
  for (int i = 0; i < 10; ++i) sim.step();
  const std::string path = (std::filesystem::temp_directory_path() / "pulleys.world").string();
  REQUIRE(save_world(sim.world, path));
  Simulation again(load_world(path).value(), {1.0 / 100});
  for (int i = 0; i < 10; ++i) sim.step(), again.step();
  CHECK(state_hash(again.world) == state_hash(sim.world));
  const Entity pulley = sim.world.cables[a.cable].guides.front().body;
  sim.world.destroy(pulley);
  CHECK(sim.world.cables.empty());
  CHECK(sim.step().status == Status::ok);
}

TEST_CASE("wrong guides are refused with a line") {
  Atwood a = atwood(Integrator::rk4, 1, 1);
  const auto why = [&](const CableJoint::Guide& guide) {
    CableJoint c{.a = a.left, .b = a.right};
    c.over = {guide};
    const auto added = a.world.add(c);
    return added ? std::string() : added.errors().front().message;
  };
  CHECK(why({.body = a.left, .radius = 0.1}).find("axis") != std::string::npos);
  CHECK(why({.body = a.left, .axis = {0, 0, 1}, .radius = -1}).find("over") != std::string::npos);
  CHECK(why({}).find("over") != std::string::npos);
  const Entity ground = a.world.cables[a.cable].guides.front().body;
  CHECK(why({.body = ground, .point = {0, 0.05, 0}, .axis = {0, 0, 1}, .radius = 0.1})
            .find("overlapping guides") != std::string::npos);
  CableJoint two{.a = a.left, .b = a.right};
  two.over = {{.body = ground, .point = {0, 5, 0}, .axis = {0, 0, 1}, .radius = 0.1},
              {.body = ground, .point = {1, 5, 0}, .axis = {0, 1, 1}, .radius = 0.1}};
  CHECK(!a.world.add(two));
  a.world.default_settings.solver = Solver::sweep;
  CHECK(why({.body = a.left, .axis = {0, 0, 1}, .radius = 0.1}).find("pulley") !=
        std::string::npos);
}
