// What sleeps is left out of a step: that must change nothing but the time that a step takes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <tuple>

#include "engine/contact/memory.hpp"
#include "engine/pantin/contacts.hpp"
#include "engine/runtime/save.hpp"
#include "engine/runtime/simulation.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr int kHigh = 3;

/// Stacks of boxes in a row, 2 m apart, and a ball that waits beside the first.
struct Stacks {
  World world;
  std::vector<std::vector<Entity>> boxes;
  Entity ball;
};

Stacks stacks(int count) {
  Stacks s;
  add_ground(s.world);
  Collision solid;
  solid.others = true;
  s.boxes.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < kHigh; ++k)
      s.boxes[static_cast<std::size_t>(i)].push_back(
          add_solid(s.world, box_shape(Vec3(0.2, 0.1, 0.2)),
                    {{2.0 * i, 0.1 + 0.2 * k, 0}, kIdentity}, Motion::dynamic, solid));
  s.ball = add_solid(s.world, ball_shape(0.1), {{-1, 0.1, 0}, kIdentity}, Motion::dynamic, solid);
  return s;
}

/// Steps until all sleep, and once more.
Simulation at_rest(const World& world, bool watch = true) {
  Simulation sim = Simulation::copy_of(world, {.watch = watch});
  const int all = static_cast<int>(world.bodies.size()) - 1;
  for (int i = 0; i < 600 && sim.step().asleep < all; ++i) {
  }
  REQUIRE(sim.step().asleep == all);
  return sim;
}

int awake(const Simulation& sim, const std::vector<Entity>& bodies) {
  return static_cast<int>(std::count_if(bodies.begin(), bodies.end(),
                                        [&](Entity e) { return !is_asleep(sim.world, e); }));
}

void send(World& world, Entity body, Vec3 velocity) {
  world.bodies[body].velocity = velocity, world.bodies[body].restart = true;
}

}  // namespace

TEST_CASE("contacts of what sleeps lie apart, in order, and bear the weight") {
  const Stacks s = stacks(3);
  Simulation sim = at_rest(s.world);
  const StepReport report = sim.step();
  CHECK(contacts_of(sim.world).empty());
  CHECK(resting_contacts_of(sim.world).size() >= 3 * kHigh * 3);
  Vec3 on_ground(0);
  Real mass = 0;
  int active = 0;
  std::tuple<std::uint32_t, std::uint32_t, std::uint64_t> last{};
  each_contact(sim.world, [&](const Contact& c) {
    const std::tuple now{c.slot_a, c.slot_b, c.key};
    CHECK(last < now);
    last = now, active += c.active;
    if (c.slot_b == 0) on_ground += c.force;
  });
  for (const Body& b : sim.world.bodies.values()) mass += b.motion == Motion::dynamic ? b.mass : 0;
  CHECK(on_ground.y == Approx(9.81 * mass).epsilon(1e-3));
  CHECK(report.contacts == active);
  CHECK(partition_of(sim.world).awake.empty());
}

TEST_CASE("what is struck wakes with all that it touches, and nothing else does") {
  const Stacks s = stacks(4);
  Simulation sim = at_rest(s.world);
  send(sim.world, s.ball, {4, 0, 0});
  bool struck = false;
  for (int i = 0; i < 60 && !struck; ++i) sim.step(), struck = awake(sim, s.boxes[0]) > 0;
  REQUIRE(struck);
  CHECK(awake(sim, s.boxes[0]) == kHigh);
  CHECK(awake(sim, s.boxes[1]) + awake(sim, s.boxes[2]) + awake(sim, s.boxes[3]) == 0);
  CHECK(std::is_sorted(partition_of(sim.world).awake.begin(), partition_of(sim.world).awake.end()));
  CHECK(sim.findings().empty());
  // Its contacts count again.
  const auto& contacts = contacts_of(sim.world);
  const std::uint32_t top = sim.world.bodies.slot(s.boxes[0].back());
  CHECK(std::any_of(contacts.begin(), contacts.end(),
                    [&](const Contact& c) { return c.slot_a == top || c.slot_b == top; }));
}

