// "events" of scene files: what they say, and what is refused of them.
#include <pantin/pantin.hpp>

#include "engine/world/timed_event.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// Two balls, a hinge with a motor, a chain of four links, a pin and these events; these from line
/// 13 on.
std::string scene_of(const std::string& events, const std::string& more = "") {
  return R"({"version": 1, "duration": 4, )" + more + R"("bodies": [
{"name": "a", "mass": 2, "shape": {"type": "sphere", "radius": 0.1}, "centre_of_mass": [0, 0.2, 0]},
{"name": "b", "shape": {"type": "sphere", "radius": 0.1}, "position": [1, 0, 0]},
{"name": "post", "motion": "fixed"}],
"joints": [
{"name": "axle", "kind": "hinge", "a": "post", "b": "b", "anchor": [1, 0, 0], "axis": [0, 0, 1],
 "motor": {"velocity": 1, "gain": 20, "cap": 7}}],
"generators": {"chains": [{"name": "rope", "links": 4, "length": 0.2, "start": [2, 2, 0],
 "attach": "world", "shape": {"type": "sphere", "radius": 0.05}}]},
"cables": [{"name": "line", "a": "world", "b": "a", "point_a": [0, 3, 0], "point_b": [0, 0, 0]}],
"pins": [{"name": "nail", "body": "a", "point": [0, 0, 0]}],
"events": [
)" + events +
         "]}";
}

std::vector<TimedEvent> events_in(const std::string& text) {
  const Scene scene = good(text);
  const Store<TimedEvent>* events = events_of(scene.world);
  if (!events) return {};
  return {events->values().begin(), events->values().end()};
}

template <class Event>
Event event_in(const std::string& event) {
  const std::vector<TimedEvent> all = events_in(scene_of(event));
  REQUIRE(all.size() == 1);
  REQUIRE(std::holds_alternative<Event>(all.front().kind));
  return std::get<Event>(all.front().kind);
}

Lines refused(const std::string& event) { return diagnostics(scene_of(event)); }

}  // namespace

TEST_CASE("A push says where, how hard and how long") {
  const Scene scene = good(scene_of(
      R"({"type": "push", "body": "a", "force": [1, 2, 3], "from": 0.5, "to": 0.7, "every": 2})"));
  const auto& e = std::get<PushEvent>(events_of(scene.world)->values()[0].kind);
  CHECK(e.body == scene.world.find("a"));
  CHECK(e.force == Vec3(1, 2, 3));
  CHECK(e.torque == Vec3(0));
  CHECK((e.from == 0.5 && e.to == 0.7 && e.every == 2));
  CHECK(e.anchor == Vec3(0));  // the mass centre
  // A point of the own frame, and the same in the scene.
  for (const char* point : {R"("anchor": [0.1, 0, 0])", R"("point": [0.1, 0, 0])"}) {
    const auto off =
        event_in<ImpulseEvent>(std::string(R"({"type": "impulse", "at": 1, "body": "a", )") +
                               R"("impulse": [0, 1, 0], )" + point + "}");
    CHECK(off.at == 1);
    CHECK(off.impulse == Vec3(0, 1, 0));
    CHECK(glm::length(off.anchor) == Approx(std::hypot(0.1, 0.2)));
  }
}

TEST_CASE("A wind blows on all, or on bodies and groups of them") {
  const auto all = event_in<WindEvent>(R"({"type": "wind", "velocity": [3, 0, 0], "gusts": 2})");
  CHECK(all.bodies.empty());
  CHECK(all.gusts == Vec3(2));
  CHECK(all.drag < 0);
  CHECK(all.to > 1e100);
  const auto some = event_in<WindEvent>(
      R"({"type": "wind", "velocity": [3, 0, 0], "bodies": ["rope", "a"], "seed": 4, "drag": 0.5})");
  CHECK(some.bodies.size() == 5);
  CHECK((some.seed == 4 && some.drag == 0.5));
}

TEST_CASE("A hand, a winch, gravity and a solver say what becomes of them") {
  const auto hand = event_in<PullEvent>(
      R"({"type": "pull", "body": "b", "target": [1, 2, 0], "from": 1, "to": 3, "damping": 5})");
  CHECK(
      (hand.target == Vec3(1, 2, 0) && hand.over == 2 && hand.stiffness == 0 && hand.damping == 5));
  CHECK(event_in<PullEvent>(R"({"type": "pull", "body": "b", "target": [1, 2, 0]})").over == 1);
  const auto winch = event_in<WinchEvent>(
      R"({"type": "winch", "cable": "line", "length": 1.5, "at": 2, "over": 1})");
  CHECK((winch.length == 1.5 && winch.at == 2 && winch.over == 1));
  CHECK(event_in<GravityEvent>(R"({"type": "gravity", "gravity": [0, 1, 0], "at": 2})").gravity ==
        Vec3(0, 1, 0));
}

