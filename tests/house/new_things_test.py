#!/usr/bin/env python3
"""A new kind of joint, of path, of event, a new integrator: one file and one word in a list. A new
solver: a folder and two rows. CONTRIBUTING.md is followed to the letter in a copy of the engine, which is
built and tried."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
COPIED = ["CMakeLists.txt", "engine", "tools/package", "tests/contract/joint_kinds_test.cpp",
          "tests/contract/path_kinds_test.cpp", "tests/contract/event_kinds_test.cpp", "tests/catch3",
          "tests/base/random.hpp", "tests/joints/equations.hpp"]
LEFT_OUT = "-DPANTIN_{}=OFF"

GUIDES = {
    "## Add a joint in ten minutes": ["engine/joints/ring.hpp", "engine/joints/kinds.hpp"],
    "## Add a path for kinematic bodies": [
        "engine/world/paths/circle.hpp", "engine/world/kinematic_path.hpp"],
    "## Add a timed event": [
        "engine/world/events/place.hpp", "engine/world/timed_event.hpp"],
    "## Add an integrator of the exact solver": [
        "engine/solvers/lagrangian/midpoint.cpp", "engine/world/integrators.hpp"],
    "## Add a solver": [
        "engine/solvers/ballistic/row.cpp", "engine/world/settings.hpp",
        "engine/world/solver_list.hpp", "engine/solvers/solver.hpp"],
}

PROGRAM = r"""
#include <cmath>
#include <cstdio>
#include <string>

#include <pantin/events.hpp>
#include <pantin/joints.hpp>
#include <pantin/shapes.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/scene/scene.hpp"
#include "engine/scene/keys/schema.hpp"

using namespace pantin;
using namespace pantin::detail;

#define REQUIRE(x) if (!(x)) return std::printf("not so: %s\n", #x), 1

/// Where the bead is after half a second.
Vec3 after(const World& start, const char* by, int steps) {
  World world = start;
  if (!integrator_from_name(by, world.default_settings.integrator)) return Vec3(1e9);
  for (Body& b : world.bodies.values()) b.drag = 0;
  Simulation simulation(world, {0.5 / steps});
  for (int i = 0; i < steps; ++i)
    if (simulation.step().status != Status::ok) return Vec3(1e9);
  return simulation.world.bodies.values()[0].pose.position;
}

/// A kinematic body along a new kind of path.
int try_path(const char* file) {
  const auto scene = load_scene(file);
  if (!scene) return std::printf("%s\n", scene.errors().front().message.c_str()), 1;
  REQUIRE(scene->warnings.empty());
  Simulation simulation(scene->world, {scene->step, scene->substeps});
  for (int i = 0; i < 240; ++i) REQUIRE(simulation.step().status == Status::ok);
  const Vec3 at = simulation.world.bodies.values()[0].pose.position;
  const double angle = 2 * kPi * 0.3 * 240 * scene->step;
  const double off = glm::length(at - Vec3(1 + 2 * std::cos(angle), 9, 2 * std::sin(angle)));
  std::printf("off the circle by %.2g m\n", off);
  REQUIRE(off < 1e-9);
  REQUIRE(detail::scene_schema().find("A level circle at a steady speed.") != std::string::npos);
  const auto refused = parse_scene(R"({"version": 1, "paths": [{"body": "b", "circle": {"radius": -1}}]})", "r.json");
  REQUIRE(!refused && refused.errors().size() == 2);  // there is no body either
  REQUIRE(refused.errors().back().message.find("/paths/0/circle/radius: found -1") != std::string::npos);
  return 0;
}