TEST_CASE("a heap sleeps beside a ball that rolls past, and wakes where one rolls into it") {
  const Stacks s = stacks(2);
  Simulation sim = at_rest(s.world);
  // Past the first stack, at 1 mm from its side.
  World& w = sim.world;
  w.bodies[s.ball].pose.position = {-0.4, 0.1, 0.301}, w.bodies[s.ball].teleport = true;
  send(w, s.ball, {0.25, 0, 0});
  w.bodies[s.ball].angular_velocity = {0, 0, -2.5};
  const std::string path =
      (std::filesystem::temp_directory_path() / "pantin_sleepers_past.world").string();
  for (int i = 0; i < 180; ++i) {
    REQUIRE(save_world(w, path));
    Simulation read = Simulation::copy_of(load_world(path).value());
    REQUIRE(sim.step().status == Status::ok);
    read.step();
    REQUIRE(state_hash(read.world) == state_hash(w));
    REQUIRE(awake(sim, s.boxes[0]) == 0);
    REQUIRE(!is_asleep(w, s.ball));
  }
  std::filesystem::remove(path);
  CHECK(w.bodies[s.ball].pose.position.x == Approx(0.35).margin(1e-6));
  // On into the second.
  w.bodies[s.ball].pose.position = {1.5, 0.1, 0}, w.bodies[s.ball].teleport = true;
  Real before = 0;
  int woke = 0;
  for (int i = 0; i < 120; ++i) {
    before = std::max(before, w.bodies[s.ball].pose.position.x);
    REQUIRE(sim.step().status == Status::ok);
    woke = std::max(woke, awake(sim, s.boxes[1]));
    REQUIRE(awake(sim, s.boxes[0]) == 0);
  }
  CHECK(woke == kHigh);
  CHECK(before < 1.7 + 1e-4);  // where it touches the side of the stack
  CHECK(before > 1.7 - 1e-3);
}

TEST_CASE("a fast ball that rolls into what sleeps does not enter it, however it is turned") {
  Collision solid;
  solid.others = true;
  for (int phase = 0; phase < 8; ++phase)
    for (const Real speed : {1.0, 5.0, 20.0}) {
      INFO("phase " << phase << ", " << speed << " m/s");
      World w;
      add_solid(w, box_shape({20, 0.5, 5}), {{0, 9.5, 0}, kIdentity}, Motion::fixed, solid);
      const Entity box =
          add_solid(w, box_shape(Vec3(0.2)), {{2 + 0.013 * phase, 10.2, 0}, kIdentity},
                    Motion::dynamic, solid);
      const Entity far =
          add_solid(w, ball_shape(0.1), {{-9, 10.1, 0}, kIdentity}, Motion::dynamic, solid);
      Simulation sim = Simulation::copy_of(w, {});
      for (int i = 0; i < 300 && !is_asleep(sim.world, box); ++i) sim.step();
      REQUIRE(is_asleep(sim.world, box));
      Body& ball = sim.world.bodies[far];
      ball.pose.position = {1, 10.1, 0}, ball.teleport = true;
      ball.pose.rotation = from_rotation_vector({0.3 * phase, 0.2, 0.8 * phase});
      send(sim.world, far, {speed, 0, 0});
      ball.angular_velocity = {0, 0, -speed / 0.1};
      Real deepest = 0;
      for (int i = 0; i < 60; ++i) {
        REQUIRE(sim.step().status == Status::ok);
        const Vec3 a = sim.world.bodies[far].pose.position, b = sim.world.bodies[box].pose.position;
        if (a.y < 10.4) deepest = std::max(deepest, a.x + 0.1 - (b.x - 0.2));  // not above it
      }
      CHECK(deepest < 2e-3);
      CHECK(sim.world.bodies[box].pose.position.x > 2 + 0.013 * phase);
    }
}

TEST_CASE("each step goes on as after saving and reading") {
  const Stacks s = stacks(3);
  Simulation sim = at_rest(s.world);
  send(sim.world, s.ball, {4, 0, 0.2});
  const std::string path =
      (std::filesystem::temp_directory_path() / "pantin_sleepers_test.world").string();
  for (int i = 0; i < 100; ++i) {
    REQUIRE(save_world(sim.world, path));
    Simulation read = Simulation::copy_of(load_world(path).value());
    sim.step(), read.step();
    REQUIRE(state_hash(read.world) == state_hash(sim.world));
  }
  std::filesystem::remove(path);
  CHECK(awake(sim, s.boxes[0]) > 0);
}

