#!/usr/bin/env python3
"""A new kind of shape is its file and one word in a list: in a copy of the library a drum,
known by its support function alone, is added so, and then falls, is weighed, seen and described like the others."""
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
NEW = pathlib.Path(__file__).parent / "new_shape"
RADIUS, LENGTH, DENSITY, TOP = 0.2, 0.5, 700.0, 0.4

DRUM = {"type": "drum", "radius": RADIUS, "length": LENGTH}
PLANE = {"name": "ground", "motion": "fixed", "shape": {"type": "plane"}, "collision": True}
TABLE = {"name": "table", "motion": "fixed", "position": [5, TOP / 2, 0], "collision": True,
         "shape": {"type": "box", "size": [2, TOP, 2]}}

FIELD = {"name": "field", "motion": "fixed", "position": [-5, 0.7, 0], "collision": True,
         "shape": {"type": "height_field", "columns": 5, "rows": 5, "spacing": 0.5,
                   "heights": 25 * [0]}}

def body(name, at, lies):
    turn = {"rotation_deg": [0, 0, 90]} if lies else {}
    return {"name": name, "position": at, **turn, "shape": DRUM, "density": DENSITY,
            "collision": {"friction": 0.8}}

SCENE = {"version": 1, "step": 1 / 60, "bodies": [
    PLANE, TABLE, FIELD,
    body("standing", [0, 0.6, 0], False), body("lying", [0, 0.6, 2], True),
    body("standing_on_box", [5.3, 1.0, 0.3], False), body("lying_on_box", [4.9, 1.0, -0.4], True),
    body("standing_on_field", [-5.1, 1.3, 0.1], False)]}
HEIGHTS = {"standing": LENGTH / 2, "lying": RADIUS, "standing_on_box": TOP + LENGTH / 2,
           "lying_on_box": TOP + RADIUS, "standing_on_field": 0.7 + LENGTH / 2}

def run(*command, **options):
    done = subprocess.run([str(c) for c in command], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, **options)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))}\n{done.stdout[-4000:]}")
    return done.stdout

class NewShape(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.root = pathlib.Path(cls.folder.name) / "copy"
        shutil.copytree(ROOT / "engine", cls.root / "engine")
        # The whole of the change: a file, and a word.
        shutil.copy(NEW / "drum.cpp", cls.root / "engine" / "geometry" / "kinds")
        words = cls.root / "engine" / "geometry" / "kind_list.hpp"
        text = words.read_text()
        words.write_text(text.rstrip() + " \\\n  kind(drum)\n")
        assert text != words.read_text()
        shutil.copy(NEW / "fall.cpp", cls.root)
        (cls.root / "CMakeLists.txt").write_text(BUILD)
        build = cls.root / "build"
        run("cmake", "-S", cls.root, "-B", build, "-DCMAKE_BUILD_TYPE=None")
        run("cmake", "--build", build, "--parallel", os.cpu_count() or 1)
        scene = cls.root / "fall.json"
        scene.write_text(json.dumps(SCENE))
        cls.output = run(build / "fall", scene)
        cls.bodies = {}
        for line in cls.output.splitlines():
            if line.startswith("body "):
                words = line.split()
                cls.bodies[words[1]] = {
                    "height": float(words[3]), "upright": float(words[5]),
                    "speed": float(words[7]), "mass": float(words[9]),
                    "inertia": sorted(float(w) for w in words[11:14])}

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_comes_to_rest_on_planes_boxes_and_fields(self):
        self.assertEqual(sorted(self.bodies), sorted(HEIGHTS))
        for name, height in HEIGHTS.items():
            with self.subTest(name):
                found = self.bodies[name]
                self.assertLess(abs(found["height"] - height), 1e-3)
                self.assertLess(found["speed"], 2e-2)
                self.assertAlmostEqual(found["upright"], 0 if "lying" in name else 1, delta=1e-3)

    def test_weighs_what_the_closed_form_says(self):
        mass = DENSITY * math.pi * RADIUS ** 2 * LENGTH
        along = mass * RADIUS ** 2 / 2
        across = mass * (3 * RADIUS ** 2 + LENGTH ** 2) / 12
        for found in self.bodies.values():
            self.assertAlmostEqual(found["mass"], mass, delta=1e-12 * mass)
            for got, want in zip(found["inertia"], sorted([along, across, across])):
                self.assertAlmostEqual(got, want, delta=1e-12 * want)

    def test_is_met_by_rays_and_nearest_points(self):
        ray = float(re.search(r"^ray (.*)$", self.output, re.M)[1])
        near = float(re.search(r"^near (.*)$", self.output, re.M)[1])
        self.assertAlmostEqual(ray, math.sqrt(RADIUS ** 2 - 0.02 ** 2), delta=2e-4)
        self.assertAlmostEqual(near, 0.3 - RADIUS, delta=2e-4)

    def test_is_described_like_the_others(self):
        described = json.loads(re.search(r"^schema (.*)$", self.output, re.M)[1])
        self.assertEqual(described["required"], ["type", "radius"])
        self.assertIn({"anyOf": [{"required": [key]} for key in ("length", "from", "to")]},
                      described["allOf"])
        self.assertIn("density", described["properties"])
        self.assertIn("rotation_deg", described["properties"])

# The library's own files, without what makes it fast.
BUILD = """
cmake_minimum_required(VERSION 3.22)
project(new_shape CXX)
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_EXTENSIONS OFF)
find_package(Threads REQUIRED)
find_package(glm CONFIG REQUIRED)
add_compile_options(-O0 -g0 -ffp-contract=off -DPANTIN_CHECKED)
include_directories(${CMAKE_SOURCE_DIR} ${CMAKE_SOURCE_DIR}/engine)
file(GLOB_RECURSE core CONFIGURE_DEPENDS engine/*.cpp)
list(FILTER core EXCLUDE REGEX "/engine/(render|pantin)/")
add_executable(fall fall.cpp ${core})
set_source_files_properties(${CMAKE_SOURCE_DIR}/engine/solvers/articulated/kernels.cpp PROPERTIES
                            COMPILE_DEFINITIONS PANTIN_KERNELS=baseline COMPILE_OPTIONS "-O1;-Wno-psabi"
                            SKIP_PRECOMPILE_HEADERS ON)
target_link_libraries(fall PRIVATE glm::glm Threads::Threads)
target_precompile_headers(fall PRIVATE <algorithm> <array> <cmath> <cstdint> <functional> <memory>
                          <span> <string> <string_view> <unordered_map> <variant> <vector>
                          ${CMAKE_SOURCE_DIR}/engine/base/math.hpp
                          ${CMAKE_SOURCE_DIR}/engine/world/world.hpp)
"""

if __name__ == "__main__":
    unittest.main()
