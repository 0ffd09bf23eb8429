// Towers, walls and crossed layers of free bodies: they stand, bear their weight, and fall asleep.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "engine/pantin/shapes.hpp"
#include "engine/runtime/save.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "tests/solvers/standing.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// A structure, and by how much of its smallest size it may move.
struct Structure : Standing {
  Real size;  // m
  explicit Structure(Real smallest, Real friction = 0.5) : Standing(friction), size(smallest) {}
};

/// `count` blocks one on another; each other one `askew` to either side, the top one heavier.
Structure tower(int count, Vec3 half, Real askew = 0, Real heavier = 1) {
  Structure s(2 * half.y);
  for (int i = 0; i < count; ++i)
    s.add({i % 2 ? askew : -askew, (2 * i + 1) * half.y, 0}, half,
          i + 1 == count ? 1000 * heavier : 1000);
  return s;
}

/// Layers of three bars, each across the one below.
Structure crossed(int layers) {
  const Vec3 half{0.0375, 0.0225, 0.1125};
  Structure s(2 * half.y);
  const Quat across = from_rotation_vector({0, kPi / 2, 0});
  for (int i = 0; i < layers; ++i)
    for (int k = -1; k <= 1; ++k) {
      const Vec3 aside{2 * half.x * k, 0, 0};
      const Quat turn = i % 2 ? across : kIdentity;
      s.add(turn * aside + Vec3(0, (2 * i + 1) * half.y, 0), half, 600, turn);
    }
  return s;
}

/// Bricks in running bond.
Structure wall(int courses, int bricks) {
  const Vec3 half{0.12, 0.035, 0.055};
  Structure s(2 * half.y);
  for (int i = 0; i < courses; ++i)
    for (int k = 0; k < bricks; ++k)
      s.add({2 * half.x * k + (i % 2 ? half.x : 0), (2 * i + 1) * half.y, 0}, half, 1800);
  return s;
}

/// Half a circle of wedges of radius 1 m, of which friction alone bears the steep ones.
Structure arch(int stones) {
  Structure s(0.3);
  for (int i = 0; i < stones; ++i) {
    std::vector<Vec3> corners;
    for (const Real radius : {0.85, 1.15})
      for (const int k : {i, i + 1})
        for (const Real z : {-0.15, 0.15}) {
          const Real angle = kPi * k / stones;
          corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
        }
    const RigidBody stone{.shape = HullShape{.points = corners}, .collision = rough()};
    s.blocks.push_back(s.world.add(stone).value());
  }
  return s;
}

/// Cards of 9 cm that lean on one another by 15 degrees, floor upon floor.
Structure house_of_cards(int floors) {
  const Real length = 0.09, thick = 0.002, lean = kPi / 12;
  const Real high = length * std::cos(lean) + thick * std::sin(lean),
             wide = 2 * (length * std::sin(lean) + thick * std::cos(lean));
  Structure s(thick);
  for (int floor = 0; floor < floors; ++floor) {
    const int pairs = floors - floor;
    const Real low = floor * (high + thick), left = -0.5 * (pairs - 1) * wide;
    for (int k = 0; k < pairs; ++k)
      for (const int side : {-1, 1})
        s.add({left + k * wide + side * wide / 4, low + high / 2, 0}, {thick / 2, length / 2, 0.03},
              700, from_rotation_vector({0, 0, side * lean}));
    for (int k = 0; floor + 1 < floors && k + 1 < pairs; ++k)
      s.add({left + (k + 0.5) * wide, low + high + thick / 2, 0}, {wide / 2, thick / 2, 0.03}, 700);
  }
  return s;
}

/// Dominoes on an arc; the first is pushed over, rad/s.
Structure dominoes(int count, Real push) {
  Structure s(0.035);
  for (int i = 0; i < count; ++i) {
    const Real angle = 0.065 * i;
    s.add({2.2 * std::cos(angle), 0.18, 2.2 * std::sin(angle)}, {0.0175, 0.18, 0.08}, 600,
          from_rotation_vector({0, kPi / 2 - angle, 0}));
  }
  s.world.bodies[s.blocks.front()].angular_velocity = {push, 0, 0};
  return s;
}

}  // namespace

TEST_CASE("towers and walls stand where they were built and sleep within a second") {
  for (const Real h : {1.0 / 30, 1.0 / 60, 1.0 / 240})
    for (const auto& [name, standing] : {
             std::pair("thirty", tower(30, {0.1, 0.075, 0.1}, 1e-3)),
             std::pair("of 1 cm", tower(5, Vec3(0.005))),
             std::pair("of 1 mm", tower(5, Vec3(0.0005))),
             std::pair("60 times as heavy on fifteen", tower(15, Vec3(0.1), 0, 60)),
             std::pair("1,000 times as heavy", tower(2, Vec3(0.1), 0, 1000)),
             std::pair("a million times as heavy", tower(2, Vec3(0.1), 0, 1e6)),
             std::pair("crossed", crossed(18)),
             std::pair("wall", wall(10, 6)),
             std::pair("arch", arch(15)),
             std::pair("cards", house_of_cards(3)),
         }) {
      INFO(name << " at " << h);
      standing.stays(h, 1, 1e-3 * standing.size);
    }
}

