"""pantin check, bench and doctor, seen from outside: exit codes, tables, JSON, CSV."""
import csv
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]
SCENES = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes"
CHAIN, MARIONETTE = str(SCENES / "chain.json"), str(SCENES / "marionette.json")

BENCH_KEYS = """scene status solver step_s steps bodies joints frame_ms_median frame_ms_p95
frame_ms_p99 frame_ms_max ns_per_link_step_median ns_per_link_step_p99 allocations_per_step
stages_ns_per_link bytes_per_link worst_gap_m worst_gap_rel energy_start_j energy_end_j
energy_max_j hash timed_hash late_steps step_part_p99""".split()


def pantin(*arguments):
    return subprocess.run([PANTIN, *map(str, arguments)], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=120)


class Check(unittest.TestCase):
    def test_every_shipped_scene_passes(self):
        done = pantin("check", *sorted(SCENES.glob("*.json")), "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        scenes = json.loads(done.stdout)["scenes"]
        self.assertEqual(len(scenes), len(list(SCENES.glob("*.json"))))
        for scene in scenes:
            with self.subTest(scene["scene"]):
                self.assertEqual(scene["status"], "ok")
                # Their joints are solved together.
                loops = {"bicycle": 2e-5, "net": 1e-6, "pinned_chain": 1e-8, "cut": 1e-8,
                         "rope_bridge": 2e-5, "tank": 2e-5}
                bound = loops.get(pathlib.Path(scene["scene"]).stem, 1e-12)
                self.assertLessEqual(scene["worst_gap_rel"], bound)

    def test_counts_what_is_there(self):
        scene = json.loads(pantin("check", CHAIN, "--json").stdout)["scenes"][0]
        self.assertEqual((scene["bodies"], scene["joints"], scene["articulated_islands"]), (21, 20, 1))
        self.assertEqual(scene["freedoms"], 60)  # twenty bodies that turn freely about their joints

    def test_freedoms_are_those_that_the_joints_leave(self):
        rod = {"mass": 1, "inertia": [0.1, 0.1, 0.1]}
        free = {"ball": 3, "hinge": 1, "universal": 2, "fixed": 0}
        slides = {"prismatic": 1, "cylindrical": 2}
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "joint.json"
            for solver, kinds in (("auto", free), ("lagrangian", {**free, **slides})):
                for kind, left in kinds.items():
                    with self.subTest(solver=solver, kind=kind):
                        axis = {} if kind in ("ball", "fixed") else {"axis": [0, 0, 1]}
                        joint = {"name": "j", "a": "world", "b": "rod", "kind": kind,
                                 "anchor": [0, 0, 0], **axis}
                        path.write_text(json.dumps({"version": 1, "solver": {"type": solver},
                                                    "bodies": [{"name": "rod", **rod}],
                                                    "joints": [joint]}))
                        done = pantin("check", path, "--json")
                        self.assertEqual(done.returncode, 0, done.stderr)
                        self.assertEqual(json.loads(done.stdout)["scenes"][0]["freedoms"], left)

    def test_a_drift_beyond_the_bound_fails_and_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "strict.json"
            scene = json.loads(pathlib.Path(CHAIN).read_text())
            scene["drift_bound"] = 1e-30
            path.write_text(json.dumps(scene))
            done = pantin("check", path, CHAIN)
        self.assertEqual(done.returncode, 3, done.stdout + done.stderr)
        self.assertIn("drifted", done.stderr)
        self.assertIn("joint", done.stderr)

    def test_a_motor_too_stiff_for_its_part_is_named(self):
        body = {"name": "b", "position": [0.2, 0, 0], "mass": 1e-3, "inertia": [1e-7, 1e-7, 1e-7]}
        motor = {"velocity": 3, "gain": 50}
        joint = {"name": "crank", "kind": "hinge", "a": "world", "b": "b", "anchor": [0.2, 0, 0],
                 "axis": [0, 1, 0], "motor": motor}
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "motor.json"
            for integrator, named in (("rk4", True), ("rattle", True), ("radau", False)):
                with self.subTest(integrator):
                    path.write_text(json.dumps({
                        "version": 1, "bodies": [body], "joints": [joint],
                        "solver": {"type": "lagrangian", "integrator": integrator}}))
                    done = pantin("check", path, "--json")
                    warnings = json.loads(done.stdout)["scenes"][0]["warnings"]
                    self.assertEqual(["crank" in w and "radau" in w for w in warnings],
                                     [True] if named else [])
                    told = json.loads(pantin("run", path, "--duration", 0.5, "--json").stdout)
                    self.assertEqual(told["rescued_steps"] > 0, named)

    def test_bad_input_is_the_worse_news(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "bad.json"
            path.write_text('{"version": 2}')
            done = pantin("check", path, CHAIN)
        self.assertEqual(done.returncode, 2)
        self.assertIn("bad.json:1:", done.stderr)
        self.assertIn("ok", done.stdout)  # the other scene was looked at all the same


class Bench(unittest.TestCase):
    def test_a_row_has_no_speed_without_its_drift(self):
        done = pantin("bench", CHAIN, MARIONETTE, "--duration", 1, "--repeat", 2, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads(done.stdout)
        for key in ("compiler", "kernels", "cpu", "clock"):
            self.assertIn(key, told)
        self.assertEqual(len(told["rows"]), 2)
        for row in told["rows"]:
            self.assertEqual([key for key in BENCH_KEYS if key not in row], [])
            self.assertEqual(row["allocations_per_step"], 0)
            self.assertGreater(row["ns_per_link_step_median"], 1)
            self.assertLessEqual(row["frame_ms_median"], row["frame_ms_max"])
            self.assertLess(row["worst_gap_rel"], 1e-12)
            self.assertGreater(row["bytes_per_link"], 400)
            self.assertLessEqual(row["frame_ms_median"], row["frame_ms_p95"])
            self.assertLessEqual(row["frame_ms_p95"], row["frame_ms_max"])
            stages = row["stages_ns_per_link"]
            self.assertEqual(list(stages), ["drive", "update", "adjust", "touch", "rest"])
            self.assertGreater(min(stages.values()), 0)
            self.assertAlmostEqual(row["step_part_p99"], 1e-3 * row["frame_ms_p99"] / row["step_s"])

    def test_the_solver_asked_for_is_the_one_that_runs(self):
        rows = [json.loads(pantin("bench", CHAIN, "--duration", 1, "--repeat", 1, "--solver", solver,
                                  "--json").stdout)["rows"][0] for solver in ("auto", "sweep")]
        self.assertEqual([row["solver"] for row in rows], ["auto", "sweep"])
        self.assertNotEqual(rows[0]["hash"], rows[1]["hash"])

    def test_csv_holds_the_rows(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "bench.csv"
            done = pantin("bench", CHAIN, "--duration", 0.5, "--repeat", 1, "--csv", path)
            self.assertEqual(done.returncode, 0, done.stderr)
            lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
            rows = list(csv.DictReader(lines))
            self.assertEqual(len(rows), 1)
            self.assertLess(float(rows[0]["worst_gap_rel"]), 1e-12)
            self.assertEqual(list(pathlib.Path(folder).iterdir()), [path])  # nothing half-written

    def test_a_csv_that_cannot_be_written_is_exit_4(self):
        with tempfile.NamedTemporaryFile() as file:
            done = pantin("bench", CHAIN, "--duration", 0.2, "--repeat", 1, "--csv",
                          file.name + "/below.csv")
        self.assertEqual(done.returncode, 4, done.stderr)

    def test_a_csv_can_go_into_a_device(self):
        done = pantin("bench", CHAIN, "--duration", 0.2, "--repeat", 1, "--csv", "/dev/full")
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("/dev/full", done.stderr)
        done = pantin("bench", CHAIN, "--duration", 0.2, "--repeat", 1, "--csv", "/dev/stdout")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("worst_gap_rel", done.stdout)
        for device in ("full", "null"):
            self.assertTrue(pathlib.Path("/dev", device).is_char_device())

    def test_a_history_grows_by_a_line_for_each_scene(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "history.csv"
            words = [CHAIN, "--duration", 0.2, "--repeat", 1, "--history", path]
            self.assertEqual(pantin("bench", *words).returncode, 0)
            first = path.read_text()
            told = json.loads(pantin("bench", MARIONETTE, *words, "--json").stdout)
            self.assertTrue(path.read_text().startswith(first))
            rows = list(csv.DictReader(path.read_text().splitlines()))
            self.assertEqual([pathlib.Path(row["scene"]).stem for row in rows],
                             ["chain", "marionette", "chain"])
            self.assertEqual([row["timed_hash"] for row in rows[1:]],
                             [row["timed_hash"] for row in told["rows"]])
            self.assertEqual(rows[0]["timed_hash"], rows[2]["timed_hash"])
            self.assertEqual(float(rows[2]["frame_ms_mean"]), told["rows"][1]["frame_ms_mean"])
            path.write_text("a,b\n")
            done = pantin("bench", *words)
            self.assertEqual((done.returncode, path.read_text()), (4, "a,b\n"))
            self.assertIn("history.csv:1: found other columns", done.stderr)

    def test_usage(self):
        for arguments in (["bench"], ["bench", CHAIN, "--repeat", "0"], ["bench", "missing.json"],
                          ["check"], ["doctor", "--frobnicate"]):
            with self.subTest(arguments):
                done = pantin(*arguments)
                self.assertEqual(done.returncode, 2)
                self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)


# Another build: this one, whose figures are changed by a factor or whose hashes are others.
OTHER = """#!/usr/bin/python3
import json, subprocess, sys
told = json.loads(subprocess.run(["{program}", *sys.argv[1:]], stdout=subprocess.PIPE).stdout)
for row in told["rows"]:
    row["frame_ms_mean"] *= {factor}
    row["hash"] = row["hash"][::{turn}]
print(json.dumps(told))
"""


def interval(differences):
    """By trying all signs: the means of pairs between which the shift is with 99 %."""
    n = len(differences)
    sums = sorted(sum(i + 1 for i in range(n) if signs >> i & 1) for signs in range(2 ** n))
    k = 0  # P(W < k) <= 0.005
    while sum(s < k + 1 for s in sums) <= 0.005 * 2 ** n:
        k += 1
    means = sorted((differences[i] + differences[j]) / 2 for i in range(n) for j in range(i + 1))
    return means[k - 1], means[len(means) - k]


class Against(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)

    def other(self, factor=1, turn=1):
        path = self.folder / "other"
        path.write_text(OTHER.format(program=PANTIN, factor=factor, turn=turn))
        path.chmod(0o755)
        return path

    def compared(self, other):
        done = pantin("bench", CHAIN, "--duration", 0.5, "--repeat", 8, "--against", other, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)["rows"][0]

    def test_verdicts(self):
        # Factors that no load on the machine can hide.
        for factor, turn, verdict in ((30, 1, "faster"), (1 / 30, -1, "slower")):
            row = self.compared(self.other(factor, turn))
            self.assertEqual(row["verdict"], verdict)
            self.assertEqual(row["results"], "same" if turn == 1 else "differ")
            self.assertEqual(row["words"].startswith("results differ"), turn == -1)
            least, most = interval([math.log(ratio) for ratio in row["ratios"]])
            self.assertAlmostEqual(row["change_interval"][0], math.expm1(least))
            self.assertAlmostEqual(row["change_interval"][1], math.expm1(most))
            self.assertLess(row["change_interval"][0], row["change"])
            self.assertLess(row["change"], row["change_interval"][1])

    def test_itself_has_the_same_results(self):
        row = self.compared(PANTIN)
        self.assertEqual(row["results"], "same")
        least, most = row["change_interval"]
        self.assertEqual(row["verdict"] == "no difference seen", least <= 0 <= most)

    def test_faults(self):
        for words, code, told in ((["--repeat", 7], 2, "expected 8 or more"),
                                  (["--csv", "x.csv"], 2, "--csv"),
                                  ([], 1, "no/such: No such file")):
            done = pantin("bench", CHAIN, "--against", self.folder / "no/such", *words)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(told, done.stderr)
        path = self.folder / "silent"
        path.write_text("#!/bin/sh\necho {}\n")
        path.chmod(0o755)
        done = pantin("bench", CHAIN, "--duration", 0.2, "--against", path)
        self.assertEqual(done.returncode, 1)
        self.assertIn("expected the output of bench --json", done.stderr)


class Doctor(unittest.TestCase):
    def test_tells_what_works(self):
        told = json.loads(pantin("doctor", "--json").stdout)
        self.assertIn(told["kernels_in_use"], told["kernels"])
        self.assertIn("found", told["ffmpeg"])
        if told["gl"] is not None:
            for path in ("surfaceless", "device", "osmesa"):
                way = told["gl"][path]
                self.assertTrue(way["works"] or way["refused"])  # a reason where it does not work

    def test_help_has_examples(self):
        for command in ("run", "check", "bench", "doctor", "view", "schema"):
            done = pantin(command, "--help")
            self.assertEqual(done.returncode, 0)
            self.assertIn("Example", done.stdout)


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
