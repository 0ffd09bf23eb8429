"""pantin chart, seen from outside: orders, references, fronts, resumption, what is written."""
import csv
import json
import math
import os
import pathlib
import runpy
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PANTIN = os.environ["PANTIN"]
DRAW = runpy.run_path(str(pathlib.Path(__file__).parents[2] / "tools/pantin/draw.py"))
SCENES = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes"
ROD = {"name": "rod", "position": [0.5, 0, 0], "mass": 1, "inertia": [0.02, 0.1, 0.1], "drag": 0}
PENDULUM = {"version": 1, "step": 0.02, "duration": 2, "bodies": [ROD],
            "joints": [{"name": "pivot", "kind": "hinge", "a": "world", "b": "rod",
                        "anchor": [0, 0, 0], "axis": [0, 0, 1]}]}
# Three links that whirl: chaotic within seconds.
TRIPLE = {"version": 1, "step": 0.02, "duration": 40,
          "bodies": [{**ROD, "name": f"rod {i}", "position": [i + 0.5, 0, 0]} for i in range(3)],
          "joints": [{"kind": "hinge", "a": "world" if i == 0 else f"rod {i - 1}", "b": f"rod {i}",
                      "anchor": [i, 0, 0], "axis": [0, 0, 1]} for i in range(3)]}


def pantin(*arguments, **how):
    return subprocess.run([PANTIN, *map(str, arguments)], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=240, **how)


class Charts(unittest.TestCase):
    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.addCleanup(self.kept.cleanup)
        self.folder = pathlib.Path(self.kept.name)

    def scene(self, scene, name="scene"):
        path = self.folder / f"{name}.json"
        path.write_text(json.dumps(scene))
        return path

    def chart(self, scene, *options, out="out"):
        path = scene if isinstance(scene, pathlib.Path) else self.scene(scene)
        done = pantin("chart", path, "--out", self.folder / out, "--json", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)["scenes"][0]

    def errors(self, scene, method):
        return [run["position_m"] for run in scene["runs"] if run["method"] == method]