/// A body to which a new kind of event happens.
int try_event(const char* file) {
  const auto scene = load_scene(file);
  if (!scene) return std::printf("%s\n", scene.errors().front().message.c_str()), 1;
  REQUIRE(scene->warnings.empty());
  World world = scene->world;
  REQUIRE(world.add(PlaceEvent{.body = world.find("ball"), .position = {5, 0, 0}, .at = 0.75}));
  REQUIRE(!world.add(PlaceEvent{.position = {5, 0, 0}}));
  Simulation simulation(std::move(world), {1.0 / 64});
  const auto run_to = [&](Real end) {
    while (simulation.world.time < end) simulation.step();
    return simulation.world.bodies.values()[0].pose.position;
  };
  REQUIRE(glm::length(run_to(0.5) - Vec3(0.5, 0, 0)) < 1e-9);
  REQUIRE(glm::length(run_to(0.7) - Vec3(0, 2, 0)) < 1e-9);
  REQUIRE(glm::length(run_to(1) - Vec3(5, 0, 0)) < 1e-9);
  REQUIRE(detail::scene_schema().find("A body is set down elsewhere, at rest.") != std::string::npos);
  const auto refused = parse_scene(R"({"version": 1, "bodies": [{"name": "b", "shape": {"type": "sphere", "radius": 1}}],
    "events": [{"type": "place", "body": "b", "at": -1}]})", "r.json");
  REQUIRE(!refused && refused.errors().size() == 2);
  REQUIRE(refused.errors()[0].message.find("found no \"position\", expected the place where it comes to") != std::string::npos);
  REQUIRE(refused.errors()[1].message.find("/events/0/at: found -1") != std::string::npos);
  return 0;
}

/// The bead of a scene, added by a program.
int try_any_joint(const World& from_file) {
  World world = from_file;
  const Entity bead = world.bodies.owners()[0];
  world.destroy(world.links.owners()[0]);
  const auto wall = world.add(RigidBody{.motion = Motion::fixed});
  REQUIRE(wall);
  AnyJoint ring{.kind = "ring", .a = *wall, .b = bead, .anchor_b = Vec3(0.3, 0, 0), .axis = {0, 0, 1}};
  const auto refused = world.add(ring);
  REQUIRE(!refused && refused.errors().front().message == "AnyJoint: radius: found none, expected how large the ring is, in m");
  ring.parameters = {{"radius", 0.3}};
  REQUIRE(world.add(ring));
  Simulation simulation(std::move(world), {1.0 / 240});
  for (int i = 0; i < 240; ++i) {
    REQUIRE(simulation.step().status == Status::ok);
    const Vec3 at = simulation.world.bodies[bead].pose.position;
    REQUIRE(std::abs(glm::length(at) - 0.3) < 1e-9 && std::abs(at.z) < 1e-9);
  }
  return 0;
}

/// A projectile under a new solver, and what it does not know.
int try_solver(const char* file) {
  const auto scene = load_scene(file);
  if (!scene) return std::printf("%s\n", scene.errors().front().message.c_str()), 1;
  REQUIRE(scene->warnings.size() == 1 && scene->warnings[0].find("falls forever") != std::string::npos);
  Simulation simulation(scene->world, {1.0 / 60});
  for (int i = 0; i < 60; ++i) REQUIRE(simulation.step().status == Status::ok);
  const Vec3 at = simulation.world.bodies.values()[0].pose.position;
  const double off = glm::length(at - Vec3(3, 4 + scene->world.gravity.y / 2, 0));
  std::printf("off the parabola by %.2g m\n", off);
  REQUIRE(off < 1e-12);
  World tied = scene->world;
  const auto hook = tied.add(RigidBody{.motion = Motion::fixed});
  REQUIRE(hook && tied.add(BallJoint{.a = *hook, .b = tied.bodies.owners()[0]}));
  REQUIRE(check(tied).size() == 1);
  REQUIRE(detail::scene_schema().find("projectiles along exact parabolas.") != std::string::npos);
  const auto refused = parse_scene(R"({"version": 1, "solver": {"type": "ballistic"}, "bodies": [
    {"name": "a", "shape": {"type": "sphere", "radius": 1}}, {"name": "b", "position": [3, 0, 0], "shape": {"type": "sphere", "radius": 1}}],
    "cables": [{"a": "a", "b": "b"}]})", "r.json");
  REQUIRE(!refused && refused.errors().front().message.find("solved by \"ballistic\"") != std::string::npos);
  return 0;
}

