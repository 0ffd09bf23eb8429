#!/usr/bin/env python3
"""A new kind of joint is one file and one word in a list: CONTRIBUTING.md, "Add a joint in ten
minutes", is followed to the letter in a copy of the engine, which is built and tried."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
COPIED = ["CMakeLists.txt", "engine", "tools/package", "tests/contract/joint_kinds_test.cpp",
          "tests/solvers/trees.hpp"]
LEFT_OUT = "-DPANTIN_{}=OFF"

# The bead falls along its ring; one period of a pendulum of half a turn is not needed to tell.
PROGRAM = r"""
#include <cmath>
#include <cstdio>
#include <string>

#include "engine/joints/kinds.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/scene/scene.hpp"

using namespace pantin;

#define REQUIRE(x) if (!(x)) return std::printf("not so: %s\n", #x), 1

int main(int, char** arguments) {
  const auto scene = load_scene(arguments[1]);
  if (!scene) return std::printf("%s\n", scene.errors().front().message.c_str()), 1;
  REQUIRE(scene->warnings.empty());
  const Joint joint = scene->world.links.values()[0].joint;
  REQUIRE(std::string(name_of(joint.kind)) == "ring");
  REQUIRE(joint.kind == JointKind::ring && row_count(joint) == 2 && freedoms(joint.kind) == 4);

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
add_executable(tried tried.cpp)
target_link_libraries(tried PRIVATE pantin_scene)
if(TARGET Catch2::Catch2)
  file(WRITE ${PROJECT_BINARY_DIR}/main.cpp "#define CATCH_CONFIG_MAIN\\n#include <catch2/catch.hpp>\\n")
  add_executable(contract ${PROJECT_BINARY_DIR}/main.cpp tests/contract/joint_kinds_test.cpp)
  target_link_libraries(contract PRIVATE pantin_core Catch2::Catch2)
endif()
"""


def steps():
    """The files of the guide, as {path: text}, in its order."""
    guide = (ROOT / "CONTRIBUTING.md").read_text()
    part = guide.split("## Add a joint in ten minutes")[1].split("\n## ")[0]
    return dict(re.findall(r"^```\w+ (\S+)\n(.*?)^```$", part, re.M | re.S))


def add_to_list(path, lines):
    """The include among the others, the word at the end of the list."""
    include, word = [line for line in lines.splitlines() if line]
    text = path.read_text()
    first = re.search(r'^#include "engine/joints/', text, re.M).start()
    last = list(re.finditer(r"^  KIND\(\w+\)$", text, re.M))[-1]
    text = text[:last.start()] + last.group() + " \\\n" + word + text[last.end():]
    path.write_text(text[:first] + include + "\n" + text[first:])


class NewJoint(unittest.TestCase):
    def run_there(self, *command, **more):
        done = subprocess.run(command, cwd=self.there, capture_output=True, text=True, **more)
        self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout[-6000:]}{done.stderr[-3000:]}")
        return done.stdout

    def test_is_one_file_and_one_word(self):
        files = steps()
        engine = [name for name in files if name.startswith("engine/")]
        self.assertEqual(engine, ["engine/joints/ring.hpp", "engine/joints/kinds.hpp"])
        with tempfile.TemporaryDirectory() as folder:
            self.there = pathlib.Path(folder)
            for name in COPIED:
                to = self.there / name
                to.parent.mkdir(parents=True, exist_ok=True)
                copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copyfile
                copy(ROOT / name, to)
            before = {p: p.read_bytes() for p in (self.there / "engine").rglob("*") if p.is_file()}
            for name, text in files.items():
                path = self.there / name
                path.parent.mkdir(parents=True, exist_ok=True)
                if path.exists():
                    add_to_list(path, text)
                else:
                    path.write_text(text)
            after = {p: p.read_bytes() for p in (self.there / "engine").rglob("*") if p.is_file()}
            touched = [p for p in after if before.get(p) != after[p]]
            self.assertLessEqual(len(touched), 2, touched)
            self.try_it()

    def try_it(self):
        (self.there / "tried.cpp").write_text(PROGRAM)
        with open(self.there / "CMakeLists.txt", "a") as lists:
            lists.write(BUILD)
        # Warnings and speed are other tests' business.
        self.run_there("cmake", "-B", "built", "-DCMAKE_BUILD_TYPE=None", "-DCMAKE_CXX_FLAGS=-O0 -w",
                       *[LEFT_OUT.format(f) for f in ("RENDER", "PROGRAM", "VIEW", "DEMOS", "TESTS")])
        self.run_there("cmake", "--build", "built", "--parallel", str(os.cpu_count() or 1))
        print(self.run_there("built/bin/tried", "assets/scenes/ring.json"), end="")
        if (self.there / "built/bin/contract").exists():
            print(self.run_there("built/bin/contract").strip().splitlines()[-1])


if __name__ == "__main__":
    unittest.main()
