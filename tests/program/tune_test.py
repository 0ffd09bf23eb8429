"""pantin tune, seen from outside: choices hold when run again, are the cheapest, and are written."""
import csv
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]
SCENES = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes"
ROD = {"name": "rod", "position": [0.5, 0, 0], "mass": 1, "inertia": [0.02, 0.1, 0.1], "drag": 0}
HINGE = {"name": "pivot", "kind": "hinge", "a": "world", "b": "rod", "anchor": [0, 0, 0],
         "axis": [0, 0, 1]}
PENDULUM = {"version": 1, "step": 0.01, "duration": 1.6, "bodies": [ROD], "joints": [HINGE]}
DOUBLE = {**PENDULUM,
          "bodies": [ROD, {**ROD, "name": "tip", "position": [1, 0, 0.5],
                           "inertia": [0.1, 0.1, 0.02]}],
          "joints": [HINGE, {"kind": "ball", "a": "rod", "b": "tip", "anchor": [1, 0, 0]}]}
METHODS = "auto,planar,lagrangian/rk4,lagrangian/implicit"
# A driven loop in the plane, two arms that swing out of it, and a box on another.
BAR = {"mass": 1, "inertia": [0.02, 0.02, 0.02], "drag": 0}
BOX = {"shape": {"type": "box", "size": [0.4, 0.4, 0.4]}, "density": 400, "collision": True}
Z = {"kind": "hinge", "axis": [0, 0, 1]}
APART = {
    "version": 1, "step": 0.01, "duration": 1.6,
    "bodies": [
        {**BAR, "name": "crank", "position": [0, 0.1, 0]},
        {**BAR, "name": "coupler", "position": [0.4, 0.4, 0]},
        {**BAR, "name": "rocker", "position": [0.8, 0.3, 0]},
        {**ROD, "name": "rod", "position": [10.5, 0, 0]},
        {**ROD, "name": "tip", "position": [11, 0, 0.5], "inertia": [0.1, 0.1, 0.02]},
        {**ROD, "name": "rod2", "position": [20.5, 0, 0]},
        {**ROD, "name": "tip2", "position": [21, 0, 0.5], "inertia": [0.1, 0.1, 0.02]},
        {**BOX, "name": "box", "position": [-10, 0.2, 0]},
        {**BOX, "name": "box2", "position": [-10, 0.7, 0]},
        {"name": "floor", "motion": "fixed", "shape": {"type": "plane"}, "collision": True}],
    "joints": [
        {**Z, "a": "world", "b": "crank", "anchor": [0, 0, 0],
         "motor": {"velocity": 3, "gain": 10, "cap": 20}},
        {**Z, "a": "crank", "b": "coupler", "anchor": [0, 0.2, 0]},
        {**Z, "a": "coupler", "b": "rocker", "anchor": [0.8, 0.6, 0]},
        {**Z, "a": "world", "b": "rocker", "anchor": [0.8, 0, 0]},
        {**HINGE, "a": "world", "b": "rod", "anchor": [10, 0, 0], "name": "p"},
        {"kind": "ball", "a": "rod", "b": "tip", "anchor": [11, 0, 0]},
        {**HINGE, "a": "world", "b": "rod2", "anchor": [20, 0, 0], "name": "p2"},
        {"kind": "ball", "a": "rod2", "b": "tip2", "anchor": [21, 0, 0]}]}

# A disc on an axle that a motor spins up: speed v (1 - exp(-g t / I)). It only turns.
FLYWHEEL = {
    "version": 1, "duration": 2,
    "bodies": [{"name": "disc", "shape": {"type": "cylinder", "radius": 0.2, "length": 0.05}, "mass": 2,
                "inertia": [0.02, 0.04, 0.02], "rotation_deg": [90, 0, 0], "position": [0, 1, 0], "drag": 0}],
    "joints": [{**HINGE, "name": "axle", "b": "disc", "anchor": [0, 1, 0],
                "motor": {"velocity": 20, "gain": 0.1}}]}
