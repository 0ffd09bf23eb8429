// The viewer without its window.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <pantin/measure.hpp>

#include "tests/paths.hpp"
#include "tests/viewer/bench.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::program;

namespace fs = std::filesystem;

namespace {

/// A pixel that shows no body.
const Vec3 kNowhere{20, 20, 0};

}  // namespace

TEST_CASE("the left button on nothing turns the camera about its target, the right one moves it") {
  const Bench b;
  const Camera before = b.desk->view().camera;
  b.desk->press(MouseButton::left, 20, 20);
  b.desk->move(70, 20);
  b.desk->release(MouseButton::left, 70, 20);
  const Camera turned = b.desk->view().camera;
  CHECK(turned.target == before.target);
  CHECK(glm::distance(turned.eye, turned.target) ==
        Approx(glm::distance(before.eye, before.target)));
  CHECK(glm::distance(turned.eye, before.eye) > 0.5);

  // What was under the mouse is under it still.
  const Vec3 seen = b.desk->eye().project(turned.target);
  b.desk->press(MouseButton::right, 20, 20);
  b.desk->move(60, 50);
  b.desk->release(MouseButton::right, 60, 50);
  const Vec3 moved = b.desk->eye().project(turned.target);
  CHECK(moved.x - seen.x == Approx(40).margin(0.5));
  CHECK(moved.y - seen.y == Approx(30).margin(0.5));

  b.desk->key("home");
  CHECK(b.desk->view().camera.eye == before.eye);
  CHECK(b.desk->view().camera.target == before.target);
}

TEST_CASE("alt turns the camera where a body would be dragged, arrows and the wheel lead it too") {
  const Bench b;
  const Camera before = b.desk->view().camera;
  const Vec3 body = b.on_screen("upper");
  b.desk->hold({.shift = false, .alt = true});
  b.desk->press(MouseButton::left, body.x, body.y);
  CHECK(!b.desk->panes[0]->hand.holds());
  b.desk->move(body.x + 30, body.y);
  b.desk->release(MouseButton::left, body.x + 30, body.y);
  CHECK(b.desk->view().camera.eye != before.eye);
  b.desk->hold({});
  b.desk->key("home");
  b.desk->key("right");
  CHECK(b.desk->view().camera.eye.x > 0.5);
  b.desk->key("up");
  CHECK(b.desk->view().camera.eye.y > 1.5);
  const Real far = glm::distance(b.desk->view().camera.eye, b.desk->view().camera.target);
  b.desk->wheel(1, 0);
  CHECK(glm::distance(b.desk->view().camera.eye, b.desk->view().camera.target) ==
        Approx(0.9 * far));
}

TEST_CASE("the camera follows a body, and lets go") {
  const Bench b;
  const Vec3 at = b.on_screen("lower");
  b.desk->move(at.x, at.y);
  b.desk->look_under_mouse();
  REQUIRE(b.desk->is_under);
  b.desk->key("l");
  b.run(0.4);
  const Vec3 place = b.desk->panes[0]->poses[b.world().bodies.slot(b.find("lower"))].position;
  CHECK(glm::distance(b.desk->view().camera.target, place) < 1e-12);
  CHECK(glm::distance(b.desk->view().camera.eye, place) == Approx(4));
  CHECK(place.y < 0.9);
  b.desk->key("l");
  const Vec3 left = b.desk->view().camera.target;
  b.run(0.2);
  CHECK(b.desk->view().camera.target == left);
}

TEST_CASE("a file that is written again is read again, and the camera stays") {
  Bench b;
  b.desk->wheel(2, 0);
  b.desk->press(MouseButton::left, 20, 20);
  b.desk->move(90, 40);
  b.desk->release(MouseButton::left, 90, 40);
  const Camera before = b.desk->view().camera;
  b.run(0.2);
  b.desk->watch();
  CHECK(b.desk->scene().title == "Two rods");
  std::string other = kPendulum;
  other.replace(other.find("Two rods"), 8, "New rods");
  b.write(other);
  b.touch_later();
  b.desk->watch();  // seen, perhaps not yet whole
  CHECK(b.desk->scene().title == "Two rods");
  b.desk->watch();
  CHECK(b.desk->scene().title == "New rods");
  CHECK(b.world().tick == 0);
  CHECK(b.desk->view().camera.eye == before.eye);
  CHECK(b.desk->view().camera.target == before.target);
  CHECK(!b.desk->is_trouble);
}

