// Towers and frames with joints and cables: they stand, bear their weight, and fall asleep.
#include <catch2/catch.hpp>

#include "engine/pantin/measure.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/exact.hpp"
#include "tests/solvers/standing.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kWeight = 9.81;

/// With light bodies, some of them joined.
struct Frame : Standing {
  Frame() : Standing(0.6) {}
  Entity add(Vec3 at, Vec3 half, Real density = 300) { return Standing::add(at, half, density); }
  void join(Entity a, Entity b, JointKind kind, Vec3 at) {
    add_link(world, {a, b, joint_at(world, a, b, kind, at, frame_along({0, 0, 1}))});
  }
};

/// Boxes of 0.3 m one on another, or `gap` above it.
Frame tower(int count, Real gap = 0) {
  Frame s;
  for (int i = 0; i < count; ++i) s.add({0, 0.15 + gap + (0.3 + gap) * i, 0}, Vec3(0.15));
  return s;
}

/// With a pole of 50 g on the top box.
Frame flag(int count, Real gap = 0) {
  Frame s = tower(count, gap);
  const Real top = (0.3 + gap) * count;
  const Entity pole = s.add({0, top + 0.15, 0}, {0.01, 0.15, 0.01});
  s.world.bodies[pole].mass = 0.05;
  s.join(s.blocks[static_cast<std::size_t>(count) - 1], pole, JointKind::fixed, {0, top, 0});
  return s;
}

/// With cables between neighbours that are never taut.
Frame loosely_tied(int count) {
  Frame s = tower(count);
  for (std::size_t i = 1; i < s.blocks.size(); ++i)
    add_cable(s.world, {s.blocks[i - 1], s.blocks[i], {Vec3(0), Vec3(0), 0.35, 0}});
  return s;
}

/// Layers of two boxes joined by `kind`, each layer across the one below.
Frame pairs(int layers, JointKind kind) {
  Frame s;
  for (int i = 0; i < layers; ++i) {
    const Vec3 aside = i % 2 ? Vec3(0, 0, 0.15) : Vec3(0.15, 0, 0), at(0, 0.15 + 0.3 * i, 0);
    const Entity a = s.add(at - aside, Vec3(0.15)), b = s.add(at + aside, Vec3(0.15));
    s.join(a, b, kind, at);
  }
  return s;
}

/// A table of 5 kg, top and legs joined, under a load.
Frame table(Real load) {
  Frame s;
  const Entity top = s.add({0, 0.55, 0}, {0.5, 0.05, 0.5});
  s.world.bodies[top].mass = 1;
  for (const Real x : {-0.45, 0.45})
    for (const Real z : {-0.45, 0.45}) {
      const Entity leg = s.add({x, 0.25, z}, {0.05, 0.25, 0.05});
      s.world.bodies[leg].mass = 1;
      s.join(top, leg, JointKind::fixed, {x, 0.5, z});
    }
  const Entity box = s.add({0, 0.8, 0}, Vec3(0.2));
  s.world.bodies[box].inertia *= load / s.world.bodies[box].mass;
  s.world.bodies[box].mass = load;
  return s;
}

Real farthest_moved(const World& now, const World& start, const std::vector<Entity>& blocks) {
  Real most = 0;
  for (const Entity e : blocks)
    most =
        std::max(most, glm::distance(now.bodies[e].pose.position, start.bodies[e].pose.position));
  return most;
}

}  // namespace

TEST_CASE("towers and frames with joints and slack cables stand still, bear and sleep") {
  for (const Real h : {1.0 / 30, 1.0 / 60, 1.0 / 240})
    for (const auto& [name, standing] : {
             std::pair("pole on ten", flag(10)),
             std::pair("ten, loosely tied", loosely_tied(10)),
             std::pair("pairs of fixed joints", pairs(10, JointKind::fixed)),
             std::pair("pairs of ball joints", pairs(5, JointKind::ball)),
             std::pair("pairs of hinges", pairs(5, JointKind::hinge)),
             std::pair("table under 20 times its weight", table(100)),
             std::pair("table under 2,000 times its weight", table(10000)),
         }) {
      INFO(name << " at " << h);
      standing.stays(h, 2, 1e-4);
    }
}

TEST_CASE("a tower with a pole that falls a little comes to rest and stays there") {
  for (const Real h : {1.0 / 30, 1.0 / 60, 1.0 / 240}) {
    const Frame s = flag(10, 1e-3);
    Simulation sim = Simulation::copy_of(s.world, {h});
    for (int i = 0; i < std::lround(4 / h); ++i) REQUIRE(sim.step().status == Status::ok);
    INFO("step " << h);
    for (std::size_t i = 0; i < 10; ++i) {
      const Vec3 at = sim.world.bodies[s.blocks[i]].pose.position;
      CHECK(std::abs(at.y - (0.15 + 0.3 * static_cast<Real>(i))) < 1e-3);
      CHECK(std::hypot(at.x, at.z) < 2e-3);
      CHECK(is_asleep(sim.world, s.blocks[i]));
    }
  }
}

