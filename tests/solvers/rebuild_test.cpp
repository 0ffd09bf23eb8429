// What a change of structure does not concern stays compiled as it is: to the bit as after a whole
// build.
#include "engine/solvers/rebuild.hpp"

#include <catch2/catch.hpp>
#include <pantin/change.hpp>
#include <pantin/figures.hpp>
#include <pantin/joints.hpp>
#include <pantin/must.hpp>
#include <random>

#include "engine/contact/memory.hpp"
#include "engine/pantin/contacts.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

Collision solid() {
  Collision c;
  c.others = true;
  return c;
}

Entity add_box(World& w, Vec3 at, Motion motion = Motion::dynamic) {
  return add_solid(w, box_shape({0.2, 0.1, 0.2}), {at, kIdentity}, motion, solid());
}

/// Boxes on the ground in a row, pairs of which are joined, hung from the world or tied to one
/// another, and a ragdoll, after they have been stepped for a while.
World start() {
  World w;
  add_ground(w);
  std::vector<Entity> boxes;
  for (int i = 0; i < 12; ++i) boxes.push_back(add_box(w, {i, 0.1, 0}));
  for (int i = 0; i < 3; ++i) {
    const Entity a = add_box(w, {i, 2, 3}), b = add_box(w, {i + 0.5, 2, 3});
    must(w.add(BallJoint{.a = a, .b = b, .anchor = {i + 0.25, 2, 3}}));
    must(w.add(CableJoint{
        .a = boxes[0], .b = a, .anchor_a = {0, 0.1, 0}, .anchor_b = {i, 2, 3}, .length = 9}));
    Pin pin;
    pin.body = b, pin.anchor = {0.2, 0, 0}, pin.target = {i + 0.7, 2, 3};
    w.add_pin(pin);
  }
  must(build_ragdoll(w, {.position = {5, 0, 6}}));
  return w;
}

/// A change, chosen at random.
void change(World& w, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  const auto any = [&](const auto& store) { return store.owners()[below(store.size())]; };
  const Vec3 at{Real(below(14)), 1 + Real(below(4)), Real(below(5))};
  const Entity body = any(w.bodies), ground = w.bodies.owners()[0];
  switch (below(12)) {
    case 0:
    case 1:
      add_box(w, at);
      break;
    case 2:
      if (w.bodies.size() < 60) must(build_ragdoll(w, {.position = at}));
      break;
    case 3:
    case 4:
      if (body != ground) w.destroy(body);
      break;
    case 5:
      if (!w.links.empty()) w.destroy(any(w.links));
      break;
    case 6:
      if (!w.pins.empty()) w.destroy(any(w.pins));
      break;
    case 7:
      if (!w.cables.empty()) w.destroy(any(w.cables));
      break;
    case 8:
      if (const Entity other = any(w.bodies);
          other != body && w.bodies[body].motion == Motion::dynamic)
        must(w.add(BallJoint{.a = body, .b = other, .anchor = w.bodies[body].pose.position}));
      break;
    case 9:
      add_box(w, at, Motion::fixed);
      break;
    case 10:
      if (w.bodies[body].motion == Motion::dynamic) must(set_mass(w, body, 3));
      break;
    default:
      if (body != ground && w.collisions.find(body)) w.collisions.remove(body);
  }
}

void build_whole(World& w) { w.memory.of<Partition>().built_for = UINT64_MAX; }

}  // namespace

TEST_CASE("changes of structure give the same bits as a whole build after each") {
  int parts = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    Simulation part = Simulation::copy_of(start());
    for (int i = 0; i < 120; ++i) part.step();
    Simulation whole = Simulation::copy_of(part.world);
    whole.step(), part.step();
    std::mt19937 random(seed), same(seed);
    for (int i = 0; i < 60; ++i) {
      CAPTURE(seed, i);
      for (int k = 0; k < 1 + i % 3; ++k) change(part.world, random), change(whole.world, same);
      World probe = part.world;
      parts += find_rebuild(probe).has_value();
      build_whole(whole.world);
      const StepReport one = part.step(), other = whole.step();
      REQUIRE(state_hash(part.world) == state_hash(whole.world));
      REQUIRE(partition_of(part.world).awake == partition_of(whole.world).awake);
      REQUIRE(partition_of(part.world).island == partition_of(whole.world).island);
      REQUIRE(partition_of(part.world).column == partition_of(whole.world).column);
      REQUIRE(one.asleep == other.asleep);
      REQUIRE(one.contacts == other.contacts);
      REQUIRE(one.worst_depth == other.worst_depth);
      part.step(), whole.step();
      REQUIRE(state_hash(part.world) == state_hash(whole.world));
    }
  }
  CHECK(parts > 300);  // of 360
}

TEST_CASE("a rebuild names the islands that a change concerns, and no others") {
  Simulation sim = Simulation::copy_of(start());
  sim.step();
  const auto rebuilt = [&](const auto& edit) {
    World w = sim.world;
    edit(w);
    const std::optional<Rebuild> r = find_rebuild(w);
    REQUIRE(r);
    std::size_t bodies = 0;
    for (const IslandPlan& plan : r->plans) bodies += plan.slots.size();
    return bodies;
  };
  const World& w = sim.world;
  const Entity lone = w.bodies.owners()[5], tied = w.links.values()[0].a;
  CHECK(rebuilt([&](World& now) { add_box(now, {3, 9, 0}); }) == 1);
  CHECK(rebuilt([&](World& now) { now.destroy(lone); }) == 0);
  CHECK(rebuilt([&](World& now) { must(set_mass(now, lone, 2)); }) == 1);
  CHECK(rebuilt([&](World& now) { now.collisions.remove(lone); }) == 1);
  CHECK(rebuilt([&](World& now) { must(build_ragdoll(now, {.position = {0, 9, 0}})); }) == 13);
  CHECK(rebuilt([&](World& now) {
          must(now.add(BallJoint{.a = lone, .b = now.bodies.owners()[7], .anchor = {5, 0.1, 0}}));
        }) == 2);
  // Six boxes on three cables, and the one that these lead to.
  CHECK(rebuilt([&](World& now) { now.destroy(now.pins.owners()[1]); }) == 7);
  CHECK(rebuilt([&](World& now) { now.destroy(tied); }) == 6);
  CHECK(rebuilt([&](World& now) {
          must(set_cone(now, now.links.owners()[0], ConeLimit{.y = 0.5, .z = 0.5}));
        }) == 7);
}

TEST_CASE("what changes everything, or what a store cannot remember, builds all") {
  Simulation sim = Simulation::copy_of(start());
  sim.step();
  World dirty = sim.world;
  dirty.mark_dirty();
  CHECK_FALSE(find_rebuild(dirty));
  World fixed = sim.world;
  Body b = fixed.bodies[fixed.bodies.owners()[5]];
  b.motion = Motion::fixed;
  fixed.bodies.add(fixed.bodies.owners()[5], b);
  CHECK_FALSE(find_rebuild(fixed));
  World many = sim.world;
  for (int i = 0; i < 1100; ++i) must(set_mass(many, many.bodies.owners()[5], 1 + i % 2));
  CHECK_FALSE(find_rebuild(many));
  World stray = sim.world;
  const Entity gone = stray.bodies.owners()[5];
  stray.destroy(gone);
  stray.bodies.add(gone, Body{});
  CHECK_FALSE(find_rebuild(stray));
}