TEST_CASE("towers of boxes that would bounce stand as others do") {
  for (const Real h : {1.0 / 60, 1.0 / 240}) {
    Structure s(0.2);
    s.of.restitution = 0.5;
    for (int i = 0; i < 20; ++i) s.add({i % 2 ? 1e-3 : -1e-3, 0.1 + 0.2 * i, 0}, Vec3(0.1));
    s.stays(h, 1.5, 1e-3 * s.size);
  }
}

TEST_CASE("what falls a little comes to rest on what stands, and stays there") {
  for (const Real h : {1.0 / 60, 1.0 / 240}) {
    Structure s(0.2);
    for (int i = 0; i < 10; ++i)
      s.add({i % 2 ? 1e-3 : -1e-3, 0.1 + 0.201 * i, 0}, Vec3(0.1), 1000,
            from_rotation_vector({0, 0.05 * i, 0}));
    Simulation sim = Simulation::copy_of(s.world, {h});
    for (int i = 0; i < std::lround(3 / h); ++i) REQUIRE(sim.step().status == Status::ok);
    for (std::size_t i = 0; i < s.blocks.size(); ++i) {
      INFO(h << " " << i);
      CHECK(is_asleep(sim.world, s.blocks[i]));
      const Vec3 at = sim.world.bodies[s.blocks[i]].pose.position;
      CHECK(std::abs(at.y - (0.1 + 0.2 * static_cast<Real>(i))) < 1e-4);
      CHECK(std::abs(at.x - (i % 2 ? 1e-3 : -1e-3)) < 2e-3);
    }
  }
}

TEST_CASE("dominoes that fell on one another come to rest and sleep") {
  for (const Real push : {3.0, 3.4, 3.8}) {
    const Structure s = dominoes(60, push);
    Simulation sim = Simulation::copy_of(s.world, {1.0 / 60});
    for (int i = 0; i < 480; ++i) REQUIRE(sim.step().status == Status::ok);
    int asleep = 0, fell = 0;
    for (const Entity e : s.blocks) {
      asleep += is_asleep(sim.world, e);
      fell += sim.world.bodies[e].pose.position.y < 0.15;
    }
    INFO(push);
    CHECK(asleep == 60);
    CHECK(fell == 60);
  }
}

TEST_CASE("what is searched for rest in vain goes on as after saving and reading") {
  const Structure s = dominoes(20, 3.4);
  Simulation sim = Simulation::copy_of(s.world, {1.0 / 60});
  const std::string path =
      (std::filesystem::temp_directory_path() / "pantin_resting_groups_test.world").string();
  int waited = 0;
  for (int i = 0; i < 240; ++i) {
    REQUIRE(save_world(sim.world, path));
    Simulation read = Simulation::copy_of(load_world(path).value(), {1.0 / 60});
    read.step(), sim.step();
    REQUIRE(state_hash(read.world) == state_hash(sim.world));
    for (const auto& a : sim.world.memory.of<detail::articulated::Islands>().list)
      waited += a.waits > 0;
  }
  std::filesystem::remove(path);
  CHECK(waited > 3);
}

TEST_CASE("stacks slide as one body, whatever their height and the step") {
  for (const Real h : {1.0 / 30, 1.0 / 60, 1.0 / 240, 1.0 / 960})
    for (const auto& [count, friction] :
         {std::pair(5, 0.1), std::pair(12, 0.05), std::pair(20, 0.03)}) {
      INFO(count << " boxes at " << h);
      Structure s(0.2, friction);
      for (int i = 0; i < count; ++i) s.add({0, 0.1 + 0.2 * i, 0}, Vec3(0.1));
      for (const Entity e : s.blocks) s.world.bodies[e].velocity = {0.6, 0, 0};
      Simulation sim = Simulation::copy_of(s.world, {h});
      const Real slows = friction * 9.81, way = 0.36 / 2 / slows;
      for (int i = 0; i < std::lround((0.6 / slows + 1.5) / h); ++i)
        REQUIRE(sim.step().status == Status::ok);
      for (const Entity e : s.blocks) {
        const Vec3 at = sim.world.bodies[e].pose.position - s.world.bodies[e].pose.position;
        // Velocities are those at the end of a substep of 2.1 ms at most.
        CHECK(std::abs(at.x - way) < 0.6 * 0.0022);
        CHECK(std::abs(at.y) < 2e-5);
        CHECK(std::abs(at.z) < 2e-5);
        CHECK(is_asleep(sim.world, e));
      }
    }
}