TEST_CASE("a tower stands under a pendulum that swings from it") {
  for (const Real h : {1.0 / 30, 1.0 / 60, 1.0 / 240}) {
    Frame s = tower(10);
    const std::vector<Entity> boxes = s.blocks;
    const Entity bob = s.add({0.3, 2.85, 0}, Vec3(0.05), 500);
    s.join(boxes.back(), bob, JointKind::ball, {0.2, 2.95, 0});
    Simulation sim = Simulation::copy_of(s.world, {h});
    const World start = sim.world;
    const Real mass = start.bodies[bob].mass;
    // N: the bob of a pendulum that starts at 45 degrees pulls with less than three weights.
    const Real weight = kWeight * (s.mass() - mass), pull = 3 * kWeight * mass;
    Real least = 1, most = -1;
    INFO("step " << h);
    for (int i = 0; i < std::lround(10 / h); ++i) {
      REQUIRE(sim.step().status == Status::ok);
      if (i < std::lround(1 / h)) continue;
      CHECK(std::abs(borne_by_ground(sim.world) - weight) < pull);
      const Real x = sim.world.bodies[bob].pose.position.x;
      least = std::min(least, x), most = std::max(most, x);
    }
    CHECK(farthest_moved(sim.world, start, boxes) < 1e-4);
    CHECK(most > 0.28);
    CHECK(least < 0.12);
  }
}

TEST_CASE("a flap on its limit bears a load with the torque of statics") {
  for (const Real h : {1.0 / 30, 1.0 / 60, 1.0 / 240}) {
    Frame s;
    const Entity flap = s.add({0.5, 1, 0}, {0.5, 0.025, 0.25});
    const Entity box = s.add({0.5, 1.125, 0}, Vec3(0.1), 2500);
    Joint hinge =
        joint_at(s.world, s.ground, flap, JointKind::hinge, {0, 1, 0}, frame_along({0, 0, 1}));
    hinge.limits.edit().angle = {true, 0, 1};
    const Entity joint = add_link(s.world, {s.ground, flap, hinge});
    Simulation sim = Simulation::copy_of(s.world, {h});
    for (int i = 0; i < std::lround(1 / h); ++i) REQUIRE(sim.step().status == Status::ok);
    INFO("step " << h);
    CHECK(std::abs(sim.world.bodies[flap].pose.position.y - 1) < 1e-6);
    CHECK(is_asleep(sim.world, box));
    const Real moment = 0.5 * kWeight * s.mass();
    CHECK(std::abs(joint_reaction(sim.world, joint)->torque.z) == Approx(moment).epsilon(1e-3));
  }
}

TEST_CASE("a pair of boxes slides where friction cannot hold it, and falls beyond its base") {
  for (const Real friction : {0.4, 0.5}) {
    World w;
    const Quat tilt = from_rotation_vector({0, 0, -std::atan(0.45)});
    const Entity ground = add_ground(w, rough(friction), tilt);
    Entity boxes[2];
    for (int i = 0; i < 2; ++i)
      boxes[i] = add_solid(w, box_shape(Vec3(0.15)), {tilt * Vec3(0.3 * i, 0.15, 0), tilt},
                           Motion::dynamic, rough(friction));
    add_link(w, {boxes[0], boxes[1],
                 joint_at(w, boxes[0], boxes[1], JointKind::fixed, tilt * Vec3(0.15, 0.15, 0),
                          kIdentity)});
    Simulation sim(std::move(w), {1.0 / 60});
    for (int i = 0; i < 60; ++i) sim.step();
    const Vec3 way = glm::conjugate(tilt) * sim.world.bodies[boxes[0]].pose.position;
    const Real slope = std::atan(0.45);
    const Real slid = 0.5 * kWeight * (std::sin(slope) - friction * std::cos(slope));
    INFO("friction " << friction << " on ground " << ground.index);
    CHECK(way.x == Approx(std::max(Real(0), slid)).margin(0.02 * 0.23));
  }
  for (const Real offset : {0.14, 0.16}) {
    Frame s;
    s.add({0, 0.15, 0}, Vec3(0.15), 2000);
    const Entity a = s.add({offset - 0.2, 0.4, 0}, {0.2, 0.1, 0.15});
    const Entity b = s.add({offset + 0.2, 0.4, 0}, {0.2, 0.1, 0.15});
    s.join(a, b, JointKind::fixed, {offset, 0.4, 0});
    Simulation sim = Simulation::copy_of(s.world, {1.0 / 60});
    for (int i = 0; i < 120; ++i) sim.step();
    INFO("centre of mass at " << offset << " of 0.15 m");
    if (offset < 0.15)
      CHECK(std::abs(sim.world.bodies[b].pose.position.y - 0.4) < 1e-5);
    else
      CHECK(sim.world.bodies[b].pose.position.y < 0.3);
  }
}

TEST_CASE("what sleeps under a slack cable wakes when the cable is shortened") {
  Frame s = tower(4);
  const Entity cable =
      add_cable(s.world, {s.ground, s.blocks.back(), {{0, 3, 0}, {0, 0.15, 0}, 2, 0}});
  Simulation sim = Simulation::copy_of(s.world, {1.0 / 60});
  for (int i = 0; i < 60; ++i) sim.step();
  REQUIRE(is_asleep(sim.world, s.blocks.back()));
  for (int i = 0; i < 240; ++i) {
    Real& length = sim.world.cables[cable].joint.length;
    length = std::max(Real(1.6), length - 0.2 / 60);
    sim.step();
  }
  CHECK(sim.world.bodies[s.blocks.back()].pose.position.y == Approx(3 - 1.6 - 0.15).margin(1e-3));
}
