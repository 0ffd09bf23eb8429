// What tools/peers/contact spells out for other engines, and the ruler it lays on their motions.
#include <cmath>
#include <filesystem>

#include "engine/solvers/solver.hpp"
#include "tests/scene/scenes.hpp"
#include "tools/peers/bodies/judge.hpp"
#include "tools/peers/bodies/spelt.hpp"

using namespace pantin;
using namespace pantin::peers;
using namespace pantin::test;

namespace {

/// A file that is gone afterwards.
struct File {
  std::string path = (std::filesystem::temp_directory_path() /
                      ("pantin_peers_" + std::to_string(reinterpret_cast<std::uintptr_t>(this))))
                         .string();
  ~File() { std::filesystem::remove(path); }
};

World compiled(const std::string& text) {
  World world = good(text).world;
  compile_if_changed(world);
  return world;
}

/// A plane and two balls of 0.1 m that a joint holds 0.3 m apart, 1 m up; a third beside them.
const char* kBalls = R"({"version": 1, "collision": {"others": true, "self": false}, "bodies": [
  {"name": "floor", "motion": "fixed", "shape": {"type": "plane"}},
  {"name": "a", "position": [0, 1, 0], "shape": {"type": "sphere", "radius": 0.1}, "mass": 2},
  {"name": "b", "position": [0.3, 1, 0], "shape": {"type": "sphere", "radius": 0.1}, "mass": 2},
  {"name": "c", "position": [0, 1.15, 0], "shape": {"type": "sphere", "radius": 0.1}, "mass": 2}],
  "joints": [{"a": "a", "b": "b", "anchor": [0.15, 1, 0]}]})";

Frame frame_of(const World& world) {
  Frame frame;
  for (const Body& b : world.bodies.values()) {
    const Vec3 x = b.pose.position, v = b.velocity;
    const Quat q = b.pose.rotation;
    frame.bodies.push_back({{x.x, x.y, x.z}, {q.x, q.y, q.z, q.w}, {v.x, v.y, v.z}, {0, 0, 0}});
  }
  return frame;
}

/// `frames` frames in which `move` has moved the bodies.
template <class Move>
Verdict judged(const World& start, int frames, Move&& move) {
  const File file;
  {
    MotionWriter out(file.path);
    out.tell("engine", "none");
    out.begin(start.bodies.size());
    for (int i = 0; i < frames; ++i) {
      World now = start;
      Frame frame;
      frame.ms = i, frame.awake = 1;
      move(i, now, frame);
      frame.bodies = frame_of(now).bodies;
      out.add(frame);
    }
  }
  Verdict verdict;
  REQUIRE(judge(start, file.path, verdict));
  CHECK(verdict.frames == frames);
  return verdict;
}

Vec3& place(World& world, const char* name) { return world.bodies[world.find(name)].pose.position; }

}  // namespace

TEST_CASE("The ruler tells gaps, depths and energy of a motion, in the run and at rest") {
  const World start = compiled(kBalls);
  const Verdict v = judged(start, 100, [](int i, World& now, Frame&) {
    place(now, "c").x = 1;
    place(now, "a").y = i == 10 ? 0.08 : 1.0;   // 20 mm in the floor, once
    place(now, "b").x = i == 10 ? 0.3 : 0.305;  // 5 mm too far
    if (i == 99) now.bodies[now.find("c")].velocity = {0, 3, 0};
  });
  CHECK(v.bodies == 3);
  CHECK(v.depth == Approx(0.02));
  CHECK(v.depth_at_rest == 0);
  CHECK(v.opening == Approx(0.92));  // a without b in the floor
  CHECK(v.opening_at_rest == Approx(0.005));
  CHECK(v.kinetic == Approx(9));
  CHECK(v.energy == Approx(9));
  CHECK(v.gained == Approx(9));
  CHECK(v.lost == 0);
  CHECK(v.moved == Approx(0).margin(1e-12));
  CHECK(v.median_ms == 50);
  CHECK(v.p99_ms == 99);
}

TEST_CASE("Bodies that start within each other count in the run once they have been apart") {
  const World start = compiled(kBalls);  // c is 50 mm in a
  const auto sinking = [&](bool parts) {
    return judged(start, 60, [&](int i, World& now, Frame&) {
      place(now, "c").y = i < 20 ? 1.12 : i < 40 && parts ? 1.3 : 1.17;
    });
  };
  CHECK(sinking(false).depth_at_start == Approx(0.05));
  CHECK(sinking(false).depth == 0);
  CHECK(sinking(false).depth_at_rest == Approx(0.03));
  CHECK(sinking(true).depth == Approx(0.03));
  // Jointed bodies never count.
  const Verdict v = judged(
      start, 60, [](int, World& now, Frame&) { place(now, "b").x = 0.1, place(now, "c").x = 2; });
  CHECK(v.depth_at_rest == 0);
}

TEST_CASE("The ruler tells what is lost, and since when all sleep") {
  const World start = compiled(kBalls);
  const Verdict v = judged(start, 120, [](int i, World& now, Frame& frame) {
    place(now, "c") = i < 60 ? Vec3(1, 1, 0) : Vec3(1, -0.2, 0);
    if (i > 30) place(now, "b").y = std::nan("");
    frame.awake = i < 90;
  });
  CHECK(v.lost == 2);
  CHECK(v.asleep_after == Approx(1.5));
  CHECK(std::isinf(v.opening));
  CHECK(judged(start, 60, [](int, World&, Frame&) {}).asleep_after < 0);
}