TEST_CASE("after another scene was saved the camera goes home to where that scene wants it") {
  Bench b;
  std::string other = kPendulum;
  other.replace(other.find("[0, 1, 4]"), 9, "[0, 2, 7]");
  b.write(other);
  b.touch_later();
  b.desk->watch(), b.desk->watch();
  CHECK(b.desk->view().camera.eye == Vec3(0, 1, 4));
  b.desk->key("home");
  CHECK(b.desk->view().camera.eye == Vec3(0, 2, 7));
}

TEST_CASE("what is wrong with a changed file is told, and the scene stays until it is mended") {
  Bench b;
  b.run(0.5);
  const std::uint64_t hash = state_hash(b.world());
  b.write(R"({"version": 1, "bodies": [{"nme": "x"}]})");
  b.touch_later();
  b.desk->watch(), b.desk->watch();
  CHECK(b.desk->is_trouble);
  CHECK(b.desk->message.find("scene.json:1:") != std::string::npos);
  CHECK(b.desk->message.find("and 2 more") != std::string::npos);
  CHECK(state_hash(b.world()) == hash);
  b.run(0.1);
  CHECK(b.world().tick == 36);
  b.desk->watch();
  b.write(kPendulum);
  fs::last_write_time(b.path, fs::last_write_time(b.path) + std::chrono::seconds(4));
  b.desk->watch(), b.desk->watch();
  CHECK(!b.desk->is_trouble);
  CHECK(b.world().tick == 0);
}

TEST_CASE("a mesh that the scene names is watched like the scene's own file") {
  Bench b;
  const auto write_rock = [&](const std::string& size) {
    static int seconds = 0;
    b.write("v 0 0 0\nv " + size + " 0 0\nv 0 1 0\nv 0 0 1\n", "rock.obj");
    const fs::path rock = b.folder / "rock.obj";
    fs::last_write_time(rock, fs::last_write_time(rock) + std::chrono::seconds(2 * ++seconds));
    b.desk->watch(), b.desk->watch();
  };
  const auto width = [&] {
    const Surface& rock = *b.world().shapes[b.find("rock")].list[0].surface;
    return rock.high.x - rock.low.x;
  };
  write_rock("1");
  b.write(R"({"version": 1, "bodies": [{"name": "rock",
              "shape": {"type": "hull", "file": "rock.obj"}}]})");
  b.touch_later();
  b.desk->watch(), b.desk->watch();
  REQUIRE(b.find("rock"));
  CHECK(width() == Approx(1));
  write_rock("2");
  CHECK(width() == Approx(2));
  write_rock("no number");
  CHECK(b.desk->is_trouble);
  CHECK(width() == Approx(2));
  write_rock("3");
  CHECK(!b.desk->is_trouble);
  CHECK(width() == Approx(3));
}

TEST_CASE("the scenes of a folder are leafed through, past one that cannot be read") {
  Bench b;
  b.write("{", "t_broken.json");
  std::string other = kPendulum;
  other.replace(other.find("Two rods"), 8, "Last one");
  b.write(other, "z_last.json5");
  b.write("{}", "scene.schema.json"), b.write("", "notes.txt");
  b.desk->reload();
  REQUIRE(b.desk->scenes().size() == 3);
  b.desk->key("page_down");
  CHECK(b.desk->is_trouble);
  CHECK(b.desk->scene().title == "Two rods");
  b.desk->key("page_down");
  CHECK(b.desk->scene().title == "Last one");
  CHECK(fs::path(b.desk->path()).filename() == "z_last.json5");
  b.desk->key("page_down");
  CHECK(b.desk->scene().title == "Two rods");
}