class Chart(Charts):
    def test_errors_fall_by_the_order_of_each_integrator(self):
        scene = self.chart(PENDULUM, "--coarsest", 0.02, "--rungs", 4, "--repeat", 1, "--time", 60)
        self.assertTrue(scene["reference"]["whole"])
        self.assertLess(scene["reference"]["position_m"], 1e-9)
        for method, order in (("lagrangian/euler", 1), ("lagrangian/rattle", 2), ("auto", 2),
                              ("lagrangian/rk4", 4)):
            errors = self.errors(scene, method)
            self.assertEqual(len(errors), 4)
            slope = math.log2(errors[0] / errors[-1]) / 3
            self.assertAlmostEqual(slope, order, delta=0.25, msg=method)
        # Another method comes as near.
        self.assertLess(scene["reference"]["confirmed_m"], 1e-6)

    def test_errors_fall_with_the_tolerance(self):
        scene = self.chart(PENDULUM, "--coarsest", 0.5, "--rungs", 6, "--repeat", 1, "--time", 60,
                           "--methods", "lagrangian/rk4/tolerance,lagrangian/radau/tolerance")
        for method in ("lagrangian/rk4/tolerance", "lagrangian/radau/tolerance"):
            runs = [run for run in scene["runs"] if run["method"] == method]
            self.assertEqual([run["tolerance"] for run in runs], [10.0 ** -k for k in range(3, 9)])
            self.assertLess(runs[-1]["position_m"], 1e-3 * runs[0]["position_m"])
            self.assertGreater(runs[-1]["substeps"], runs[0]["substeps"])

    def test_nothing_is_dropped_and_the_front_is_one(self):
        out = self.folder / "out"
        scene = self.chart(SCENES / "bricard.json", "--rungs", 2, "--repeat", 2, "--duration", 2,
                           "--time", 60)
        methods = {run["method"] for run in scene["runs"]}
        refused = {one["method"]: one["reason"] for one in scene["refused"]}
        self.assertIn("planar", refused)
        self.assertIn("xy plane", refused["planar"])
        self.assertEqual(len(scene["runs"]), 2 * len(methods))
        self.assertEqual(len(methods) + len(refused), 12)
        self.assertTrue(any(run["status"] == "energy_grew" for run in scene["runs"]))
        good = [run for run in scene["runs"] if run["status"] == "ok"]
        floor = scene["reference"]["position_m"]
        for run in good:
            self.assertGreater(run["steps"], 0)
            self.assertLessEqual(run["cost_low_ns"], run["cost_ns"])
            self.assertLessEqual(run["cost_ns"], run["cost_high_ns"])
            better = [o for o in good if o["cost_ns"] < run["cost_ns"] and
                      max(floor, o["position_m"]) <= max(floor, run["position_m"])]
            self.assertEqual(run["front"], not better, run)
        for run in good:
            if run["method"] == "lagrangian/rk4":
                self.assertGreaterEqual(run["factorisations"], 4 * run["steps"])
        with (out / "chart.csv").open() as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        self.assertEqual(len(rows), len(scene["runs"]) + len(refused))
        first = next(r for r in rows if r["status"] == "ok")
        self.assertIn(float(first["position_m"]), [run["position_m"] for run in good])

    def test_against_a_closed_form(self):
        fall = {"version": 1, "step": 0.01, "duration": 1,
                "bodies": [{"name": "ball", "mass": 1, "velocity": [1, 2, 0], "drag": 0,
                            "shape": {"type": "sphere", "radius": 0.1}, "position": [0, 5, 0]}]}
        path = self.folder / "exact.csv"
        for wrong in (0, 0.25):
            rows = [f"{t},{t + wrong * t},{5 + 2 * t - 4.905 * t * t},0,0,0,0,1"
                    for t in (k / 20 for k in range(21))]
            path.write_text("time_s,ball.x,ball.y,ball.z,ball.qx,ball.qy,ball.qz,ball.qw\n" +
                            "\n".join(rows) + "\n")
            scene = self.chart(fall, "--against", path, "--rungs", 2, "--repeat", 1,
                               "--methods", "lagrangian/rk4,auto", "--time", 20)
            for error in self.errors(scene, "lagrangian/rk4"):
                self.assertAlmostEqual(error, wrong, delta=1e-9)
            self.assertEqual(scene["reference"]["method"], str(path))
        path.write_text("time_s,ball.x,ball.y,ball.z\n0,0,4,0\n1,1,2,0\n")
        done = pantin("chart", self.scene(fall), "--against", path, "--out", self.folder / "out")
        self.assertEqual(done.returncode, 2)
        self.assertIn("found ball at (0, 4, 0) at time 0, expected (0, 5, 0)", done.stderr)
        path.write_text("time_s,other.x\n0,0\n1,0\n")
        done = pantin("chart", self.scene(fall), "--against", path, "--out", self.folder / "out")
        self.assertEqual(done.returncode, 2)
        self.assertIn("exact.csv: found no column of a body", done.stderr)

    def test_the_cost_of_few_steps_is_that_of_many(self):
        """For a second of a motion of which each step is as much work."""
        costs = []
        for duration in (0.5, 1, 10):
            (run,) = self.chart({**PENDULUM, "duration": duration}, "--coarsest", 0.5, "--rungs", 1,
                                "--repeat", 3, "--time", 10, "--methods", "lagrangian/rk4",
                                out=f"cost {duration}")["runs"]
            self.assertEqual(run["steps"], 2 * duration)
            costs.append(run["cost_low_ns"])
        for cost in costs[:2]:
            self.assertGreater(cost, 0.4 * costs[2])
            self.assertLess(cost, 2.5 * costs[2])

    def test_a_file_has_an_error_of_its_own_that_is_unknown(self):
        pendulum = self.scene(PENDULUM)
        done = pantin("run", pendulum, "--record", self.folder / "own.csv")
        self.assertEqual(done.returncode, 0, done.stderr)
        words = ["--against", self.folder / "own.csv", "--rungs", 1, "--repeat", 1, "--time", 10,
                 "--methods", "lagrangian/rk4"]
        self.assertIsNone(self.chart(pendulum, *words)["reference"]["position_m"])
        told = pantin("chart", pendulum, "--out", self.folder / "out", *words)
        self.assertIn("own error unknown", told.stdout)

    def test_a_file_without_rotations_has_positions_compared(self):
        """The errors of positions alone, and none of orientation instead of 0."""
        pendulum, words = self.scene(PENDULUM), ["--rungs", 1, "--repeat", 1, "--time", 10, "--methods", "lagrangian/euler"]
        runs = []
        for columns in ("rod.*", "rod.x,rod.y,rod.z"):
            path = self.folder / "own.csv"
            done = pantin("run", pendulum, "--step", 0.001, "--record", path, "--columns", columns)
            self.assertEqual(done.returncode, 0, done.stderr)
            runs += self.chart(pendulum, "--against", path, *words)["runs"]
        turned, moved = runs
        # The rod is 0.5 m from its hinge, and as a point mass at its radius of gyration.
        self.assertAlmostEqual(turned["position_m"] / turned["origin_m"], 1 + 0.1 ** 0.5 / 0.5, delta=0.1)
        self.assertEqual(moved["position_m"], moved["origin_m"])
        self.assertAlmostEqual(moved["position_m"], turned["origin_m"], delta=1e-12)
        self.assertGreater(turned["orientation_rad"], 1e-3)
        self.assertIsNone(moved["orientation_rad"])

    def test_chaos_is_told(self):
        scene = self.chart(TRIPLE, "--coarsest", 0.02, "--rungs", 2, "--repeat", 1, "--time", 20,
                           "--methods", "lagrangian/radau,lagrangian/euler")
        reference = scene["reference"]
        self.assertFalse(reference["whole"])
        self.assertGreater(reference["horizon_s"], 1)
        self.assertLess(reference["horizon_s"], 39)
        self.assertLess(reference["position_m"], 1e-5 * scene["size_m"])
        self.assertAlmostEqual(reference["compared_s"], reference["horizon_s"] / 2, delta=0.21)
        follows = {}
        for run in scene["runs"]:
            follows[run["method"]] = max(follows.get(run["method"], 0), run["follows_s"])
            self.assertLessEqual(run["follows_s"], reference["horizon_s"])
        self.assertLess(follows["lagrangian/euler"], 0.8 * follows["lagrangian/radau"])

    def test_an_interrupted_chart_goes_on(self):
        path = self.scene({**PENDULUM, "duration": 10})
        words = ["chart", path, "--coarsest", 0.02, "--rungs", 5, "--repeat", 1, "--time", 100,
                 "--methods", "auto,lagrangian/rk4,lagrangian/euler"]
        journal = self.folder / "cut" / "runs.jsonl"
        with subprocess.Popen([PANTIN, *map(str, words), "--out", str(journal.parent)],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as run:
            while run.poll() is None and (not journal.exists() or
                                          journal.read_text().count("\n") < 4):
                time.sleep(0.005)
            run.send_signal(signal.SIGINT)
            told = run.stderr.read()
        kept = journal.read_text()
        if run.returncode == 130:
            self.assertIn("goes on from here", told)
            self.assertFalse((journal.parent / "chart.json").exists())
        journal.write_text(kept[:-20])  # the last line was cut off
        done = pantin(*words, "--out", journal.parent)
        self.assertEqual(done.returncode, 0, done.stderr)
        whole = pantin(*words, "--out", self.folder / "whole")
        self.assertEqual(whole.returncode, 0, whole.stderr)
        a, b = (json.loads((self.folder / f / "chart.json").read_text())["scenes"][0]["runs"]
                for f in ("cut", "whole"))
        self.assertEqual([r["position_m"] for r in a], [r["position_m"] for r in b])
        self.assertEqual(len(a), 15)
        # What was measured before the cut was not measured again.
        self.assertTrue(journal.read_text().startswith(kept[:-20].rsplit("\n", 1)[0]))

    def test_the_time_bounds_it(self):
        began = time.monotonic()
        scene = self.chart(SCENES / "heap.json", "--time", 3)
        self.assertLess(time.monotonic() - began, 40)
        self.assertTrue(any(run["status"] == "not_run" for run in scene["runs"]))
        # Too little time for a reference is not a disagreement of methods.
        done = pantin("chart", SCENES / "heap.json", "--time", 0.1, "--out", self.folder / "short")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("the time was too short for two runs", done.stdout)
        short = json.loads((self.folder / "short/chart.json").read_text())["scenes"][0]
        self.assertIn("the time was too short for two runs", DRAW["words_of"](short)[0])

    def test_pictures(self):
        words = ["chart", self.scene(PENDULUM), "--out", self.folder / "p", "--rungs", 2,
                 "--repeat", 1, "--time", 20, "--methods", "auto,lagrangian/rk4"]
        done = pantin(*words)
        self.assertEqual(done.returncode, 0, done.stderr)
        names = {"scene.svg", "scene.png", "index.html"}
        drawing = "import matplotlib"
        if any(subprocess.run([python, "-c", drawing], stderr=subprocess.DEVNULL).returncode == 0
               for python in ("python3", "/usr/bin/python3")):
            self.assertEqual(done.stderr, "")
            self.assertLessEqual(names, {p.name for p in (self.folder / "p").iterdir()})
            self.assertIn("auto", (self.folder / "p/index.html").read_text())
        # Without python3 one line says so, and all numbers are there.
        (self.folder / "empty").mkdir()
        words[3] = self.folder / "q"
        done = pantin(*words, env={**os.environ, "PATH": str(self.folder / "empty")})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, r"^pantin: no pictures: .*\n$")
        self.assertNotIn("index.html", done.stdout)
        left = {p.name for p in (self.folder / "q").iterdir()}
        self.assertEqual(left, {"chart.json", "chart.csv", "runs.jsonl"})

    def test_bad_input(self):
        for words, told in (
                (["chart", self.folder / "none.json"], "none.json"),
                (["chart", self.scene({"version": 2}, "bad")], "bad.json:1:"),
                (["chart", self.scene(PENDULUM), "--methods", "lagrangian/rk5"], "lagrangian/rk4"),
                (["chart", self.scene(PENDULUM), self.scene(PENDULUM, "b"), "--against", "a.csv"],
                 "expected the one")):
            done = pantin(*words, "--out", self.folder / "bad")
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(told, done.stderr)
        (self.folder / "file").write_text("")
        done = pantin("chart", self.scene(PENDULUM), "--out", self.folder / "file/below")
        self.assertEqual(done.returncode, 4)