TEST_CASE("What is cut is found by its name, or all of a chain") {
  const Scene scene = good(scene_of(R"({"type": "cut", "joint": "rope", "at": 1},
{"type": "cut", "pin": "nail", "at": 2}, {"type": "cut", "cable": "line", "at": 2})"));
  const auto events = events_of(scene.world)->values();
  REQUIRE(events.size() == 6);  // four joints of the chain
  CHECK(std::get<CutEvent>(events[0].kind).tie == scene.world.find("rope/top"));
  CHECK(std::get<CutEvent>(events[3].kind).tie == scene.world.find("rope/2-3"));
  CHECK(std::get<CutEvent>(events[4].kind).tie == scene.world.find("nail"));
  CHECK(std::get<CutEvent>(events[5].kind).tie == scene.world.find("line"));
}

TEST_CASE("A motor keeps what is not said") {
  const auto faster = event_in<MotorEvent>(
      R"({"type": "motor", "joint": "axle", "velocity_deg": 180, "at": 1, "over": 2})");
  CHECK(faster.motor.kind == MotorKind::velocity);
  CHECK(faster.motor.target == Approx(kPi));
  CHECK((faster.motor.gain == 20 && faster.motor.cap == 7 && faster.over == 2));
  const auto off = event_in<MotorEvent>(R"({"type": "motor", "joint": "axle", "cap": 0, "at": 1})");
  CHECK((off.motor.target == 1 && off.motor.cap == 0));
  const auto there = event_in<MotorEvent>(
      R"({"type": "motor", "joint": "axle", "position": 0.5, "gain": 9, "damping": 2, "at": 1})");
  CHECK((there.motor.kind == MotorKind::position && there.motor.damping == 2));
}

TEST_CASE("An exact drive gets another motion, along the coordinate that it drives") {
  const auto scene_with = [](const std::string& event, const std::string& more = "") {
    return R"({"version": 1, )" + more + R"("bodies": [
{"name": "cart", "shape": {"type": "sphere", "radius": 100}, "mass": 1},
{"name": "arm", "shape": {"type": "sphere", "radius": 100}, "mass": 1, "position": [500, 0, 0]}],
"joints": [
{"name": "slide", "kind": "prismatic", "a": "world", "b": "cart", "anchor": [0, 0, 0], "axis": [1, 0, 0],
 "drive": {"motion": {"speed": 1}, "max_torque": 40}},
{"name": "axle", "kind": "hinge", "a": "world", "b": "arm", "anchor": [500, 0, 0], "axis": [0, 0, 1],
 "drive": {"stiffness": 3}}],
"events": [
)" + event +
           "]}";
  };
  const auto event_of = [&](const std::string& event, const std::string& more = "") {
    const Scene scene = good(scene_with(event, more));
    return std::get<DriveEvent>(events_of(scene.world)->values()[0].kind);
  };
  const DriveEvent on = event_of(
      R"({"type": "drive", "joint": "slide", "motion": {"table": [[0, 0], [2, 50]]}, "at": 1})");
  REQUIRE(on.motion);
  CHECK((on.motion->travels && on.motion->at_start && std::isnan(on.max_torque) && on.at == 1));
  CHECK(on.motion->knots.at(1).value == 50);
  const DriveEvent small = event_of(
      R"({"type": "drive", "joint": "slide", "motion": {"table": [[0, 0], [2, 50]], "offset": 20}, "at": 1})",
      R"("units": "mm", )");
  CHECK(small.motion->knots.at(1).value == Approx(0.05));
  CHECK((small.motion->offset == Approx(0.02) && !small.motion->at_start));
  CHECK(event_of(R"({"type": "drive", "joint": "slide", "max_torque": 7, "at": 1})").max_torque ==
        7);
  const auto told = [&](const std::string& event) {
    const Lines lines = diagnostics(scene_with(event));
    REQUIRE(lines.size() == 1);
    return lines[0];
  };
  CHECK(told(R"({"type": "drive", "joint": "slide", "motion": {"speed_deg": 9}, "at": 1})")
            .find("expected numbers in m, not in degrees") != std::string::npos);
  CHECK(told(R"({"type": "drive", "joint": "slide", "motion": {"along": "angle"}, "at": 1})")
            .find("expected \"along\": \"travel\"") != std::string::npos);
  CHECK(told(R"({"type": "drive", "joint": "axle", "motion": {"speed": 9}, "at": 1})")
            .find("expected an exact drive") != std::string::npos);
  CHECK(told(R"({"type": "drive", "joint": "slide", "motion": {"speed": 9}, "over": 1, "at": 1})")
            .find("\"over\"") != std::string::npos);
}

TEST_CASE("Events with unknown names are refused with the nearest one") {
  CHECK(refused(R"({"type": "push", "body": "aa", "force": [1, 0, 0]})") ==
        Lines{"t.json:13:26: /events/0/body: found \"aa\", expected the name of a body; nearest is "
              "\"a\""});
  CHECK(refused(R"({"type": "cut", "joint": "axel", "at": 1})") ==
        Lines{"t.json:13:26: /events/0/joint: found \"axel\", expected the name of a joint; "
              "nearest is \"axle\""});
  CHECK(refused(R"({"type": "cut", "cable": "rope", "at": 1})") ==
        Lines{"t.json:13:26: /events/0/cable: found \"rope\", expected the name of a cable"});
  CHECK(refused(R"({"type": "wind", "velocity": [1, 0, 0], "bodies": ["ropes"]})") ==
        Lines{"t.json:13:51: /events/0/bodies: found \"ropes\", expected the name of a body, a "
              "chain, an instance or a grid; nearest is \"rope/0\""});
  CHECK(refused(R"({"type": "psh"})") ==
        Lines{"t.json:13:10: /events/0/type: found \"psh\", expected push, impulse, wind, pull, "
              "cut, motor, drive, winch, gravity or solver; nearest is \"push\""});
  CHECK(refused(R"({"type": "push", "body": "post", "force": [1, 0, 0]})") ==
        Lines{"t.json:13:26: /events/0/body: found \"post\", expected a dynamic body: forces do "
              "not move this one"});
}