TEST_CASE("a tower stands on a slab that starts to move at once") {
  for (const Real h : {1.0 / 60, 1.0 / 240}) {
    World w;
    const Entity slab =
        add_solid(w, box_shape({3, 0.1, 1}), {{0, -0.1, 0}, kIdentity}, Motion::kinematic, rough());
    w.bodies[slab].velocity = {0.1, 0, 0};
    std::vector<Entity> tower;
    for (int i = 0; i < 20; ++i)
      tower.push_back(add_solid(w, box_shape(Vec3(0.1)), {{0, 0.1 + 0.2 * i, 0}, kIdentity},
                                Motion::dynamic, rough()));
    Simulation sim = Simulation::copy_of(w, {h});
    for (int i = 0; i < std::lround(3 / h); ++i) REQUIRE(sim.step().status == Status::ok);
    for (std::size_t i = 0; i < tower.size(); ++i) {
      INFO(h << " " << i);
      const Vec3 at = sim.world.bodies[tower[i]].pose.position;
      CHECK(std::abs(at.x - 0.3) < 0.02);
      CHECK(std::abs(at.y - (0.1 + 0.2 * static_cast<Real>(i))) < 4e-4);
    }
  }
}

TEST_CASE("what leans beyond its base falls, and what is on too steep a slope slides") {
  Structure leaning(0.2);
  for (int i = 0; i < 6; ++i) leaning.add({0.05 * i, 0.1 + 0.2 * i, 0}, Vec3(0.1));
  Simulation falls = Simulation::copy_of(leaning.world, {1.0 / 60});
  for (int i = 0; i < 120; ++i) falls.step();
  CHECK(falls.world.bodies[leaning.blocks.back()].pose.position.y < 0.9);

  for (const Real degrees : {24.0, 28.0}) {  // of 26.57
    World w;
    const Quat tilt = from_rotation_vector({0, 0, -degrees * kPi / 180});
    add_ground(w, rough(), tilt);
    std::vector<Entity> blocks;
    for (int i = 0; i < 5; ++i)
      blocks.push_back(add_solid(w, box_shape({0.2, 0.05, 0.2}),
                                 {tilt * Vec3(0, 0.05 + 0.1 * i, 0), tilt}, Motion::dynamic,
                                 rough()));
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    for (int i = 0; i < 60; ++i) sim.step();
    const Vec3 way = glm::conjugate(tilt) * sim.world.bodies[blocks.front()].pose.position;
    INFO(degrees);
    if (degrees < 26)
      CHECK(std::abs(way.x) < 1e-6);
    else
      CHECK(way.x > 0.05);
  }
}

TEST_CASE("a group at rest notices that friction, weight or a force has changed") {
  const int steps = GENERATE(6, 7);  // forces are found in every other step, else those before hold
  const Real slope = 20 * kPi / 180, g = 9.81;
  const auto stack = [&] {
    Standing s(0.5);
    s.world.gravity = g * Vec3(std::sin(slope), -std::cos(slope), 0);
    for (int i = 0; i < 5; ++i) s.add({0, 0.05 + 0.1 * i, 0}, {0.2, 0.05, 0.2});
    return Simulation::copy_of(s.world, {1.0 / 60});
  };
  using Change = void (*)(World&, Entity);
  const auto moved_by = [&](Change change) {
    Simulation sim = stack();
    for (int i = 0; i < steps; ++i) REQUIRE(sim.step().asleep == 0);
    const Entity top = sim.world.bodies.owners().back();
    const Vec3 from = sim.world.bodies[top].pose.position;
    CHECK(glm::length(from - Vec3(0, 0.45, 0)) < 1e-6);
    change(sim.world, top);
    for (int i = 0; i < 30; ++i) sim.step();
    return sim.world.bodies[top].pose.position - from;
  };
  // a = g (sin - mu cos), for half a second.
  const auto way = [&](Real mu) { return 0.125 * g * (std::sin(slope) - mu * std::cos(slope)); };
  CHECK(glm::length(moved_by([](World&, Entity) {})) < 1e-6);
  CHECK(moved_by([](World& w, Entity top) { w.collisions[top].friction = 0.01; }).x ==
        Approx(way(0.0707)).epsilon(0.02));
  CHECK(moved_by([](World& w, Entity) {
          w.gravity = {0, 9.81, 0};
        }).y == Approx(0.125 * g).epsilon(0.05));
  CHECK(moved_by([](World& w, Entity top) {  // for one step
          w.forces.add(top, {{5 * 9.81 * w.bodies[top].mass, 0, 0}, Vec3(0)});
        })
            .x > 0.05);
}
