// Pose mode of the viewer, without its window.
#include <catch2/catch.hpp>
#include <fstream>
#include <pantin/measure.hpp>
#include <sstream>

#include "tests/paths.hpp"
#include "tests/viewer/bench.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::program;

namespace {

/// Drags with a button from a body's mass centre by some pixels, in pose mode or not.
void drag(const Bench& b, MouseButton button, const char* name, Vec3 by) {
  const Vec3 at = b.on_screen(name);
  b.desk->press(button, at.x, at.y);
  for (int i = 1; i <= 10; ++i) {
    b.desk->move(at.x + 0.1 * i * by.x, at.y + 0.1 * i * by.y);
    b.desk->advance(1.0 / 60, 100);
  }
  b.run(0.5);
  b.desk->release(button, at.x + by.x, at.y + by.y);
}

std::string text_of(const char* scene) {
  std::ifstream file(asset(scene));
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

Real speed_of(const World& world) {
  Real sum = 0;
  for (const Body& body : world.bodies.values())
    sum += glm::length(body.velocity) + glm::length(body.angular_velocity);
  return sum;
}

}  // namespace

TEST_CASE("in pose mode a drag moves the mechanism without dynamics, and time stands still") {
  const Bench b;
  b.desk->key("m");
  REQUIRE(b.desk->is_posing());
  const Vec3 from = b.world().bodies[b.find("lower")].pose.position;
  const Vec3 seen = b.on_screen("lower");
  drag(b, MouseButton::left, "lower", {-40, 50, 0});
  const Vec3 moved = b.on_screen("lower") - seen;
  CHECK(moved.x == Approx(-40).margin(4));  // the point on its front is held, not its centre
  CHECK(moved.y == Approx(50).margin(4));
  CHECK(glm::distance(b.world().bodies[b.find("lower")].pose.position, from) > 0.2);
  const auto at_knee = [&](const char* name, Real side) {
    return to_world(b.world().bodies[b.find(name)].pose, Vec3(side, 0, 0));
  };
  CHECK(glm::distance(at_knee("upper", 0.25), at_knee("lower", -0.25)) < 1e-9);
  CHECK(b.world().time == 0);
  CHECK(b.world().tick == 0);
  const auto& drags = b.desk->panes[0]->hand.drags();
  REQUIRE(drags.size() == 1);
  CHECK(drags[0].grip == "pose");
  CHECK(drags[0].residual < 1e-6);

  // Dynamics go on from the pose, at rest.
  const World posed = b.world();
  b.desk->key("m");
  CHECK(!b.desk->is_posing());
  CHECK(speed_of(b.world()) == 0);
  for (const char* name : {"upper", "lower"})
    CHECK(b.world().bodies[b.find(name)].pose.position == posed.bodies[b.find(name)].pose.position);
  b.run(0.1);
  CHECK(b.world().time == Approx(0.1));
  CHECK(measure(b.world()).worst_gap < 1e-9);
  CHECK(speed_of(b.world()) > 0.1);
}

TEST_CASE("pose mode without a drag leaves the motion as it is, bit for bit") {
  const Bench plain, posed;
  plain.run(0.5), posed.run(0.5);
  posed.desk->key("m");
  posed.run(0.3);
  posed.desk->key("m");
  CHECK(state_hash(posed.world()) == state_hash(plain.world()));
  plain.run(0.5), posed.run(0.5);
  CHECK(state_hash(posed.world()) == state_hash(plain.world()));
}

TEST_CASE("the right button keeps the rotation of a body in pose mode") {
  const Bench b;
  b.desk->key("m");
  const Quat before = b.world().bodies[b.find("lower")].pose.rotation;
  drag(b, MouseButton::right, "lower", {-30, 30, 0});
  const Body& lower = b.world().bodies[b.find("lower")];
  CHECK(std::abs(glm::dot(before, lower.pose.rotation)) > 1 - 1e-9);
  CHECK(lower.pose.position.y < 0.9);
  CHECK(b.desk->panes[0]->hand.drags()[0].grip == "pose_rotation");
  // The left one does not.
  drag(b, MouseButton::left, "lower", {-30, 30, 0});
  CHECK(std::abs(glm::dot(before, lower.pose.rotation)) < 1 - 1e-3);
}

TEST_CASE("points that p holds stay while another body is dragged in pose mode, and limits hold") {
  const Bench b(text_of("scenes/standing.json"));
  const World& world = b.world();
  b.desk->key("m");
  for (const char* name : {"puppet/foot_l", "puppet/foot_r"}) {
    REQUIRE(world.find(name));
    const Vec3 at = b.on_screen(name);
    b.desk->use(Tool::pin, at.x, at.y);
  }
  REQUIRE(world.pins.size() == 2);
  const Entity chest = world.find("puppet/chest");
  const Vec3 before = world.bodies[chest].pose.position;
  drag(b, MouseButton::left, "puppet/chest", {30, 40, 0});
  CHECK(before.y - world.bodies[chest].pose.position.y > 0.05);
  for (const Pin& pin : world.pins.values())
    CHECK(glm::distance(to_world(world.bodies[pin.body].pose, pin.anchor), pin.target) < 1e-6);
  CHECK(measure(world).worst_gap < 1e-6);
  // The knees bend one way only: no limit is passed, nor by a pull that would need it.
  drag(b, MouseButton::left, "puppet/chest", {-60, -120, 0});
  Assembler inside(world);
  CHECK(inside.iterate().joints < 1e-6);
  for (const Pin& pin : world.pins.values())
    CHECK(glm::distance(to_world(world.bodies[pin.body].pose, pin.anchor), pin.target) < 1e-6);
}

TEST_CASE("in pose mode a kinematic body carries what hangs on it, and finds back to its path") {
  const Bench b(text_of("scenes/marionette.json"));
  const World& world = b.world();
  b.run(0.3);
  b.desk->key("m");
  const Entity bar = world.find("pantin/bar");
  REQUIRE(bar);
  REQUIRE(world.paths.find(bar));
  const Vec3 before = world.bodies[bar].pose.position;
  const Vec3 head = world.bodies[world.find("pantin/head")].pose.position;
  drag(b, MouseButton::left, "pantin/bar", {60, -40, 0});
  const Vec3 way = world.bodies[bar].pose.position - before;
  CHECK(glm::length(way) > 0.1);
  CHECK(world.bodies[world.find("pantin/head")].pose.position.y > head.y + 0.5 * way.y);
  b.desk->key("m");
  b.run(1);
  const KinematicPath* path = world.paths.find(bar);
  REQUIRE(path);
  CHECK(glm::distance(world.bodies[bar].pose.position, pose_at(*path, world.time).position) <
        1e-12);
}

TEST_CASE("pose mode moves both panes, and the same way") {
  Bench b;
  b.desk->compare(Solver::lagrangian);
  REQUIRE(b.desk->panes.size() == 2);
  b.desk->key("m");
  drag(b, MouseButton::left, "lower", {-20, 40, 0});
  const Pose one = b.world(0).bodies[b.find("lower")].pose;
  const Pose two = b.world(1).bodies[b.find("lower")].pose;
  CHECK(one.position.y < 0.9);
  CHECK(glm::distance(one.position, two.position) < 1e-12);
  b.desk->key("space");  // ends the mode, too
  CHECK(!b.desk->is_posing());
  CHECK(!b.desk->paused);
  CHECK(b.desk->panes[1]->solver() == "lagrangian");
  b.run(0.1);
  CHECK(b.world(1).time == Approx(0.1));
}

TEST_CASE("a surface joint goes on rolling from the pose it was dragged to") {
  const Bench b(text_of("scenes/turntable.json"));
  b.run(0.2);
  b.desk->key("m");
  const Entity ball = b.world().surface_contacts.values()[0].a;
  const std::string name = b.world().name_of(ball);
  const Vec3 before = b.world().bodies[ball].pose.position;
  drag(b, MouseButton::left, name.c_str(), {30, 10, 0});
  CHECK(glm::distance(b.world().bodies[ball].pose.position, before) > 0.02);
  b.desk->key("m");
  b.run(0.2);
  CHECK(b.desk->status == "ok");
  CHECK(std::abs(b.world().surface_contacts.values()[0].gap) < 1e-9);
}

TEST_CASE("no pose mode for parts that move in a plane") {
  const Bench b(R"({"version": 1, "solver": {"type": "planar"}, "bodies": [
    {"name": "disc", "position": [0, 1, 0], "shape": {"type": "sphere", "radius": 0.1}}]})");
  b.desk->key("m");
  CHECK(!b.desk->is_posing());
  CHECK(b.desk->notes.back().find("pose mode is for mechanisms in space") != std::string::npos);
}