class Exact(Charts):
    """Exact motions beside shipped scenes."""

    WORDS = ["--rungs", 3, "--repeat", 1, "--time", 30, "--methods", "lagrangian/rk4,lagrangian/radau/tolerance"]

    def copied(self, name, change=lambda text: text):
        (self.folder / "exact").mkdir(exist_ok=True)
        (self.folder / f"exact/{name}.csv").write_text((SCENES / f"exact/{name}.csv").read_text())
        path = self.folder / f"{name}.json"
        path.write_text(change((SCENES / f"{name}.json").read_text()))
        return path

    def measured(self, path, *words):
        done = pantin("chart", path, "--out", self.folder / "out", "--json", "--afresh", *self.WORDS, *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)["scenes"][0], done.stderr

    def test_a_scene_with_an_exact_motion_is_measured_against_it(self):
        scene, _ = self.measured(self.copied("pendulum"))
        self.assertTrue(scene["reference"]["method"].endswith("exact/pendulum.csv"))
        self.assertLessEqual(scene["reference"]["position_m"], 1e-12)
        coarse, *_, fine = sorted((r for r in scene["runs"] if r["method"] == "lagrangian/rk4"),
                                  key=lambda r: -r["step_s"])
        self.assertAlmostEqual(math.log2(coarse["position_m"] / fine["position_m"]), 8, delta=0.5)
        # The first second of it.
        short, _ = self.measured(self.copied("pendulum"), "--duration", 1)
        self.assertAlmostEqual(short["duration_s"], 1)
        self.assertTrue(short["reference"]["method"].endswith("exact/pendulum.csv"))

    def test_a_changed_scene_is_not(self):
        scene, told = self.measured(self.copied("pendulum", lambda t: t.replace('"mass": 1,', '"mass": 2,')))
        self.assertIn("exact/pendulum.csv: is the exact motion of another text of", told)
        self.assertEqual(scene["reference"]["method"], "lagrangian/radau")
        longer, _ = self.measured(self.copied("pendulum"), "--duration", 5)  # than the file
        self.assertEqual(longer["reference"]["method"], "lagrangian/radau")

    def test_the_files_are_those_of_the_scenes(self):
        done = subprocess.run([sys.executable, "-B", pathlib.Path(__file__).parents[2] / "tools/exact",
                               "--check"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))


