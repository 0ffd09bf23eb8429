// Laminas added by programs: as those of scene files, with contact modes read back.
#include <pantin/pantin.hpp>
#include <pantin/scene.hpp>

#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr const char* kRod = R"({
  "version": 1, "gravity": [0, -10, 0],
  "laminas": [{"name": "rod", "outline": [[-0.6, 0], [0.6, 0], [0.6, 0.02], [-0.6, 0.02]],
    "fingers": [
      {"name": "left", "point": [-0.4, 0], "velocity": [0.01, 0], "friction": [0.5, 0.3]},
      {"name": "right", "point": [0.25, 0], "waypoints": [[2, 0.2, 0], [30, -0.1, 0]],
       "friction": [0.5, 0.3]}]}]
})";

LaminaBody rod() {
  return {.outline = {{-0.6, 0, 0}, {0.6, 0, 0}, {0.6, 0.02, 0}, {-0.6, 0.02, 0}},
          .fingers = {{.point = {-0.4, 0, 0},
                       .roll = 0.5,
                       .slide = 0.3,
                       .velocity = {0.01, 0, 0},
                       .name = "left"},
                      {.point = {0.25, 0, 0},
                       .roll = 0.5,
                       .slide = 0.3,
                       .waypoints = {{2, {0.2, 0, 0}}, {30, {-0.1, 0, 0}}},
                       .name = "right"}},
          .name = "rod"};
}

World world_with_gravity() {
  World world;
  world.gravity = {0, -10, 0};
  return world;
}

std::string complaint(const LaminaBody& lamina, Vec3 gravity = {0, -10, 0}) {
  World world;
  world.gravity = gravity;
  const Result<Entity> made = world.add(lamina);
  CHECK(world.entities.alive() == (made ? 1 + lamina.fingers.size() : 0));
  return made ? "" : made.errors().front().message;
}

Vec3 sum_of_forces(const ContactMode& mode) {
  Vec3 sum(0);
  for (const FingerContact& c : mode.contacts) sum += c.force;
  return sum;
}

}  // namespace

TEST_CASE("A lamina of a program moves bit for bit as the same one of a scene file") {
  const Scene scene = good(kRod);
  World world = world_with_gravity();
  const Entity part = world.add(rod()).value();
  Simulation from_file = Simulation::copy_of(scene.world, {scene.step, scene.substeps}),
             built(std::move(world), {scene.step, scene.substeps});
  for (int i = 0; i < 1200; ++i) REQUIRE(from_file.step().status == built.step().status);
  for (const char* name : {"rod", "rod/left", "rod/right"}) {
    const Body &a = from_file.world.bodies[from_file.world.find(name)],
               &b = built.world.bodies[built.world.find(name)];
    CHECK(a.pose.position == b.pose.position);
    CHECK(a.pose.rotation == b.pose.rotation);
    CHECK(a.inertia == b.inertia);
  }
  CHECK(fingers_of(built.world, part) ==
        std::vector<Entity>{built.world.find("rod/left"), built.world.find("rod/right")});
}

TEST_CASE("All contact modes of a lamina are found as it stands, and the one that it moves in") {
  World world = world_with_gravity();
  LaminaBody described = rod();
  described.fingers[1].waypoints.clear(), described.fingers[1].velocity = {-0.01, 0, 0};
  const Entity part = world.add(described).value();
  const std::vector<Entity> fingers = fingers_of(world, part);
  CHECK(contact_modes(world, fingers[0]).empty());
  CHECK_FALSE(contact_mode(world, part));
  const std::vector<ContactMode> all = contact_modes(world, part);
  REQUIRE(all.size() == 2);  // it goes with the left finger, or with the right one
  for (const ContactMode& mode : all) {
    REQUIRE(mode.contacts.size() == 2);
    CHECK(glm::length(sum_of_forces(mode) - Vec3(0, 10, 0)) < 1e-9);
    const bool left_sticks = mode.contacts[0].state == ContactState::sticks;
    CHECK(mode.velocity.x == Approx(left_sticks ? 0.01 : -0.01));
    // It goes right over the right finger, which is to the right of its normal; or left.
    CHECK(mode.contacts[left_sticks ? 1 : 0].state ==
          (left_sticks ? ContactState::slides_right : ContactState::slides_left));
    CHECK(mode.contacts[0].finger == fingers[0]);
    CHECK(mode.contacts[0].normal == Vec3(0, 1, 0));
  }
  CHECK(all[0].velocity.x * all[1].velocity.x < 0);

  Simulation simulation(std::move(world));
  std::optional<ContactMode> now;
  while (!now && simulation.world.time < 5) {
    simulation.step();
    now = contact_mode(simulation.world, part);
  }
  REQUIRE(now);
  CHECK(now->is_stable);
  CHECK(glm::length(sum_of_forces(*now) - Vec3(0, 10, 0)) < 1e-6);
  CHECK(now->velocity.x == Approx(simulation.world.bodies[part].velocity.x).margin(1e-12));
}

TEST_CASE("What pushes a lamina is borne by its fingers") {
  World world;
  world.gravity = Vec3(0);
  LaminaBody described = rod();
  for (LaminaBody::Finger& f : described.fingers) f.velocity = Vec3(0), f.waypoints.clear();
  described.force = {0, -4, 0}, described.torque = 0.2;
  const Entity part = world.add(described).value();
  for (const ContactMode& mode : contact_modes(world, part))
    CHECK(glm::length(sum_of_forces(mode) - Vec3(0, 4, 0)) < 1e-9);
  Simulation simulation(std::move(world));
  for (int i = 0; i < 60; ++i) CHECK(simulation.step().status == Status::ok);
  CHECK(glm::length(simulation.world.bodies[part].pose.position - Vec3(0, 0.01, 0)) < 1e-9);
}

TEST_CASE("Laminas that cannot be meant are refused by member") {
  LaminaBody bad = rod();
  bad.outline.resize(2);
  CHECK(complaint(bad) ==
        "LaminaBody 'rod': outline: found 2 corners, expected three corners or more");
  bad = rod();
  std::swap(bad.outline[1], bad.outline[2]);
  CHECK(complaint(bad).find("outline: found edges from corners") != std::string::npos);
  bad = rod();
  bad.outline[0].z = 1;
  CHECK(complaint(bad) == "LaminaBody 'rod': outline: found (-0.6, 0, 1), expected one with z = 0");
  bad = rod();
  bad.fingers[0].point.y = 0.01;
  CHECK(complaint(bad) ==
        "LaminaBody 'rod': fingers[0].point: found a point 0.01 m inside the outline, expected one "
        "on it or outside");
  bad = rod();
  bad.fingers[0].point = {0.6, 0, 0};
  CHECK(complaint(bad) ==
        "LaminaBody 'rod': fingers[0].point: found a corner of the outline, expected a \"normal\" "
        "too");
  bad = rod();
  bad.fingers[1].waypoints[1].time = 1;
  CHECK(complaint(bad) ==
        "LaminaBody 'rod': fingers[1].waypoints: found time 1 after 2, expected a later one");
  bad = rod();
  bad.fingers[1] = bad.fingers[0];
  CHECK(complaint(bad).find("the name \"left\" again") != std::string::npos);
  CHECK(complaint(rod(), Vec3(0)).find("force: found no load") != std::string::npos);
  bad = rod();
  bad.fingers.clear();
  CHECK(complaint(bad) == "LaminaBody 'rod': fingers: found 0, expected 1 to 32");
  bad = rod();
  bad.mass = 0;
  CHECK(complaint(bad) == "LaminaBody 'rod': mass: found 0, expected a number above 0");
}
