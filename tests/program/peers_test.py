"""tools/peers/motion without any other engine: what it spells out, and how it compares."""
import contextlib
import importlib.machinery
import importlib.util
import io
import json
import math
import pathlib
import sys
import tempfile
import types
import unittest

ROOT = pathlib.Path(__file__).parents[2]
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("motion", str(ROOT / "tools/peers/motion"))
motion = importlib.util.module_from_spec(importlib.util.spec_from_loader("motion", loader))
loader.exec_module(motion)
spelt, parts = sys.modules["spelt"], sys.modules["parts"]
import verdict  # noqa: E402

SCENE = {
    "version": 1,
    "bodies": [
        {"name": "hand", "motion": "kinematic", "position": [1, 2, 0]},
        {"name": "rod", "position": [1, 1.5, 0], "mass": 2, "inertia": [1, 2, 3], "drag": 0}],
    "joints": [{"name": "pin", "kind": "hinge", "a": "hand", "b": "rod", "anchor": [1, 2, 0],
                "axis": [0, 0, -2]}],
    "paths": [{"body": "hand", "lissajous": {"amplitude": [0.5, 0, 0], "frequency": [2, 0, 0],
                                             "phase_deg": [90, 0, 0]}}]}
HALF = math.sqrt(0.5)


class Spelt(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name, "scene.json")

    def parts(self, **more):
        self.path.write_text(json.dumps({**SCENE, **more}))
        return parts.Parts(self.path)

    def test_bodies_joints_and_paths_come_back(self):
        start = {"hand": [1, 2, 0, 0, 0, 0, 1], "rod": [1, 1.5, 0, 0, 0, HALF, HALF]}
        text = self.parts().spelt(start, 3, 4)
        self.path.write_text(text)
        scene = spelt.Scene(self.path)
        self.assertEqual((scene.frames, scene.rate, scene.parts), (3, parts.RATE, 4))
        self.assertEqual([(b.name, b.motion, b.mass) for b in scene.bodies],
                         [("hand", "kinematic", 1), ("rod", "dynamic", 2)])
        joint, = scene.joints
        self.assertTrue(joint.is_hinge and scene.is_planar)
        for found, wanted in ((joint.anchor, [1, 2, 0]), (joint.axis, [0, 0, -1])):
            self.assertLess(math.dist(found, wanted), 1e-15)
        words = next(line for line in text.splitlines() if line.startswith("joint")).split()
        # Half a metre above a rod that is turned by a right angle about z is half a metre along its x.
        self.assertLess(math.dist([float(w) for w in words[7:10]], [0.5, 0, 0]), 1e-15)
        path = [float(w) for w in next(x for x in text.splitlines() if x.startswith("path")).split()[2:]]
        self.assertEqual(len(path), 7 * 12)
        for i in range(12):
            x = 0.5 + 0.5 * math.cos(4 * math.pi * (i + 1) / (4 * parts.RATE))
            self.assertLess(math.dist(path[7 * i:7 * i + 3], [x, 2, 0]), 1e-14)
        self.assertEqual(scene.sway.centre[1:], [2, 0])
        self.assertAlmostEqual(scene.sway.centre[0] + 0.5 * math.sin(scene.sway.phase[0]), 1)

    def test_springs_torques_and_the_rate_of_short_scenes_come_back(self):
        start = {"rod": [1, 1.5, 0, 0, 0, HALF, HALF]}
        spring = {"kind": "spring", "a": "world", "b": "rod", "point_a": [3, 2, 1], "point_b": [1, 2, 0],
                  "length": 0.7, "stiffness": 50}
        made = self.parts(bodies=SCENE["bodies"][1:], joints=[spring], paths=[], duration=0.03,
                           events=[{"type": "push", "body": "rod", "torque": [0, 0, 4]}])
        self.assertEqual(made.rate, 1000)
        self.path.write_text(made.spelt(start, 3, 4))
        scene = spelt.Scene(self.path)
        found, = scene.springs
        self.assertEqual((found.a, found.b, found.length, found.stiffness), (-1, 0, 0.7, 50))
        self.assertEqual(found.anchor_a, [3, 2, 1])
        self.assertLess(math.dist(found.anchor_b, [0.5, 0, 0]), 1e-15)
        self.assertEqual((scene.rate, scene.torques), (1000, [(0, [0, 0, 4])]))

    def test_instances_are_written_out(self):
        prefab = {"name": "arm", "bodies": SCENE["bodies"][1:],
                  "joints": [{"name": "pin", "a": "world", "b": "rod", "anchor": [1, 2, 0]}]}
        made = self.parts(bodies=[], joints=[], paths=[], prefabs=[prefab], instances=[
            {"name": "left", "prefab": "arm"}, {"name": "right", "prefab": "arm", "position": [5, 0, 1]}])
        self.assertEqual(list(made.bodies), ["left/rod", "right/rod"])
        self.assertEqual([(j["name"], j["a"], j["b"], j["anchor"]) for j in made.joints],
                         [("left/pin", "world", "left/rod", [1, 2, 0]),
                          ("right/pin", "world", "right/rod", [6, 2, 1])])

    def test_any_axis_is_turned_to(self):
        for axis in ([1, 0, 0], [-1, 0, 0], [0, 3, 0], [0, 0, -1], [-5, 0.1, 0.2], [0.3, -0.4, 0.5]):
            with self.subTest(axis):
                turned, size = spelt.rotated(parts.turn_of_x(axis), [1, 0, 0]), math.hypot(*axis)
                self.assertLess(math.dist(turned, [x / size for x in axis]), 1e-14)

    def test_what_others_cannot_express_is_refused_by_name(self):
        rod = SCENE["bodies"][1]
        for more, told in (({"cables": [{}]}, '"cables"'),
                           ({"bodies": [{**rod, "drag": 0.1}]}, "drag of rod"),
                           ({"bodies": [{**rod, "velocity": [1, 0, 0]}]}, '"velocity" of rod'),
                           ({"joints": [{**SCENE["joints"][0], "kind": "prismatic"}]}, "kind prismatic"),
                           ({"joints": [{"name": "s", "kind": "spring", "damping": 1}]}, '"damping" of s'),
                           ({"events": [{"type": "wind"}]}, "type wind"),
                           ({"prefabs": [{"name": "p"}], "instances": [
                               {"name": "i", "prefab": "p", "rotation_deg": [0, 1, 0]}]},
                            '"rotation_deg" of i'),
                           ({"events": [{"type": "push", "body": "rod", "force": [1, 0, 0]}]},
                            '"force" of the push of rod'),
                           ({"paths": [{"body": "hand", "steady": {}}]}, "the path of hand")):
            with self.subTest(told), self.assertRaises(SystemExit) as end:
                self.parts(**more)
            self.assertIn(told, str(end.exception))