TEST_CASE("the joint under the mouse is cut, in both panes") {
  const Bench b;
  b.desk->compare(Solver::lagrangian);
  const Vec3 at = b.desk->eye().project(Vec3(0.5, 1, 0));
  b.desk->use(Tool::cut, at.x, at.y);
  CHECK(b.world(0).links.size() == 1);
  CHECK(b.world(1).links.size() == 1);
  CHECK(b.desk->message == "cut knee");
  b.run(0.5);
  const Real drop = 1 - b.world().bodies[b.find("lower")].pose.position.y;
  CHECK(drop == Approx(0.5 * 9.81 * 0.25).epsilon(0.05));  // it falls freely
  b.desk->use(Tool::cut, kNowhere.x, kNowhere.y);
  CHECK(b.desk->message == "nothing to cut under the mouse");
}

TEST_CASE("a pin by hand holds a body where it is until it is taken off") {
  const Bench b;
  const Vec3 at = b.on_screen("lower");
  b.desk->use(Tool::pin, at.x, at.y);
  REQUIRE(b.world().pins.size() == 1);
  const Pin pin = b.world().pins.values()[0];
  b.run(1);
  CHECK(glm::distance(to_world(b.world().bodies[pin.body].pose, pin.anchor), pin.target) < 1e-3);
  const Vec3 now = b.on_screen("lower");
  b.desk->use(Tool::pin, now.x, now.y);
  CHECK(b.world().pins.size() == 0);
  b.run(0.5);
  CHECK(glm::distance(to_world(b.world().bodies[pin.body].pose, pin.anchor), pin.target) > 0.1);
}

TEST_CASE("a ball is shot at what is under the mouse and pushes it") {
  const Bench b, still;
  const std::size_t before = b.world().bodies.size();
  b.desk->gun = {0.05, 2, 8};
  b.desk->turn("gravity", 0), still.desk->turn("gravity", 0);
  const Vec3 at = b.on_screen("lower");
  b.desk->use(Tool::ball, at.x, at.y);
  REQUIRE(b.world().bodies.size() == before + 1);
  b.run(0.8), still.run(0.8);
  const Vec3 hit = b.world().bodies[b.find("lower")].pose.position;
  const Vec3 missed = still.world().bodies[still.find("lower")].pose.position;
  CHECK(hit.z < missed.z - 0.05);  // away from the camera
  b.desk->restart();
  CHECK(b.world().bodies.size() == before);
}

TEST_CASE("balls that are far away are let go, and of many the oldest") {
  const Bench b;
  const std::size_t before = b.world().bodies.size();
  b.desk->gun = {0.05, 1, 200};
  for (int i = 0; i < 40; ++i) b.desk->use(Tool::ball, kNowhere.x, kNowhere.y);
  CHECK(b.world().bodies.size() == before + 30);
  b.run(2);
  CHECK(b.world().bodies.size() == before);
}

TEST_CASE("two panes run by two solvers on one clock, and a drag takes both") {
  const Bench b;
  b.run(0.3);
  b.desk->compare(Solver::lagrangian);
  REQUIRE(b.desk->panes.size() == 2);
  CHECK(b.desk->pane_width() == 320);
  CHECK(b.world(0).tick == b.world(1).tick);
  CHECK(b.desk->panes[1]->solver() == "lagrangian");
  CHECK(b.desk->panes[0]->solver() == "auto");
  b.run(0.5);
  CHECK(b.world(0).tick == b.world(1).tick);
  const Vec3 one = b.world(0).bodies[b.find("lower")].pose.position;
  const Vec3 two = b.world(1).bodies[b.find("lower")].pose.position;
  CHECK(one != two);
  CHECK(glm::distance(one, two) < 0.02);  // both solve the same equations

  const Vec3 at = b.desk->eye().project(b.desk->panes[1]->poses[1].position);
  b.desk->press(MouseButton::left, at.x + 320, at.y);
  CHECK(b.desk->panes[0]->hand.holds());
  CHECK(b.desk->panes[1]->hand.holds());
  b.desk->release(MouseButton::left, at.x + 320, at.y);
  b.desk->compare(std::nullopt);
  CHECK(b.desk->panes.size() == 1);
}