TEST_CASE("whatever is changed about a sleeping body wakes its stack alone") {
  const Stacks s = stacks(3);
  const Simulation rest = at_rest(s.world);
  const Entity top = s.boxes[1].back();
  const auto woken_by = [&](const auto& change) {
    Simulation sim = Simulation::copy_of(rest.world);
    sim.step(), change(sim.world), sim.step();
    CHECK(awake(sim, s.boxes[0]) + awake(sim, s.boxes[2]) == 0);
    return awake(sim, s.boxes[1]);
  };
  CHECK(woken_by([&](World&) {}) == 0);
  CHECK(woken_by([&](World& w) { w.bodies[top].velocity.x = 0.1; }) == kHigh);
  CHECK(woken_by([&](World& w) { w.bodies[top].angular_velocity.y = 1; }) == kHigh);
  CHECK(woken_by([&](World& w) { w.bodies[top].restart = true; }) == kHigh);
  CHECK(woken_by([&](World& w) { w.push(top, {1, 0, 0}, w.bodies[top].pose.position); }) == kHigh);
  CHECK(woken_by([&](World& w) {
          w.bodies[top].restart = true;
          w.collisions[s.boxes[1][1]].groups = 0;
        }) >= 2);
}

TEST_CASE("gravity that changes wakes everybody") {
  const Stacks s = stacks(2);
  Simulation sim = at_rest(s.world);
  sim.world.gravity = {0.5, -9.81, 0};
  sim.step();
  CHECK(partition_of(sim.world).awake.size() == 2 * kHigh + 1);
  sim.world.gravity = {0, -9.81, 0};
  CHECK(sim.step().asleep == 0);
}

TEST_CASE("contact events of what sleeps persist") {
  const Stacks s = stacks(2);
  Simulation sim = at_rest(s.world);
  ContactEvents events(sim.world);
  events.update(sim.world);
  const std::size_t count = events.update(sim.world).size();
  CHECK(count == 2 * kHigh + 1);
  for (int i = 0; i < 3; ++i) {
    sim.step();
    const auto now = events.update(sim.world);
    CHECK(now.size() == count);
    for (const ContactEvent& e : now) CHECK(e.phase == ContactPhase::persist);
  }
}

TEST_CASE("a platform that starts to move wakes what sleeps on it") {
  Stacks s = stacks(2);
  Collision solid;
  solid.others = true;
  const Entity lift = add_solid(s.world, box_shape(Vec3(0.5, 0.05, 0.5)), {{-3, 0.5, 0}, kIdentity},
                                Motion::kinematic, solid);
  const Entity rider =
      add_solid(s.world, box_shape(Vec3(0.1)), {{-3, 0.65, 0}, kIdentity}, Motion::dynamic, solid);
  Simulation sim = Simulation::copy_of(s.world);
  for (int i = 0; i < 400; ++i) sim.step();
  REQUIRE(is_asleep(sim.world, rider));
  for (int i = 0; i < 30; ++i) {
    Body& b = sim.world.bodies[lift];
    b.velocity = {0, 0.3, 0}, b.pose.position.y += 0.3 / 60;
    sim.step();
  }
  CHECK(!is_asleep(sim.world, rider));
  CHECK(sim.world.bodies[rider].pose.position.y == Approx(0.65 + 0.15).margin(0.01));
  CHECK(awake(sim, s.boxes[0]) == 0);
  CHECK(sim.findings().empty());
}

TEST_CASE("bodies that come and go among sleepers wake nobody that they do not touch") {
  const Stacks s = stacks(4);
  Simulation sim = at_rest(s.world);
  sim.step();
  const std::size_t resting = resting_contacts_of(sim.world).size();
  Collision solid;
  solid.others = true;
  const auto compare_with_copy = [&] {
    Simulation copy = Simulation::copy_of(sim.world);
    sim.step(), copy.step();
    REQUIRE(state_hash(copy.world) == state_hash(sim.world));
  };
  std::vector<Entity> came;
  for (int k = 0; k < 3; ++k) {
    came.push_back(add_solid(sim.world, ball_shape(0.1), {{1.0 + 2 * k, 3, 0}, kIdentity},
                             Motion::dynamic, solid));
    compare_with_copy();
    CHECK(resting_contacts_of(sim.world).size() == resting);
    CHECK(partition_of(sim.world).awake.size() == came.size());
  }
  // A whole stack, and a ball: what is left moves to other slots.
  for (const Entity e : s.boxes[1]) sim.world.destroy(e);
  sim.world.destroy(came[0]);
  compare_with_copy();
  CHECK(awake(sim, s.boxes[0]) + awake(sim, s.boxes[2]) + awake(sim, s.boxes[3]) == 0);
  CHECK(resting_contacts_of(sim.world).size() < resting);
  for (int i = 0; i < 300; ++i) {
    if (i % 50 == 0) compare_with_copy();
    sim.step();
  }
  CHECK(awake(sim, s.boxes[0]) + awake(sim, s.boxes[2]) + awake(sim, s.boxes[3]) == 0);
  for (const int stack : {0, 2, 3})
    for (int k = 0; k < kHigh; ++k)
      CHECK(sim.world.bodies[s.boxes[std::size_t(stack)][std::size_t(k)]].pose.position.y ==
            Approx(0.1 + 0.2 * k).margin(1e-3));
  CHECK(sim.findings().empty());
}