int main(int, char** arguments) {
  if (try_path(arguments[2]) != 0 || try_event(arguments[3]) != 0) return 1;
  if (try_solver(arguments[4]) != 0) return 1;
  const auto scene = load_scene(arguments[1]);
  if (!scene) return std::printf("%s\n", scene.errors().front().message.c_str()), 1;
  REQUIRE(scene->warnings.empty());
  if (try_any_joint(scene->world) != 0) return 1;
  const Joint joint = scene->world.links.values()[0].joint;
  REQUIRE(std::string(name_of(joint.kind)) == "ring");
  REQUIRE(joint.kind == JointKind::ring && row_count(joint) == 2 && degrees_of_freedom(joint.kind) == 4);

  Simulation simulation(scene->world, {scene->step, scene->substeps, 1, true});
  Real worst = 0, lowest = 0, fastest = 0;
  for (int i = 0; i < 480; ++i) {
    const StepReport report = simulation.step();
    REQUIRE(report.status == Status::ok);
    worst = std::max(worst, report.measures.worst_gap);
    const Body& bead = simulation.world.bodies.values()[0];
    worst = std::max(worst, std::abs(glm::length(bead.pose.position) - 0.3));
    worst = std::max(worst, std::abs(bead.pose.position.z));
    lowest = std::min(lowest, bead.pose.position.y);
    fastest = std::max(fastest, glm::length(bead.velocity));
  }
  std::printf("off the ring by %.2g m, %.4f m down, %.4f m/s\n", double(worst), double(lowest),
              double(fastest));
  REQUIRE(worst <= 1e-9);
  REQUIRE(lowest < -0.299);
  REQUIRE(fastest > 2 && fastest < std::sqrt(2 * 9.81 * 0.3) + 1e-3);  // 2.426 m/s without drag

  const Vec3 exact = after(scene->world, "rk4", 2000);
  const Real one = glm::length(after(scene->world, "midpoint", 100) - exact);
  const Real half = glm::length(after(scene->world, "midpoint", 200) - exact);
  std::printf("midpoint errs by %.2g m, in half the step by %.2g m\n", double(one), double(half));
  REQUIRE(std::abs(std::log2(one / half) - 2) < 0.2);

  const std::string hinge = R"({"version": 1, "bodies": [{"name": "b", "mass": 1, "inertia": [1, 1, 1]}],
    "joints": [{"kind": "hinge", "a": "world", "b": "b", "anchor": [0, 0, 0], "radius": 1}]})";
  const auto refused = parse_scene(hinge, "hinge.json");
  REQUIRE(!refused && refused.errors().size() == 1);
  REQUIRE(refused.errors().front().message.find("of these kinds only: ring") != std::string::npos);
  return 0;
}
"""

BUILD = """
find_package(Catch2 2.13 CONFIG QUIET)
if(NOT Catch2_FOUND)
  find_package(Catch2 3 CONFIG QUIET)
endif()
add_executable(tried tried.cpp)
target_link_libraries(tried PRIVATE pantin_scene)
if(TARGET Catch2::Catch2)
  file(WRITE ${PROJECT_BINARY_DIR}/main.cpp "#define CATCH_CONFIG_MAIN\\n#include <catch2/catch.hpp>\\n")
  add_executable(contract ${PROJECT_BINARY_DIR}/main.cpp tests/contract/joint_kinds_test.cpp
                 tests/contract/path_kinds_test.cpp tests/contract/event_kinds_test.cpp)
  target_link_libraries(contract PRIVATE pantin_core Catch2::Catch2)
  if(Catch2_VERSION VERSION_GREATER_EQUAL 3)
    target_include_directories(contract SYSTEM PRIVATE tests/catch3)
  endif()
