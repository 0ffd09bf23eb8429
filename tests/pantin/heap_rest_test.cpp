// Heaps of ragdolls come to rest; what swings widely goes on.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

using namespace pantin;

namespace {

Collision solid() {
  Collision collision;
  collision.friction = 0.5, collision.others = true;
  return collision;
}

void add_floor(World& world) {
  const RigidBody floor{.motion = Motion::fixed,
                        .shape = BoxShape{{20, 0.5, 20}},
                        .position = {0, -0.5, 0},
                        .collision = solid()};
  REQUIRE(world.add(floor));
}

/// Ragdolls above one another, each turned another way.
std::vector<Ragdoll> heap_of(World& world, int count) {
  std::vector<Ragdoll> dolls;
  for (int i = 0; i < count; ++i) {
    const Quat turn = glm::angleAxis(1.3 * i + 0.4, glm::normalize(Vec3(0.3, 0.2 * i, 1)));
    dolls.push_back(build_ragdoll(world, {.position = {0.1 * i, 1.2 + 0.7 * i, -0.05 * i},
                                          .rotation = turn,
                                          .collision = solid()})
                        .value());
  }
  return dolls;
}

Real fastest(const World& world) {
  Real most = 0;
  for (const Body& b : world.bodies.values()) most = std::max(most, glm::length(b.velocity));
  return most;
}

}  // namespace

TEST_CASE("heaps of ragdolls fall asleep within ten seconds and wake when one is pulled") {
  World world;
  add_floor(world);
  const std::vector<Ragdoll> dolls = heap_of(world, 5);
  Simulation simulation(std::move(world), {.h = 1.0 / 60});
  StepReport report;
  int awake = 0;
  while (awake < 600 && report.asleep == 0) {
    report = simulation.step(), ++awake;
    REQUIRE(report.status == Status::ok);
  }
  CAPTURE(awake);
  REQUIRE(awake < 600);
  while (awake < 600 && report.asleep < 5) report = simulation.step(), ++awake;
  REQUIRE(report.asleep == 5);
  CHECK(report.worst_depth < 4e-3);
  CHECK(fastest(simulation.world) == 0);
  for (int i = 0; i < 60; ++i) report = simulation.step();
  CHECK(report.asleep == 5);
  for (int i = 0; i < 30; ++i) {
    const Entity pelvis = dolls.back().pelvis;
    const Vec3 at = simulation.world.bodies[pelvis].pose.position;
    REQUIRE(simulation.world.push(pelvis, {0, 2500, 0}, at));
    report = simulation.step();
    CHECK(report.asleep < 5);
  }
  CHECK(simulation.world.bodies[dolls.back().pelvis].velocity.y > 0.2);
}

namespace {

/// A pendulum of 0.5 m at an angle, hung beside a block of forty times its mass. Returns the bob.
Entity add_pendulum(World& world, Vec3 at, Real angle) {
  const Entity block = world
                           .add(RigidBody{.shape = BoxShape{{0.3, 0.2, 0.3}},
                                          .mass = 20,
                                          .position = at,
                                          .collision = solid(),
                                          .drag = 0})
                           .value();
  const Vec3 hook = at + Vec3(0.5, 0, 0), along{0, -std::cos(angle), std::sin(angle)};
  const Entity bob =
      world
          .add(RigidBody{
              .shape = SphereShape{0.05}, .mass = 0.5, .position = hook + 0.5 * along, .drag = 0})
          .value();
  REQUIRE(world.add(BallJoint{.a = block, .b = bob, .anchor = hook}));
  return bob;
}

}  // namespace

TEST_CASE("pendulums go on, unless they tremble, or sway a little on blocks piled up") {
  enum class How { on_one_another, side_by_side };
  struct Case {
    Real angle;  // rad
    int blocks;
    How how;
    bool goes_on;
  };
  for (const Case c :
       {Case{0.6, 1, How::side_by_side, true}, Case{0.2, 1, How::side_by_side, true},
        Case{0.005, 1, How::side_by_side, false}, Case{0.2, 5, How::side_by_side, true},
        Case{0.6, 4, How::on_one_another, true}, Case{0.2, 3, How::on_one_another, true},
        Case{0.2, 4, How::on_one_another, false}}) {
    CAPTURE(c.angle, c.blocks, c.how == How::side_by_side);
    World world;
    add_floor(world);
    Entity bob{};
    for (int i = 0; i < c.blocks; ++i)
      bob = add_pendulum(
          world, c.how == How::side_by_side ? Vec3(0, 0.2, 0.6 * i) : Vec3(0, 0.2 + 0.4 * i, 0),
          c.angle);
    const Real start = world.bodies[bob].pose.position.z - 0.5 * std::sin(c.angle);
    Simulation simulation(std::move(world), {.h = 1.0 / 60});
    StepReport report;
    Real highest = 0;
    for (int i = 0; i < 600; ++i) {
      report = simulation.step();
      REQUIRE(report.status == Status::ok);
      const Real z = simulation.world.bodies[bob].pose.position.z - start;
      if (i >= 480) highest = std::max(highest, std::abs(z));
    }
    CHECK(report.asleep == (c.goes_on ? 0 : c.blocks));
    if (c.goes_on) CHECK(highest == Approx(0.5 * std::sin(c.angle)).epsilon(0.05));
  }
}

TEST_CASE("a jointed body that slides slowly does not fall asleep on its way") {
  // Just steeper than friction holds: a = g (sin a - mu cos a).
  const Real slope = std::atan(0.5) + 0.01, pull = 9.81 * (std::sin(slope) - 0.5 * std::cos(slope));
  World world;
  add_floor(world);
  std::vector<Entity> train;
  for (int i = 0; i < 3; ++i)
    train.push_back(world
                        .add(RigidBody{.shape = BoxShape{{0.1, 0.05, 0.1}},
                                       .mass = 1,
                                       .position = {0.3 * i, 0.05, 0},
                                       .collision = solid(),
                                       .drag = 0})
                        .value());
  for (int i = 1; i < 3; ++i)
    REQUIRE(world.add(
        BallJoint{.a = train[i - 1], .b = train[i], .anchor = {0.3 * i - 0.15, 0.05, 0}}));
  world.gravity = 9.81 * Vec3(std::sin(slope), -std::cos(slope), 0);
  Simulation simulation(std::move(world), {.h = 1.0 / 60});
  const Real start = simulation.world.bodies[train[0]].pose.position.x;
  for (int i = 0; i < 240; ++i) REQUIRE(simulation.step().asleep == 0);
  CHECK(simulation.world.bodies[train[0]].pose.position.x - start ==
        Approx(0.5 * pull * 16).epsilon(0.05));
}