class Peers(Charts):
    """Other engines on a chart, from a file."""

    HEAD = "scene,engine,method,step_s,error_m,bodies,cpu_ms_per_s,status\n"

    def peers(self, *rows, head=HEAD):
        path = self.folder / "peers.csv"
        path.write_text(head + "".join(row + "\n" for row in rows))
        return path

    def test_a_peer_that_is_ahead_is_ahead(self):
        peers = self.peers("scene,Fast,Exact,0.01,0,1,1e-9,ok", "scene,Slow,Rough,0.01,9,1,1e9,ok",
                           "scene,Slow,Lost,0.01,,1,,diverged", "other,Fast,Exact,0.01,0,1,1e-9,ok",
                           "scene,pantin,auto,0.01,0,1,1e-12,ok")  # the chart has its own
        words = ["--rungs", 2, "--repeat", 1, "--time", 20, "--methods", "auto,lagrangian/rk4"]
        scene = self.chart(PENDULUM, *words, "--peers", peers)
        fast, slow, lost = scene["peers"]
        self.assertEqual((fast["method"], fast["front"]), ("Fast Exact", True))
        self.assertAlmostEqual(fast["cost_ns"], 1e-3)  # of one body
        self.assertFalse(slow["front"] or lost["front"])
        self.assertFalse(any(run["front"] for run in scene["runs"]))
        lines = (self.folder / "out/chart.csv").read_text().splitlines()
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
        self.assertEqual([r["method"] for r in rows if r["status"] == "diverged"], ["Slow Lost"])
        told = pantin("chart", self.folder / "scene.json", "--out", self.folder / "out", *words,
                      "--peers", peers)
        self.assertIn("Fast Exact", told.stdout)
        self.assertNotIn("Slow Rough", told.stdout)
        # Without the fast one, ours are the best.
        scene = self.chart(PENDULUM, *words, "--peers",
                           self.peers("scene,Slow,Rough,0.01,9,1,1e9,ok"))
        self.assertTrue(any(run["front"] for run in scene["runs"]))

    def test_faulty_files(self):
        scene = self.scene(PENDULUM)
        for rows, head, told in (([], "engine,method\n", "peers.csv:1: found no column scene"),
                                 (["scene,A,B,x,0,1,1,ok"], self.HEAD, "peers.csv:2: found no number"),
                                 (["scene,A,B,0.1,0,0,1,ok"], self.HEAD, "peers.csv:2:")):
            with self.subTest(told):
                done = pantin("chart", scene, "--out", self.folder / "bad", "--rungs", 1, "--time", 5,
                              "--methods", "auto", "--peers", self.peers(*rows, head=head))
                self.assertEqual(done.returncode, 2)
                self.assertIn(told, done.stderr)


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