# A mass on a spring, 15 times a second: x = 1 + 0.5 cos(w t).
RATE = 2 * math.pi * 15
OSCILLATOR = {
    "version": 1, "duration": 2, "gravity": [0, 0, 0],
    "bodies": [{"name": "ball", "shape": {"type": "sphere", "radius": 0.1}, "mass": 1,
                "position": [1.5, 0, 0], "drag": 0}],
    "joints": [{"name": "rail", "kind": "prismatic", "a": "world", "b": "ball", "anchor": [1, 0, 0],
                "axis": [1, 0, 0]},
               {"kind": "spring", "a": "world", "b": "ball", "point_a": [0, 0, 0], "length": 1,
                "stiffness": RATE ** 2}]}
# A ball at rest that is struck at half a second: x = 0 until then, t - 0.5 after that.
STRUCK = {
    "version": 1, "duration": 1, "gravity": [0, 0, 0],
    "bodies": [{"name": "ball", "shape": {"type": "sphere", "radius": 0.1}, "mass": 1,
                "position": [0, 1, 0], "drag": 0}],
    "events": [{"type": "impulse", "body": "ball", "impulse": [1, 0, 0], "at": 0.5}]}
# Three light rods and a weight, straight out: they whip when they hang.
LIGHT = {"mass": 1, "inertia": [1e-4, 0.0075, 0.0075], "drag": 0}
WHIP = {
    "version": 1, "duration": 3,
    "bodies": [*({**LIGHT, "name": f"rod {i}", "position": [0.15 + 0.3 * i, 2, 0]} for i in range(3)),
               {"name": "end", "mass": 50, "inertia": [0.2] * 3, "position": [1, 2, 0], "drag": 0}],
    "joints": [{**HINGE, "name": f"hinge {i}", "a": f"rod {i - 1}" if i else "world",
                "b": f"rod {i}" if i < 3 else "end", "anchor": [0.3 * i, 2, 0]} for i in range(4)]}


def pantin(*arguments):
    return subprocess.run([PANTIN, *map(str, arguments)], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=240)