class Run(unittest.TestCase):
    """A program that writes two frames of a body at rest, and ends with a code."""
    WRITES = ("import struct, sys; open(sys.argv[2], 'wb').write(b'version 1\\nframes 1\\n' + "
              "struct.pack('<30d', *[0.5, 1] + [0] * 13, *[0.5, 1] + [0] * 13)); ")

    def status_of(self, ends):
        with tempfile.TemporaryDirectory() as folder:
            run = object.__new__(motion.Measured)
            run.rows, run.folder, run.stem, run.frames = {}, pathlib.Path(folder), "scene", 2
            run.rate = parts.RATE
            run.options = types.SimpleNamespace(limit=1)
            run.parts = types.SimpleNamespace(bodies={"rod": None}, sway=None)
            run.moving, run.reference = ["rod"], {"rod": [[0, 0, 0]] * 3}
            (run.folder / "spelt_1.txt").touch()
            with contextlib.redirect_stderr(io.StringIO()):
                run.run("ode", [sys.executable, "-c", self.WRITES + ends], "quick", 0)
            row, = run.rows.values()
            return row["status"], [round(cost, 9) for cost in row["costs"]]

    def test_a_run_counts_only_if_its_program_ends_well(self):
        self.assertEqual(self.status_of("sys.exit(0)"), ("ok", [7.5]))
        self.assertEqual(self.status_of("sys.exit(4)"), ("failed", []))
        self.assertEqual(self.status_of("import os; os.abort()"), ("failed", []))


class Verdict(unittest.TestCase):
    ROWS = [{"scene": "s", "engine": engine, "method": "m", "step_s": str(step), "tolerance": "",
             "error_m": str(error), "cpu_ms_per_s": str(cost), "status": "ok"}
            for engine, points in (("pantin", [(1, 1e-2, 2), (0.5, 1e-4, 8)]), ("peer", [(1, 1e-3, 3)]))
            for step, error, cost in points]

    def test_costs_between_two_steps_lie_on_the_line(self):
        ladder = [(2, 1e-2), (8, 1e-4)]
        for error, cost in ((1e-1, 2), (1e-2, 2), (1e-3, 4), (1e-4, 8), (1e-5, math.inf)):
            self.assertAlmostEqual(verdict.cost_at(ladder, error), cost)
        # A finer step that is worse encloses nothing.
        self.assertEqual(verdict.cost_at([(2, 1e-4), (8, 1e-2)], 1e-3), 2)

    def test_a_peer_that_is_ahead_is_ahead(self):
        found = {error: (ours[0], other[0]) for _, error, ours, other in verdict.verdict(self.ROWS)}
        self.assertEqual(found[0.1], (2, 3))
        self.assertAlmostEqual(found[1e-3][0], 4)
        self.assertEqual(found[1e-3][1], 3)
        self.assertAlmostEqual(found[1e-4][0], 8)
        self.assertEqual(found[1e-4][1], math.inf)

    def test_failed_runs_are_no_choice(self):
        rows = [{**r, "status": "diverged"} for r in self.ROWS]
        self.assertEqual(verdict.ladders(rows, "s"), {})


if __name__ == "__main__":
    unittest.main()
