"""pantin assemble: parts come together, the scene that is written loads, contradictions are named."""
import csv
import json
import math
import os
import pathlib
import subprocess
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]
SCENES = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes"

# A four-bar linkage whose bars are written where they do not meet.
APART = """{
  // Bars of 0.3, 1 and 0.8 m.
  "version": 1, "title": "apart", "solver": {"type": "lagrangian"},
  "bodies": [
    {"name": "crank", "position": [3, 1, 0], "shape": {"type": "capsule", "radius": 0.02, "length": 0.3}},
    {"name": "coupler", "position": [-2, 2, 0.5], "shape": {"type": "capsule", "radius": 0.02, "length": 1}},
    {"name": "rocker", "position": [0, -2, 0.2], "rotation_deg": [30, 40, 50],
     "shape": {"type": "capsule", "radius": 0.02, "length": 0.8}}],
  "joints": [
    {"name": "A", "kind": "hinge", "a": "world", "b": "crank", "anchor_a": [0, 0, 0],
     "anchor_b": [0, -0.15, 0], %(axes)s},
    {"name": "B", "kind": "hinge", "a": "crank", "b": "coupler", "anchor_a": [0, 0.15, 0],
     "anchor_b": [0, -0.5, 0], %(axes)s},
    {"name": "C", "kind": "hinge", "a": "coupler", "b": "rocker", "anchor_a": [0, 0.5, 0],
     "anchor_b": [0, 0.4, 0], %(axes)s},
    {"name": "D", "kind": "hinge", "a": "rocker", "b": "world", "anchor_a": [0, -0.4, 0],
     "anchor_b": [1, 0, 0], %(axes)s}%(more)s],
}
"""
AXES = '"axis_a": [0, 0, 1], "across_a": [1, 0, 0], "axis_b": [0, 0, 1], "across_b": [1, 0, 0]'


def pantin(*arguments):
    return subprocess.run([PANTIN, *map(str, arguments)], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300)


class Assemble(unittest.TestCase):
    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)
        self.apart = self.folder / "apart.json5"
        self.apart.write_text(APART % {"axes": AXES, "more": ""})

    def tearDown(self):
        self.kept.cleanup()

    def told(self, *arguments, code=0):
        done = pantin("assemble", *arguments, "--json")
        self.assertEqual(done.returncode, code, done.stderr)
        return json.loads(done.stdout)

    def test_parts_that_lie_apart_come_together(self):
        out = self.folder / "together.json5"
        told = self.told(self.apart, "--out", out)
        self.assertEqual(told["status"], "assembled")
        self.assertLess(told["residual"], 1e-12)
        self.assertEqual((told["rows"], told["rank"], told["mobility"]), (20, 17, 1))
        self.assertEqual(sum(law["rows"] for law in told["redundant"]), 3)
        self.assertGreater(told["moved_m"], 1)
        self.assertEqual({law["law"] for law in told["residuals"]}, {"A", "B", "C", "D"})
        # What was written is closed, and all else is as it was.
        self.assertIn("// Bars of 0.3, 1 and 0.8 m.", out.read_text())
        again = self.told(out)
        self.assertEqual(again["iterations"], 0)
        self.assertLess(again["residual"], 1e-12)
        self.assertLess(again["moved_m"], 1e-12)
        checked = pantin("check", out)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        # Poses that are there already are replaced.
        twice = self.folder / "twice.json5"
        self.told(out, "--scatter", "1", "--seed", "5", "--out", twice)
        self.assertEqual(twice.read_text().count('"poses"'), 1)
        self.assertLess(self.told(twice)["residual"], 1e-12)

    def test_every_kind_of_law_closes_from_scattered_bodies(self):
        for name in ("stewart", "bricard", "marionette", "elliptical_gears", "egg_in_bowl",
                     "curve_four_bar", "slider_crank", "planar_belts", "joint_ranges", "crane"):
            with self.subTest(name):
                out = SCENES / f"{name}.json"
                told = self.told(out, "--scatter", "0.2", "--seed", "3")
                self.assertLess(told["residual"], 1e-12)

    def test_held_bodies_stay(self):
        out = self.folder / "held.json5"
        # Its hinge D is far away. The scene may follow the option.
        self.told("--hold", "rocker", self.apart, "--out", out, code=3)
        self.assertNotIn('"body": "rocker"', out.read_text())
        self.assertIn('"body": "crank"', out.read_text())

    def test_contradictions_are_named(self):
        strut = ''', {"name": "strut", "kind": "distance", "a": "world", "b": "coupler",
            "anchor_a": [0, 5, 0], "anchor_b": [0, 0, 0], "length": 1}'''
        self.apart.write_text(APART % {"axes": AXES, "more": strut})
        done = pantin("assemble", self.apart)
        self.assertEqual(done.returncode, 3)
        self.assertEqual(len(done.stderr.splitlines()), 1)
        self.assertIn("strut", done.stderr)
        self.assertIn("NOT assembled", done.stdout)
        told = self.told(self.apart, code=3)
        self.assertIn("strut", told["contradictory"])
        self.assertLess(len(told["contradictory"]), 5)
        self.assertGreater(told["residual"], 0.1)
        largest = [law["residual"] for law in told["residuals"]]
        self.assertEqual(largest, sorted(largest, reverse=True))

    def test_trace_and_methods(self):
        for method in ("auto", "gauss-newton", "lm", "gradient", "gradient-safe", "momentum",
                       "gauss-seidel", "euler-angles"):
            with self.subTest(method):
                trace = self.folder / f"{method}.csv"
                told = self.told(SCENES / "four_bar.json", "--scatter", "0", "--method", method,
                                 "--trace", trace, "--tolerance", "1e-6", "--iterations", "20000",
                                 "--starts", "0")
                with trace.open() as file:
                    rows = list(csv.DictReader(file))
                self.assertEqual(rows[0].keys(),
                                 {"iteration", "seconds", "residual", "merit", "damping"})
                self.assertLess(float(rows[-1]["residual"]), 1e-6)
                self.assertTrue(all(math.isfinite(float(row["merit"])) for row in rows))
                self.assertEqual(told["method"], method)

    def test_trials(self):
        told = self.told(SCENES / "four_bar.json", "--scatter", "1", "--trials", "50")
        self.assertEqual((told["trials"], told["assembled"], told["failed"]), (50, 50, []))
        self.assertGreater(told["iterations_median"], 2)

    def test_what_is_refused(self):
        for arguments, words in [
                ((self.folder / "none.json",), ["none.json"]),
                ((self.apart, "--hold", "rokcer"), ["--hold", '"rokcer"', 'nearest is "rocker"']),
                ((self.apart, "--method", "magic"), ["--method"]),
                ((self.apart, "--tolerance", "0"), ["--tolerance"]),
                ((SCENES / "stewart.json", "--out", self.folder / "no" / "such.json"), ["such.json"])]:
            done = pantin("assemble", *arguments)
            self.assertIn(done.returncode, (2, 4), arguments)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            for word in words:
                self.assertIn(word, done.stderr)


if __name__ == "__main__":
    unittest.main()