TEST_CASE("what held a sleeper up and goes wakes it, and what comes under it is felt") {
  Stacks s = stacks(2);
  Simulation sim = at_rest(s.world);
  sim.world.destroy(s.boxes[0][0]);
  sim.step();
  CHECK(awake(sim, {s.boxes[0][1], s.boxes[0][2]}) == 2);
  CHECK(awake(sim, s.boxes[1]) == 0);
  for (int i = 0; i < 300; ++i) sim.step();
  CHECK(sim.world.bodies[s.boxes[0][1]].pose.position.y == Approx(0.1).margin(2e-3));
  // A fixed post that is put into the other stack, from the side.
  Collision solid;
  solid.others = true;
  add_solid(sim.world, box_shape(Vec3(0.05)), {{2.24, 0.3, 0}, kIdentity}, Motion::fixed, solid);
  sim.step();
  CHECK(awake(sim, s.boxes[1]) == kHigh);
}

TEST_CASE("who collides no more wakes, whatever else comes and goes") {
  World w;
  const Entity other = add_solid(w, ball_shape(0.1), {{5, 0.1, 0}, kIdentity}, Motion::dynamic,
                                 Collision{.groups = 2});
  const Entity box = add_solid(w, box_shape(Vec3(0.1)), {{0, 0.1, 0}, kIdentity}, Motion::dynamic);
  add_ground(w, Collision{.with = 1});
  Simulation sim = Simulation::copy_of(w);
  for (int i = 0; i < 200; ++i) sim.step();
  REQUIRE(is_asleep(sim.world, box));
  sim.world.destroy(other);
  sim.world.collisions[box].groups = 2;  // in the place of the one that is gone
  add_solid(sim.world, ball_shape(0.1), {{9, 3, 0}, kIdentity}, Motion::dynamic);
  for (int i = 0; i < 30; ++i) sim.step();
  CHECK(sim.world.bodies[box].pose.position.y < -0.5);
}

TEST_CASE("a shape that takes the place of a sleeper's is felt by what touches it next") {
  const Stacks s = stacks(2);
  Simulation sim = at_rest(s.world);
  const Entity top = s.boxes[1].back();
  const std::size_t before = resting_contacts_of(sim.world).size();
  sim.world.shapes.add(top, Shapes{{box_shape(Vec3(0.05, 0.1, 0.05))}});
  Simulation copy = Simulation::copy_of(sim.world);
  for (int i = 0; i < 3; ++i) {
    sim.step(), copy.step();
    REQUIRE(state_hash(copy.world) == state_hash(sim.world));
  }
  CHECK(resting_contacts_of(sim.world).size() == before);
  Vec3 least(1e9), most(-1e9);
  each_contact(sim.world, [&](const Contact& c) {
    if (c.slot_a != sim.world.bodies.slot(top) && c.slot_b != sim.world.bodies.slot(top)) return;
    const Vec3 at = c.slot_a == sim.world.bodies.slot(top) ? c.point_a : c.point_b;
    least = glm::min(least, at), most = glm::max(most, at);
  });
  CHECK(most.x - least.x == Approx(0.1).margin(1e-3));
}