class Tune(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)

    def scene(self, scene, name="scene.json"):
        path = self.folder / name
        path.write_text(scene if isinstance(scene, str) else json.dumps(scene))
        return path

    def tune(self, path, *options, code=0):
        done = pantin("tune", path, "--json", "--results", self.folder / "tune", *options)
        self.assertEqual(done.returncode, code, done.stderr)
        return json.loads(done.stdout)

    def chart(self, path, *options):
        done = pantin("chart", path, "--out", self.folder / "chart", "--json", "--afresh", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)["scenes"][0]

    def test_the_choice_meets_the_error_when_it_is_run_again(self):
        path, out = self.scene(DOUBLE), self.folder / "tuned.json"
        for asked in (1e-2, 1e-4, 1e-7):
            tuned = self.tune(path, "--error", asked, "--within", 40, "--out", out)
            choice = tuned["choice"]
            self.assertTrue(tuned["met"])
            self.assertLessEqual(choice["error"], asked)
            written = json.loads(out.read_text())
            self.assertEqual(written["step"], choice["step_s"])
            again = self.chart(out, "--methods", "scene", "--coarsest", written["step"], "--rungs",
                               1, "--repeat", 1, "--time", 40)
            if choice["tolerance"]:
                # `chart` varies the steps of the file's own settings, not the tolerance in it.
                self.assertEqual(written["solver"]["step_tolerance"], choice["tolerance"])
            (run,) = again["runs"]
            self.assertEqual(run["status"], "ok")
            self.assertLessEqual(run["position_m"] / again["size_m"], 1.05 * asked)

    def costs(self, scene, settings):
        """The least costs of a scene under several settings, measured in turn."""
        costs = [float("inf")] * len(settings)
        for _ in range(3):
            for k, (method, step, tolerance) in enumerate(settings):
                solver, *integrator = method.split("/")
                words = {"type": solver}
                if integrator:
                    words["integrator"] = integrator[0]
                if tolerance:
                    words["step_tolerance"] = tolerance
                path = self.scene({**scene, "step": step, "solver": words}, f"{k}.json")
                (run,) = self.chart(path, "--methods", "scene", "--coarsest", step, "--rungs", 1,
                                    "--repeat", 3, "--time", 3)["runs"]
                costs[k] = min(costs[k], run["cost_low_ns"])
        return costs

    def test_it_is_nearly_the_cheapest_of_an_exhaustive_ladder(self):
        for name, scene, asked in (("one", PENDULUM, 1e-3), ("two", DOUBLE, 1e-5)):
            with self.subTest(name):
                path = self.scene(scene)
                all_runs = self.chart(path, "--coarsest", 0.04, "--rungs", 8, "--time", 60)
                good = [run for run in all_runs["runs"] if run["status"] == "ok" and
                        run["position_m"] <= asked * all_runs["size_m"]]
                self.assertGreater(len(good), 10)
                choice = self.tune(path, "--error", asked, "--within", 60)["choice"]
                self.assertLessEqual(choice["error"], asked)
                cheapest = sorted(good, key=lambda run: run["cost_low_ns"])[:3]
                own, *others = self.costs(scene, [(run["method"], run["step_s"], run["tolerance"])
                                                  for run in (choice, *cheapest)])
                self.assertLessEqual(own, 1.3 * min(others))

    def test_a_shorter_step_that_is_cheaper_is_found(self):
        # The bricks come to rest later at steps of 33 ms, which meet the error, than at 17 ms.
        asked = 2e-2
        told = self.tune(SCENES / "stack_askew.json", "--error", asked, "--within", 60, "--methods", "planar")
        (planar,) = told["methods"]
        good = [run for run in planar["runs"] if run["error"] is not None and run["error"] <= asked]
        self.assertEqual(told["choice"]["cost_us"], min(run["cost_us"] for run in good))
        self.assertLess(told["choice"]["step_s"], max(run["step_s"] for run in good))

    def test_a_planar_scene_chooses_planar(self):
        tuned = self.tune(SCENES / "slider_crank.json", "--error", 1e-2, "--within", 60)
        self.assertEqual(tuned["choice"]["method"], "planar")
        verdicts = {m["method"]: m["verdict"] for m in tuned["methods"]}
        self.assertEqual(verdicts["planar"], "chosen")
        self.assertNotIn("chosen", [v for m, v in verdicts.items() if m != "planar"])
        for method in tuned["methods"]:
            self.assertTrue(method["why"])

    def test_a_scene_with_an_error_runs_as_the_cheapest_model(self):
        """Every shipped scene of the plane, and one of space: to the bits of that model."""
        flat = [p for p in sorted(SCENES.glob("*.json")) if '"type": "planar"' in p.read_text()]
        self.assertGreater(len(flat), 7)
        for path in [*flat, SCENES / "slider_crank.json", SCENES / "marionette.json"]:
            with self.subTest(path.stem):
                runs = []
                model = "auto" if path.stem == "marionette" else "planar"
                for key in ('"error": 0.01, "solver": {"type": "auto"}',
                            f'"solver": {{"type": "{model}"}}'):
                    text = re.sub(r'"solver": \{[^}]*\}', "", path.read_text())
                    text = re.sub(r',\s*,', ",", text).replace("{", "{" + key + ",", 1)
                    # Beside the scene, for the files that it names.
                    folder = self.folder / "scenes"
                    if not folder.exists():
                        shutil.copytree(SCENES.parent, self.folder / "assets")
                        folder.symlink_to(self.folder / "assets/scenes")
                    (folder / "now.json5").write_text(text)
                    done = pantin("run", folder / "now.json5", "--duration", 0.1, "--json")
                    self.assertEqual(done.returncode, 0, done.stderr)
                    runs.append(json.loads(done.stdout))
                self.assertEqual(runs[0]["solver"], model)
                self.assertEqual(runs[0]["solvers"], runs[1]["solvers"])
                self.assertEqual(runs[0]["hash"], runs[1]["hash"])

    def test_more_time_is_more_accurate_and_time_is_kept(self):
        path = self.scene(DOUBLE)
        cheap = self.tune(path, "--error", 1e-2, "--within", 40)["choice"]
        errors = []
        for factor in (1.5, 20):
            time_us = factor * cheap["cost_us"]
            tuned = self.tune(path, "--time", time_us, "--within", 40)
            self.assertLessEqual(tuned["choice"]["cost_us"], time_us)
            errors.append(tuned["choice"]["error"])
        self.assertLess(errors[1], 0.1 * errors[0])
        none = self.tune(path, "--time", 0.001, "--within", 40, code=3)
        self.assertFalse(none["met"])

    def test_what_cannot_be_met_ends_with_3_and_the_best(self):
        out = self.folder / "tuned.json"
        tuned = self.tune(self.scene(PENDULUM), "--error", 1e-10, "--methods",
                          "auto,lagrangian/euler", "--within", 20, "--out", out, code=3)
        self.assertFalse(tuned["met"])
        runs = [r for m in tuned["methods"] for r in m["runs"] if r["status"] == "ok"]
        self.assertEqual(tuned["choice"]["error"], min(r["error"] for r in runs))
        self.assertFalse(out.exists())
        told = pantin("tune", self.scene(PENDULUM), "--error", 1e-10, "--methods", "auto",
                      "--results", self.folder / "tune", "--within", 20)
        self.assertEqual(told.returncode, 3)
        self.assertRegex(told.stderr, r"^pantin: .*no setting meets an error of 1e-10.*\n$")
        self.assertIn("best", told.stdout)

    def test_the_rest_of_the_file_stays(self):
        text = ('{ // a pendulum\n  "version": 1, "duration": 1,\n  "solver": {"type": "auto", "sweeps": 7},'
                f'\n  "step": 0.01, /* here */\n  "bodies": [{json.dumps(ROD)}],\n  "joints": '
                f'[{json.dumps(HINGE)}]\n}}\n')
        path, out = self.scene(text, "scene.json5"), self.folder / "tuned.json5"
        tuned = self.tune(path, "--error", 1e-2, "--methods", "lagrangian/rk4", "--within", 20,
                          "--out", out)
        step = tuned["choice"]["step_s"]
        written = out.read_text()
        self.assertIn(f'/* here */', written)
        self.assertTrue(written.startswith("{ // a pendulum\n"))
        self.assertIn('"lagrangian"', written)
        self.assertIn('"integrator": "rk4"', written)
        self.assertTrue(written.endswith(text[text.index(", /* here */"):]))
        self.assertAlmostEqual(float(written.split('"step": ')[1].split(",")[0]), step, delta=0)
        self.assertEqual(pantin("check", out).returncode, 0)
        # A body with settings of its own would not follow the scene's.
        own = {**PENDULUM, "bodies": [{**ROD, "solver": {"type": "lagrangian"}}]}
        done = pantin("tune", self.scene(own), "--error", 0.1, "--methods", "auto", "--within", 20,
                      "--results", self.folder / "tune", "--out", self.folder / "none.json")
        self.assertEqual(done.returncode, 1)
        self.assertIn("solver settings of single bodies", done.stderr)
        self.assertFalse((self.folder / "none.json").exists())

    def test_groups_that_never_meet_have_methods_of_their_own(self):
        """A loop in the plane, far from two arms that swing out of it and from two boxes."""
        out = self.folder / "tuned.json"
        tuned = self.tune(self.scene(APART), "--error", 1e-3, "--within", 100, "--rungs", 4,
                          "--methods", METHODS, "--out", out)
        self.assertTrue(tuned["met"])
        groups = {g["group"].split(",")[0]: g for g in tuned["groups"]}
        self.assertEqual(set(groups), {"crank", "rod", "box"})
        self.assertEqual((groups["rod"]["alike"], groups["box"]["bodies"]), (2, 2))
        for group in groups.values():
            self.assertTrue(group["why"])
            self.assertLessEqual(group["choice"]["error"], 1e-3)
            self.assertEqual(group["choice"]["step_s"], tuned["choice"]["step_s"])
        methods = {g["choice"]["method"] for g in groups.values()}
        self.assertGreater(len(methods), 1)
        # The whole scene was run: the error is met, and it costs less than one method for all.
        self.assertEqual(tuned["choice"], tuned["mixed"])
        self.assertLessEqual(tuned["choice"]["error"], 1e-3)
        if tuned["uniform"] and tuned["uniform"]["status"] == "ok":
            self.assertLess(tuned["choice"]["cost_us"], tuned["uniform"]["cost_us"])
        written = json.loads(out.read_text())
        self.assertEqual(written["step"], tuned["choice"]["step_s"])
        own = {b["name"]: b["solver"]["type"] for b in written["bodies"] if "solver" in b}
        for first in ("crank", "rod", "rod2", "box", "box2"):
            asked = groups.get(first, groups["rod" if first == "rod2" else "box"])["choice"]["method"]
            self.assertEqual(own.get(first, written["solver"]["type"]), asked.split("/")[0])

    def test_groups_that_meet_are_one(self):
        """Boxes, one above the other, are one group; far apart on the floor they are two."""
        boxes, floor = APART["bodies"][-3:-1], APART["bodies"][-1]
        one = {**APART, "bodies": [*boxes, floor], "joints": []}
        tuned = self.tune(self.scene(one), "--error", 0.1, "--within", 20, "--methods", "auto")
        self.assertEqual(tuned["groups"], [])
        far = [{**b, "position": [3 * i, 0.2, 0], "velocity": [1, 0, 0]} for i, b in enumerate(boxes)]
        tuned = self.tune(self.scene({**one, "bodies": [*far, floor]}), "--error", 0.1, "--within",
                          20, "--methods", "auto")
        self.assertEqual(sum(g["alike"] for g in tuned["groups"]), 2)

    def test_one_choice_for_all_groups_where_it_is_as_cheap(self):
        both = {**PENDULUM, "bodies": [ROD, {**ROD, "name": "other", "position": [5.5, 0, 0]}],
                "joints": [HINGE, {**HINGE, "name": "far", "b": "other", "anchor": [5, 0, 0]}]}
        out = self.folder / "tuned.json"
        tuned = self.tune(self.scene(both), "--error", 1e-3, "--within", 60, "--rungs", 4,
                          "--methods", METHODS, "--out", out)
        (group,) = tuned["groups"]
        self.assertEqual(group["alike"], 2)
        self.assertIsNone(tuned["mixed"])
        self.assertEqual(tuned["choice"], tuned["uniform"])
        self.assertTrue(all("solver" not in b for b in json.loads(out.read_text())["bodies"]))

    def test_a_choice_that_cannot_be_written_at_its_source(self):
        """Two copies of one grid with two choices: its "solver" is one for all."""
        pair = {**APART, "bodies": [], "joints": [],
                "prefabs": [{"name": "three", "bodies": APART["bodies"], "joints": APART["joints"]}],
                "generators": {"grids": [{"name": "all", "prefab": "three", "count": [1, 1, 1],
                                          "spacing": [1, 1, 1]}]}}
        out = self.folder / "tuned.json"
        done = pantin("tune", self.scene(pair), "--error", 1e-3, "--within", 100, "--rungs", 4,
                      "--methods", METHODS, "--results", self.folder / "tune", "--out", out)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertRegex(done.stderr, r"^[^\n]*cannot be written: /generators/grids/0 has one solver "
                                      r"for all its copies\n$")
        self.assertFalse(out.exists())

    def test_results_are_used_again(self):
        words = [self.scene(PENDULUM), "--error", 1e-3, "--within", 20]
        first = self.tune(*words)
        kept = (self.folder / "tune/runs.jsonl").read_text()
        second = self.tune(*words)
        self.assertEqual((self.folder / "tune/runs.jsonl").read_text(), kept)
        runs = [[[r["error"] for r in m["runs"]] for m in t["methods"]] for t in (first, second)]
        self.assertEqual(runs[0], runs[1])

    def recorded(self, path, column):
        """Times, and a column of a run of a file."""
        done = pantin("run", path, "--record", self.folder / "run.csv", "--columns", column)
        self.assertEqual(done.returncode, 0, done.stderr)
        with (self.folder / "run.csv").open() as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        return [(float(row["time_s"]), float(row[column])) for row in rows]

    def test_what_only_turns_has_an_error(self):
        """A flywheel: theta = v (t - I / g (1 - exp(-g t / I))), at its rim as a part of its size."""
        out, turning = self.folder / "tuned.json", 0.02 / 0.1  # s: I / g, about the axle
        wheel = {**FLYWHEEL, "bodies": [{**FLYWHEEL["bodies"][0], "inertia": [0.02, 0.02, 0.02]}]}
        for asked in (1e-2, 1e-4):
            tuned = self.tune(self.scene(wheel), "--error", asked, "--within", 30, "--out", out,
                              "--methods", "lagrangian/implicit,lagrangian/rk4,planar")
            size = tuned["reference"]["size_m"]
            self.assertAlmostEqual(size, 2 * math.hypot(0.2, 0.025), delta=1e-3)
            for t, angle in self.recorded(out, "axle.angle"):
                exact = 20 * (t - turning * (1 - math.exp(-t / turning)))
                self.assertLessEqual(0.2 * abs(abs(angle) - exact), 1.01 * asked * size)
        # The same in a chart; its errors fall by the order of the integrator.
        runs = self.chart(self.scene(wheel), "--methods", "lagrangian/implicit", "--coarsest", 0.02,
                          "--rungs", 3, "--repeat", 1, "--time", 10)["runs"]
        errors = [run["position_m"] for run in runs]
        self.assertGreater(errors[0], 1e-5)
        self.assertAlmostEqual(math.log2(errors[0] / errors[2]), 4, delta=0.3)

    def test_a_free_brick_has_its_rotations_compared(self):
        """About its middle axis it turns over, which methods that keep only centres do not show."""
        brick = {"version": 1, "duration": 4, "gravity": [0, 0, 0],
                 "bodies": [{"name": "brick", "shape": {"type": "box", "size": [0.1, 0.2, 0.3]}, "mass": 1,
                             "inertia": [0.01, 0.02, 0.03], "position": [0, 1, 0],
                             "angular_velocity": [0.01, 6, 0.01], "drag": 0}]}
        tuned = self.tune(self.scene(brick), "--error", 1e-3, "--within", 30, "--methods",
                          "sweep,lagrangian/rk4", "--rungs", 4)
        self.assertEqual(tuned["choice"]["method"], "lagrangian/rk4")
        (sweep,) = [m for m in tuned["methods"] if m["method"] == "sweep"]
        self.assertGreater(min(run["error"] for run in sweep["runs"]), 0.5)

    def test_errors_are_not_seen_at_long_steps_only(self):
        """15 turns a second are still at times of two or of four periods, whatever a run does."""
        out, asked = self.folder / "tuned.json", 1e-2
        for coarsest in (1 / 30, 1 / 15):
            self.tune(self.scene(OSCILLATOR), "--error", asked, "--within", 30, "--out", out,
                      "--coarsest", coarsest, "--rungs", 8, "--methods", "lagrangian/rattle,planar")
            for t, x in self.recorded(out, "ball.x"):
                self.assertLessEqual(abs(x - 1 - 0.5 * math.cos(RATE * t)), 1.01 * asked)
        # A crank that turns once in a step of 1/15 s seems to stand.
        crank = {"version": 1, "duration": 2, "bodies": [{**ROD, "position": [0.1, 0, 0]}],
                 "joints": [{**HINGE, "drive": {"motion": {"speed_deg": 5400}}}]}
        tuned = self.tune(self.scene(crank), "--error", 1e-2, "--within", 30, "--coarsest", 1 / 15,
                          "--methods", "lagrangian/radau,planar")
        self.assertLess(tuned["choice"]["step_s"], 1 / 30)
        for method in tuned["methods"]:
            for run in method["runs"]:
                if run["status"] == "ok" and run["step_s"] > 1 / 20:
                    self.assertGreater(run["error"], 0.3)

    def test_what_follows_an_event_is_compared(self):
        out, asked = self.folder / "tuned.json", 1e-2
        tuned = self.tune(self.scene(STRUCK), "--error", asked, "--within", 30, "--out", out)
        self.assertAlmostEqual(tuned["reference"]["compared_s"], 1, delta=1e-9)
        for t, x in self.recorded(out, "ball.x"):
            self.assertLessEqual(abs(x - max(0, t - 0.5)), 1.1 * asked * tuned["reference"]["size_m"])

    def test_an_event_that_cannot_be_compared_is_not_vouched_for(self):
        """Three links whirl for half a minute, which nothing repeats, and are struck then."""
        rods = [{**ROD, "name": f"rod {i}", "position": [i + 0.5, 0, 0]} for i in range(3)]
        joints = [{**HINGE, "name": f"hinge {i}", "a": f"rod {i - 1}" if i else "world", "b": f"rod {i}",
                   "anchor": [i, 0, 0]} for i in range(3)]
        whirl = {"version": 1, "duration": 40, "step": 0.02, "bodies": rods, "joints": joints,
                 "events": [{"type": "impulse", "body": "rod 2", "impulse": [0, 9, 0], "at": 35}]}
        out = self.folder / "tuned.json"
        words = ["tune", self.scene(whirl), "--error", 1e-2, "--within", 30, "--out", out, "--methods",
                 "lagrangian/rk4", "--results", self.folder / "tune"]
        done = pantin(*words)
        self.assertEqual(done.returncode, 3, done.stdout)
        self.assertRegex(done.stderr, r"^[^\n]*no choice is vouched for[^\n]*event at 35 s[^\n]*"
                                      r"--duration 35[^\n]*\n$")
        self.assertFalse(out.exists())

    def test_a_plateau_ends_no_ladder(self):
        """Errors that fall only at short steps: the whip of a heavy end."""
        tuned = self.tune(self.scene(WHIP), "--error", 1e-2, "--within", 30, "--methods", "lagrangian/rk4")
        self.assertLessEqual(tuned["choice"]["error"], 1e-2)
        told = pantin("tune", self.scene(WHIP), "--error", 1e-9, "--within", 30, "--rungs", 3, "--methods",
                      "lagrangian/rk4", "--results", self.folder / "few")
        self.assertEqual(told.returncode, 3)
        self.assertIn("among the 3 settings that were tried", told.stderr)
        self.assertNotIn("shorter steps do not lessen it", told.stdout)

    def test_nothing_is_vouched_for_without_a_reference(self):
        """A motor without a gain lags by a part of the step: at such a speed no two runs agree at all."""
        motor = {**FLYWHEEL, "joints": [{**FLYWHEEL["joints"][0], "motor": {"velocity": 1e4}}]}
        out = self.folder / "tuned.json"
        told = pantin("tune", self.scene(motor), "--error", 1e-2, "--within", 20, "--methods",
                      "lagrangian/rk4,planar", "--results", self.folder / "tune", "--out", out)
        self.assertEqual(told.returncode, 3)
        self.assertIn("no reference: no method agrees with itself", told.stderr)
        self.assertNotIn("longer --within", told.stdout)
        self.assertFalse(out.exists())

    def test_bad_input(self):
        path = self.scene(PENDULUM)
        for words, told in (([path], "neither --error nor --time"),
                            ([path, "--error", 1, "--time", 1], "expected one of"),
                            ([path, "--error", 0], "--error"), ([path, "--time", "x"], "--time"),
                            ([path, "--error", 1, "--methods", "rk5"], "lagrangian/rk4"),
                            ([self.scene({"version": 2}, "bad.json"), "--error", 1], "bad.json:1:"),
                            ([self.folder / "none.json", "--error", 1], "none.json")):
            with self.subTest(told):
                done = pantin("tune", *words, "--results", self.folder / "bad")
                self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
                self.assertIn(told, done.stderr)
                self.assertEqual(done.stderr.count("\n"), 1)


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