TEST_CASE("knobs turn what runs, hold after a restart, and go back with the file") {
  const Bench b;
  CHECK(b.desk->turn("gravity", 0));
  CHECK(b.desk->turn("step", 5));
  CHECK(b.desk->turn("sweeps", 7));
  CHECK(!b.desk->turn("nothing", 1));
  b.run(0.5);
  CHECK(b.world().time == Approx(0.5).margin(0.0051));  // what is left of a step waits
  CHECK(b.world().tick > 90);
  CHECK(b.world().bodies[b.find("lower")].pose.position.y == Approx(1));
  b.desk->restart();
  CHECK(b.world().gravity == Vec3(0));
  CHECK(b.world().default_settings.sweeps == 7);
  b.desk->turn("gravity", 9.81);
  CHECK(b.world().gravity.y == Approx(-9.81));
  b.desk->turn("gravity", 2);
  b.desk->reload();
  CHECK(b.world().gravity.y == Approx(-9.81));
  CHECK(b.desk->panes[0]->sim.settings.h == Approx(1.0 / 60));
}

TEST_CASE("a motor's target and the strength of muscles are knobs") {
  Scene car = load_scene(asset("scenes/car.json")).value();
  StepSettings how;
  World world = car.world;
  std::string motor;
  for (const Knob& knob : knobs_of(world, how, car.world))
    if (knob.group == KnobGroup::motors && motor.empty()) motor = knob.name;
  REQUIRE(motor.rfind("motor ", 0) == 0);
  CHECK(turn_knob({world, how, car.world}, motor, 1.25));
  for (const Knob& knob : knobs_of(world, how, car.world))
    if (knob.name == motor) CHECK(knob.value == 1.25);

  Scene standing = load_scene(asset("scenes/standing.json")).value();
  world = standing.world;
  REQUIRE(!world.joint_drives.empty());
  CHECK(turn_knob({world, how, standing.world}, "muscles", 0.5));
  CHECK(world.joint_drives.values()[0].stiffness ==
        Approx(0.5 * standing.world.joint_drives.values()[0].stiffness));
  CHECK(turn_knob({world, how, standing.world}, "muscles", 1));
  CHECK(world.joint_drives.values()[0].stiffness ==
        Approx(standing.world.joint_drives.values()[0].stiffness));
}

TEST_CASE("the body under the mouse is told by name and numbers") {
  const Bench b;
  b.run(0.2);
  const auto lines = describe(b.world(), b.find("lower"));
  REQUIRE(lines.size() == 5);
  CHECK(lines[0] == "lower");
  CHECK(lines[1] == "dynamic, 0.8 kg");
  CHECK(lines[4].rfind("knee: ball", 0) == 0);
  const Vec3 at = b.on_screen("lower");
  b.desk->move(at.x, at.y);
  b.desk->look_under_mouse();
  CHECK(b.desk->under == b.find("lower"));
  b.desk->help = false;
  CHECK(b.desk->labels(0).back().rfind("lower, dynamic, 0.8 kg", 0) == 0);
  b.desk->leave();
  b.desk->look_under_mouse();
  CHECK(!b.desk->is_under);
}

TEST_CASE("forces of joints are drawn where they act") {
  const Bench b;
  b.run(3);
  const auto arrows = forces_of(b.desk->panes[0]->scene());
  REQUIRE(arrows.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const Entity joint = b.world().links.owners()[i];
    CHECK(arrows[i].force == joint_reaction(b.world(), joint)->force);
  }
}

TEST_CASE("the way of a contact is kept while a scene runs, and gone when it starts over") {
  std::ifstream file(asset("scenes/turntable.json"));
  std::stringstream text;
  text << file.rdbuf();
  const Bench b(text.str());
  b.run(1);
  const auto& trails = b.desk->panes[0]->trails.trails();
  REQUIRE(trails.size() == 2);
  CHECK(trails[0].body == b.world().surface_contacts.values()[0].a);
  CHECK(trails[0].points.size() > 20);
  CHECK(trails[1].points.size() > 20);
  b.desk->key("r");
  CHECK(b.desk->panes[0]->trails.trails().empty());
}