TEST_CASE("a contact keeps the force that was found, whatever the length of the next step") {
  World w;
  add_ground(w);
  const Entity box =
      add_solid(w, box_shape(Vec3(0.2, 0.1, 0.2)), {{0, 0.1, 0}, kIdentity}, Motion::dynamic);
  Simulation sim = Simulation::copy_of(w);
  int falls = 0;  // asleep after so many steps
  while (!is_asleep(sim.world, box)) REQUIRE((sim.step(), ++falls) < 300);
  const Real weight = 9.81 * w.bodies[box].mass;
  for (const Real h : {1.0 / 240, 1.0 / 20})
    for (int changed = falls - 3; changed <= falls + 1; ++changed) {
      INFO("a step of " << h << " s after " << changed << " of 1/60 s");
      Simulation other = Simulation::copy_of(w);
      for (int i = 0; i < changed; ++i) other.step();
      other.settings.h = h;
      for (int i = 0; i < 400 && !is_asleep(other.world, box); ++i) other.step();
      REQUIRE(is_asleep(other.world, box));
      for (int i = 0; i < 2; ++i) other.step();
      Vec3 force(0);
      each_contact(other.world, [&](const Contact& c) { force += c.force; });
      CHECK(force.y == Approx(weight).epsilon(1e-6));
    }
}

TEST_CASE("the list of who is awake follows bodies that are destroyed within a step") {
  Stacks s = stacks(2);
  Simulation sim = at_rest(s.world);
  send(sim.world, s.ball, {0, 3, 0});
  bool done = false;
  const auto destroy = [&](World& world, Real) {
    if (done) return;
    done = true;
    world.destroy(s.boxes[0].front());  // the last body moves to its slot
    world.destroy(s.ball);
  };
  const auto all_there = [](World& world, Real) {
    for (const std::uint32_t slot : partition_of(world).awake) CHECK(slot < world.bodies.size());
  };
  for (int i = 0; i < 3; ++i) sim.step();
  REQUIRE(partition_of(sim.world).awake.size() == 1);
  REQUIRE(sim.insert(Stage::before_adjust, destroy));
  REQUIRE(sim.insert(Stage::after_step, all_there));
  for (int i = 0; i < 30; ++i) CHECK(sim.step().status == Status::ok);
  CHECK(done);
  CHECK(sim.findings().empty());
}

TEST_CASE("sleepers follow a platform that the caller moves without giving its velocity") {
  for (const Real rate : {-1.0, 1.0}) {
    CAPTURE(rate);
    World w;
    Collision solid;
    solid.others = true;
    const Entity platform =
        add_solid(w, box_shape(Vec3(1, 0.1, 1)), {{0, 2, 0}, kIdentity}, Motion::kinematic, solid);
    const Entity box =
        add_solid(w, box_shape(Vec3(0.2)), {{0, 2.3, 0}, kIdentity}, Motion::dynamic, solid);
    Simulation sim = Simulation::copy_of(w);
    for (int i = 0; i < 300; ++i) sim.step();
    REQUIRE(is_asleep(sim.world, box));
    for (int i = 0; i < 30; ++i) {
      sim.world.bodies[platform].pose.position.y += rate / 60;
      sim.step();
    }
    const Real above =
        sim.world.bodies[box].pose.position.y - sim.world.bodies[platform].pose.position.y;
    CHECK(above > 0.2);
    CHECK(above < 0.4);
    for (int i = 0; i < 300; ++i) sim.step();
    CHECK(is_asleep(sim.world, box));
    CHECK(sim.world.bodies[box].pose.position.y ==
          Approx(sim.world.bodies[platform].pose.position.y + 0.3).margin(1e-3));
  }
}

TEST_CASE("sleepers fall when what bears them is teleported") {
  for (const Motion motion : {Motion::fixed, Motion::kinematic, Motion::dynamic}) {
    CAPTURE(motion);
    World w;
    Collision solid;
    solid.others = true;
    add_ground(w, solid);
    const Entity support =
        add_solid(w, box_shape({0.5, 0.3, 0.5}), {{0, 0.3, 0}, kIdentity}, motion, solid);
    const Entity box =
        add_solid(w, box_shape(Vec3(0.2)), {{0, 0.8, 0}, kIdentity}, Motion::dynamic, solid);
    Simulation sim = Simulation::copy_of(w);
    for (int i = 0; i < 300; ++i) sim.step();
    REQUIRE(is_asleep(sim.world, box));
    REQUIRE(sim.world.teleport(support, {{30, 0.3, 0}, kIdentity}));
    for (int i = 0; i < 120; ++i) sim.step();
    CHECK(sim.world.bodies[box].pose.position.y == Approx(0.2).margin(1e-3));
  }
}
