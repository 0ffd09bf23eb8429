"""check_rooms.py finds includes that go the wrong way, and names them."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

CHECK = pathlib.Path(__file__).parents[2] / "tools" / "check_rooms.py"


class Rooms(unittest.TestCase):
    def check(self, files):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "engine").mkdir()
            for name, text in files.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text)
            done = subprocess.run([sys.executable, CHECK, root], capture_output=True, text=True)
            return done.returncode, done.stdout

    def refused(self, path, line, *words):
        code, out = self.check({path: "#pragma once\n" + line + "\n"})
        self.assertEqual(code, 1, out)
        for word in (f"{path}:2:", *words):
            self.assertIn(word, out)

    def test_the_arrows_as_drawn_are_accepted(self):
        code, out = self.check({
            "engine/world/body.hpp": '#include "engine/base/math.hpp"\n'
                                     '#include "engine/world/link.hpp"\n',
            "engine/runtime/step.cpp": '#include "engine/solvers/solver.hpp"\n',
            "tools/pantin/run.cpp": '#include "engine/render/capture.hpp"\n#include <SDL.h>\n',
            "tests/scene/a_test.cpp": '#include "engine/scene/scene.hpp"\n'
                                      '#include "tests/chain.hpp"\n',
        })
        self.assertEqual(code, 0, out)

    def test_a_room_below_does_not_include_one_above(self):
        self.refused("engine/base/a.hpp", '#include "engine/world/world.hpp"', "base", "not world")

    def test_solvers_scene_and_render_do_not_know_each_other(self):
        self.refused("engine/render/a.cpp", '#include "engine/scene/scene.hpp"', "not scene")
        self.refused("engine/solvers/x/a.cpp", '#include "engine/render/renderer.hpp"', "not render")
        self.refused("engine/scene/a.cpp", '#  include "engine/solvers/solver.hpp"', "not solvers")

    def test_the_core_builds_without_scene_and_render(self):
        self.refused("engine/runtime/a.cpp", '#include "engine/scene/scene.hpp"', "not scene")

    def test_the_engine_does_not_include_programs(self):
        self.refused("engine/world/a.cpp", '#include "tools/pantin/options.hpp"', "tools")

    def test_paths_are_spelled_from_the_root(self):
        self.refused("engine/world/a.cpp", '#include "body.hpp"', "spelled from the root")

    def test_glm_comes_through_one_file(self):
        self.refused("engine/world/a.hpp", "#include <glm/vec3.hpp>", "engine/base/math.hpp")

    def test_one_file_parses_the_command_line(self):
        self.refused("tools/pantin/run.cpp", "#include <CLI/CLI.hpp>", "command_line.cpp")

    def test_an_unknown_room_is_named(self):
        code, out = self.check({"engine/utils/a.hpp": ""})
        self.assertEqual(code, 1)
        self.assertIn("engine/utils", out)


if __name__ == "__main__":
    unittest.main()
