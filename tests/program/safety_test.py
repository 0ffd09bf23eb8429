"""The program and files that mean harm: escape sequences, interrupts, scenes too large to step."""
import json
import math
import os
import pathlib
import re
import resource
import signal
import subprocess
import tempfile
import time
import unittest

PANTIN = os.environ["PANTIN"]

# Control characters of both sets [ECMA-48], but for the ends of lines.
CONTROLS = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u2028-\u202e]")
ATTACK = "\x1b]0;x\x07\x9b31m\u202e"


class Safety(unittest.TestCase):
    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)

    def tearDown(self):
        self.kept.cleanup()

    def write(self, scene):
        path = self.folder / "scene.json"
        path.write_text(scene if isinstance(scene, str) else json.dumps(scene))
        return path

    def run_pantin(self, *arguments):
        done = subprocess.run([PANTIN, *map(str, arguments)], stdin=subprocess.DEVNULL,
                              capture_output=True, timeout=120)
        return done.returncode, done.stdout.decode() + done.stderr.decode()

    def test_text_of_a_scene_reaches_no_terminal_as_it_is(self):
        path = self.write({"version": 1, "title": ATTACK, "duration": 0.05, "bodies": [
            {"name": "a\x9b31m", "mass": 1, "inertia": [1, 1, 1], "rotation": [0, 0, 0, 1.0001]}],
            "pins": [{"name": "p\x9b31m", "body": "a\x9b31m", "target": [9, 0, 0], "priority": 1},
                     {"name": "q\x9b31m", "body": "a\x9b31m", "target": [0, 0, 0]}]})
        for command in ("run", "check", "bench"):
            for options in ((), ("--json",)):
                with self.subTest(command=command, options=options):
                    code, shown = self.run_pantin(command, path, *options)
                    self.assertIn(code, (0, 3), shown)
                    self.assertIsNone(CONTROLS.search(shown), ascii(shown))
        told = json.loads(self.run_pantin("run", path, "--json")[1].split("\nwarning")[0])
        self.assertEqual(told["title"], ATTACK)

    def test_complaints_about_a_scene_reach_no_terminal_as_they_are(self):
        for scene in ({"version": 1, ATTACK: 1}, {"version": 1, "solver": {"type": ATTACK}},
                      {"version": 1, "bodies": [{"name": "b", "motion": ATTACK}]}):
            code, shown = self.run_pantin("check", self.write(scene))
            self.assertEqual(code, 2)
            self.assertIn("\\u001b", shown)
            self.assertIsNone(CONTROLS.search(shown), ascii(shown))

    def assert_ends_at_once(self, path):
        for number in (signal.SIGTERM, signal.SIGINT):
            process = subprocess.Popen([PANTIN, "check", str(path)], stdin=subprocess.DEVNULL,
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            time.sleep(0.5)
            self.assertIsNone(process.poll(), "done before it could be interrupted")
            asked = time.monotonic()
            process.send_signal(number)
            process.communicate(timeout=30)
            self.assertEqual(process.returncode, 130)
            self.assertLess(time.monotonic() - asked, 5)

    def test_loading_ends_at_once_when_interrupted(self):
        body = ('{"name": "b%d", "mass": 1, "inertia": [1, 1, 1], "position": [%d, 0, 0], '
                '"rotation": [0, 0, 0, 1]}')
        bodies = ",".join(body % (i, i) for i in range(300_000))
        self.assert_ends_at_once(self.write('{"version": 1, "bodies": [' + bodies + "]}"))

    def test_checking_ends_at_once_when_interrupted(self):
        ball = {"mass": 1, "inertia": [1, 1, 1]}
        self.assert_ends_at_once(self.write({"version": 1, "bodies": [
            {"name": "a", **ball}, {"name": "b", **ball, "position": [1, 0, 0]}],
            "joints": [{"a": "a", "b": "b", "anchor": [0, i, 0]} for i in range(2000)]}))

    def test_a_pile_of_a_hundred_spheres_is_checked_soon(self):
        """One that could lie there, and one where each sphere is inside all others."""
        def layers(i):
            return [0.2 * (i % 5) + 0.01 * (i // 25), 0.1 + 0.19 * (i // 25), 0.2 * (i // 5 % 5)]

        def knot(i):
            return [0.01 * math.cos(i), 0.1 + 0.003 * i, 0.01 * math.sin(i)]

        for place, least_steps in ((layers, 60), (knot, 1)):
            with self.subTest(place.__name__):
                path = self.write({"version": 1, "bodies": [
                    {"name": "ground", "motion": "fixed", "shape": {"type": "plane"}, "collision": True},
                    *({"name": f"ball{i}", "position": place(i), "density": 1000,
                       "shape": {"type": "sphere", "radius": 0.1},
                       "collision": {"others": True, "friction": 0.5, "restitution": 0.3}}
                      for i in range(100))]})
                before = resource.getrusage(resource.RUSAGE_CHILDREN)
                code, out = self.run_pantin("check", path, "--json")
                after = resource.getrusage(resource.RUSAGE_CHILDREN)
                self.assertEqual(code, 0, out)
                self.assertGreaterEqual(json.loads(out[out.index("{"):out.rindex("}") + 1])
                                        ["scenes"][0]["steps"], least_steps)
                self.assertLess(after.ru_utime - before.ru_utime, 15)


if __name__ == "__main__":
    unittest.main()