endif()
"""


def steps(heading):
    """The blocks of a part of the guide in its order: language, path, text."""
    guide = (ROOT / "CONTRIBUTING.md").read_text()
    part = guide.split(heading)[1].split("\n## ")[0]
    return re.findall(r"^```(\w+) (\S+)\n(.*?)^```$", part, re.M | re.S)


def patch(path, text):
    """Lines that begin with - or a space are there once; they become those with + or a space."""
    lines = text.splitlines(keepends=True)
    before = "".join(line[1:] for line in lines if line[0] in " -")
    now = path.read_text()
    if now.count(before) != 1:
        raise AssertionError(f"{path} does not hold once:\n{before}")
    path.write_text(now.replace(before, "".join(line[1:] for line in lines if line[0] in " +")))


def add_to_list(path, lines):
    """An include among the others, a word at the end of the list that has words like it."""
    text = path.read_text()
    for line in lines.splitlines():
        if line.startswith("#include"):
            first = re.search(r'^#include "engine/', text, re.M).start()
            text = text[:first] + line + "\n" + text[first:]
        elif line:
            like = re.escape(line.split("(")[0])
            last = list(re.finditer(rf"^{like}\(.*\)$", text, re.M))[-1]
            text = text[:last.end()] + " \\\n" + line + text[last.end():]
    path.write_text(text)


class NewThings(unittest.TestCase):
    def run_there(self, *command, **more):
        done = subprocess.run(command, cwd=self.there, capture_output=True, text=True, **more)
        self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout[-6000:]}{done.stderr[-3000:]}")
        return done.stdout

    def contents(self):
        return {p: p.read_bytes() for p in (self.there / "engine").rglob("*") if p.is_file()}

    def follow(self, heading, expected):
        blocks = steps(heading)
        files = dict.fromkeys(name for _, name, _ in blocks if name.startswith("engine/"))
        self.assertEqual(list(files), expected)
        before = self.contents()
        for language, name, text in blocks:
            path = self.there / name
            path.parent.mkdir(parents=True, exist_ok=True)
            if language == "diff":
                patch(path, text)
            elif path.exists():
                add_to_list(path, text)
            else:
                path.write_text(text)
        touched = [p for p, now in self.contents().items() if before.get(p) != now]
        self.assertEqual(len(touched), len(expected), touched)
        print(heading[3:] + ":", ", ".join(sorted(str(p.relative_to(self.there)) for p in touched)))

    def test_are_one_file_and_one_word(self):
        with tempfile.TemporaryDirectory() as folder:
            self.there = pathlib.Path(folder)
            for name in COPIED:
                to = self.there / name
                to.parent.mkdir(parents=True, exist_ok=True)
                copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copyfile
                copy(ROOT / name, to)
            for heading, expected in GUIDES.items():
                self.follow(heading, expected)
            self.try_it()

    def try_it(self):
        (self.there / "tried.cpp").write_text(PROGRAM)
        with open(self.there / "CMakeLists.txt", "a") as lists:
            lists.write(BUILD)
        # Warnings and speed are other tests' business.
        self.run_there("cmake", "-B", "built", "-DCMAKE_BUILD_TYPE=None", "-DCMAKE_CXX_FLAGS=-O0 -w",
                       *[LEFT_OUT.format(f) for f in ("RENDER", "PROGRAM", "VIEW", "DEMOS", "TESTS")])
        self.run_there("cmake", "--build", "built", "--parallel", str(os.cpu_count() or 1))
        print(self.run_there("built/tried", "assets/scenes/ring.json",
                             "assets/scenes/circle.json", "assets/scenes/place.json",
                             "assets/scenes/thrown.json"), end="")
        if (self.there / "built/contract").exists():
            print(self.run_there("built/contract").strip().splitlines()[-1])


if __name__ == "__main__":
    unittest.main()