TEST_CASE("The ruler tells turns beyond a limit") {
  const World start = compiled(R"({"version": 1, "bodies": [
    {"name": "rod", "shape": {"type": "capsule", "radius": 0.1, "length": 1}, "mass": 3}],
    "joints": [{"a": "world", "b": "rod", "kind": "hinge", "anchor": [0, 0, 0], "axis": [0, 0, 1],
                "limits": {"angle_deg": [-30, 60]}}]})");
  const auto turned = [&](Real angle) {
    return judged(start, 60, [&](int, World& now, Frame&) {
      now.bodies[now.find("rod")].pose.rotation = glm::angleAxis(angle, Vec3(0, 0, 1));
    });
  };
  CHECK(turned(1).turn == Approx(0).margin(1e-12));
  CHECK(turned(kPi / 2).turn == Approx(kPi / 6));
  CHECK(turned(-kPi / 3).turn_at_rest == Approx(kPi / 6));
}

TEST_CASE("Other engines are told who may touch whom") {
  const World w = compiled(R"({"version": 1, "bodies": [
    {"name": "floor", "motion": "fixed", "shape": {"type": "plane"}, "collision": {}},
    {"name": "a", "position": [0, 1, 0], "shape": {"type": "sphere", "radius": 0.1},
     "collision": {"self": true, "others": true}},
    {"name": "b", "position": [1, 1, 0], "shape": {"type": "sphere", "radius": 0.1},
     "collision": {"self": true, "others": true}},
    {"name": "c", "position": [2, 1, 0], "shape": {"type": "sphere", "radius": 0.1},
     "collision": {"others": true, "self": false}},
    {"name": "d", "position": [3, 1, 0], "shape": {"type": "sphere", "radius": 0.1},
     "collision": {"others": true, "self": false}},
    {"name": "e", "position": [4, 1, 0], "shape": {"type": "sphere", "radius": 0.1},
     "collision": {"others": false}},
    {"name": "f", "position": [5, 1, 0], "shape": {"type": "sphere", "radius": 0.1}}],
    "joints": [{"a": "a", "b": "b", "anchor": [0.5, 1, 0]},
               {"a": "c", "b": "d", "anchor": [2.5, 1, 0]}]})");
  const Layers layers = layers_of(w);
  const auto touch = [&](const char* one, const char* two) {
    const std::uint32_t a = w.bodies.slot(w.find(one)), b = w.bodies.slot(w.find(two));
    CHECK(layers.may_touch(a, b) == layers.may_touch(b, a));
    return layers.may_touch(a, b);
  };
  for (const char* body : {"a", "b", "c", "d", "e"}) CHECK(touch("floor", body));
  CHECK(touch("a", "b"));        // of one island that collides with itself
  CHECK_FALSE(touch("c", "d"));  // of one that does not
  CHECK(touch("a", "c"));
  CHECK(touch("e", "c"));  // one of the two asks for it
  CHECK_FALSE(touch("f", "floor"));
  CHECK(jointed_pairs(w).size() == 2);
}

TEST_CASE("What is spelled out for other engines is the scene") {
  const World w = compiled(R"({"version": 1, "gravity": [0, -3, 0], "bodies": [
    {"name": "the car", "motion": "kinematic", "shape": {"type": "box", "size": [1, 2, 3]},
     "collision": {}},
    {"name": "rod", "position": [0, 2, 0], "shape": {"type": "capsule", "radius": 0.1, "length": 1},
     "mass": 3, "velocity": [1, 2, 3], "collision": {"friction": 0.7}}],
    "paths": [{"body": "the car", "keyframes": [{"time": 0, "position": [0, 0, 0]},
                                                {"time": 1, "position": [6, 0, 0]}]}],
    "joints": [{"a": "the car", "b": "rod", "kind": "hinge", "anchor": [0, 1.5, 0], "axis": [0, 0, 1],
                "limits": {"angle_deg": [-30, 60]}}],
    "cables": [{"a": "the car", "b": "rod", "anchor_a": [0, 1, 0], "anchor_b": [0, 0.5, 0],
                "length": 4}]})");
  const File file;
  {
    std::ofstream out(file.path);
    write_plain(w, 30, out);
  }
  Spelt s;
  REQUIRE(read_spelt(file.path, s));
  CHECK(s.gravity[1] == Approx(-3));
  CHECK(s.frames == 30);
  CHECK(s.unknown.empty());
  REQUIRE(s.bodies.size() == 2);
  CHECK((s.bodies[0].motion == "kinematic" && s.bodies[1].motion == "dynamic"));
  REQUIRE(s.bodies[0].path.size() == 30);
  CHECK(s.bodies[0].path[29].position[0] == Approx(3));
  const Body& rod = w.bodies[w.find("rod")];
  CHECK(s.bodies[1].mass == Approx(3));
  CHECK(s.bodies[1].friction == Approx(0.7));
  for (int i = 0; i < 3; ++i) {
    CHECK(s.bodies[1].inertia[static_cast<std::size_t>(i)] == Approx(rod.inertia[i]));
    CHECK(s.bodies[1].velocity[static_cast<std::size_t>(i)] == Approx(i + 1));
  }
  REQUIRE(s.bodies[1].shapes.size() == 1);
  CHECK(s.bodies[1].shapes[0].kind == "capsule");
  REQUIRE(s.joints.size() == 1);
  CHECK((s.joints[0].a == 0 && s.joints[0].b == 1));
  CHECK(s.joints[0].first.on);
  CHECK(s.joints[0].first.high == Approx(kPi / 3));
  REQUIRE(s.cables.size() == 1);
  CHECK(s.cables[0].length == Approx(4));
}