TEST_CASE("Times that cannot be meant are refused") {
  CHECK(refused(R"({"type": "push", "body": "a", "force": [1, 0, 0], "from": -1})") ==
        Lines{"t.json:13:59: /events/0/from: found -1, expected a time in seconds from 0 to 1e6"});
  CHECK(
      refused(R"({"type": "push", "body": "a", "force": [1, 0, 0], "from": 2, "to": 1})") ==
      Lines{
          "t.json:13:68: /events/0/to: found 1 s, before the start at 2 s, expected a later time"});
  CHECK(refused(R"({"type": "push", "body": "a", "force": [1, 0, 0], "to": 1, "every": 0.5})") ==
        Lines{"t.json:13:69: /events/0/every: found 0.5 s, expected 1 s or more: it can restart "
              "only after it has ended"});
  CHECK(refused(R"({"type": "push", "body": "a", "force": [1, 0, 0], "every": 1})") ==
        Lines{"t.json:13:51: /events/0/every: found \"every\" without \"to\", expected the end of "
              "the first interval too"});
  CHECK(refused(R"({"type": "cut", "pin": "nail"})") ==
        Lines{"t.json:13:1: /events/0: found no \"at\", expected a time in seconds"});
  CHECK(refused(R"({"type": "impulse", "body": "a", "at": 1, "from": 2, "impulse": [1, 0, 0]})")
            .size() == 1);
  CHECK(refused(R"({"type": "impulse", "body": "a", "at": 1, "impulse": [1, 0, 0], "every": 0})")
            .size() == 1);
}

TEST_CASE("Events that come to nothing are refused or warned of") {
  CHECK(refused(R"({"type": "motor", "joint": "rope/0-1", "velocity": 1, "gain": 1, "at": 1})") ==
        Lines{"t.json:13:28: /events/0/joint: found a ball joint \"rope/0-1\", expected one with "
              "one rotational or translational coordinate"});
  CHECK(refused(R"({"type": "drive", "joint": "axle", "stiffness": 1, "at": 1})") ==
        Lines{"t.json:13:28: /events/0/joint: found joint \"axle\" without a drive, expected one "
              "with a \"drive\""});
  CHECK(refused(R"({"type": "solver", "solver": "sweep", "at": 1})") ==
        Lines{"t.json:13:30: /events/0/solver: found \"sweep\", expected a solver that supports "
              "\"motor\" of joint \"axle\""});
  const Scene late = good(scene_of(R"({"type": "cut", "pin": "nail", "at": 4})"));
  CHECK(late.warnings == Lines{"t.json:13:1: /events/0: event at 4 s comes after the end "
                               "of the scene at 4 s"});
  const Scene calm =
      good(R"({"version": 1, "gravity": [0, 0, 0], "bodies": [{"name": "a", "drag": 0,
"shape": {"type": "sphere", "radius": 0.1}}], "events": [{"type": "wind", "velocity": [1, 0, 0]}]})");
  REQUIRE(calm.warnings.size() == 1);
  CHECK(calm.warnings[0].find("this wind has no effect") != std::string::npos);
}

TEST_CASE("A few lines cannot ask for millions of events") {
  std::string cuts;
  for (int i = 0; i < 40; ++i)
    cuts += std::string(i ? "," : "") + R"({"type": "cut", "joint": "rope", "at": 1})";
  SceneLimits limits;
  limits.links = 50;
  const Lines told = diagnostics(scene_of(cuts), limits);
  REQUIRE_FALSE(told.empty());
  CHECK(told.front().find("found events on more than 50 objects") != std::string::npos);
}

TEST_CASE("A scene's events happen when it is run") {
  const Scene scene = good(scene_of(
      R"({"type": "cut", "pin": "nail", "at": 0.5}, {"type": "cut", "cable": "line", "at": 1},
{"type": "cut", "joint": "rope/0-1", "at": 0.1}, {"type": "motor", "joint": "axle", "velocity": 9, "at": 0.2})"));
  Simulation sim = Simulation::copy_of(scene.world, {scene.step, scene.substeps});
  for (int i = 0; i < 120; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(sim.world.pins.empty());
  CHECK(sim.world.cables.empty());
  CHECK(sim.world.links.size() + 1 == scene.world.links.size());
  CHECK(joint_angular_speed(sim.world, sim.world.find("axle")) > 5);
  CHECK(sim.world.bodies[sim.world.find("a")].velocity.y < -5);
}
