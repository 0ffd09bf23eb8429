"""The columns of pantin run --record: which are written, and that their numbers are right."""
import ast
import csv
import io
import json
import math
import os
import pathlib
import struct
import subprocess
import tempfile
import unittest
import zipfile

PANTIN = os.environ["PANTIN"]
SCENES = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes"

# A ball of 2 kg on a massless arm of 1 m, let go from level.
PENDULUM = {
    "version": 1, "duration": 1, "step": 0.001, "solver": {"type": "lagrangian"},
    "bodies": [{"name": "bob", "position": [1, 0, 0], "mass": 2, "drag": 0,
                "inertia": [1e-9, 1e-9, 1e-9]}],
    "joints": [{"name": "pivot", "kind": "hinge", "a": "world", "b": "bob", "anchor": [0, 0, 0],
                "axis": [0, 0, 1]}]}


def pantin(*arguments, stdin=""):
    return subprocess.run([PANTIN, *map(str, arguments)], input=stdin, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, timeout=120)


def columns(text):
    header, *rows = csv.reader(io.StringIO(text))
    return {name: [float(row[i]) if row[i] else math.nan for row in rows]
            for i, name in enumerate(header)}


class Record(unittest.TestCase):
    def record(self, scene, *options):
        text = json.dumps(scene) if isinstance(scene, dict) else scene.read_text()
        done = pantin("run", "-", "--record", "-", *options, stdin=text)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_a_pendulum_is_read_as_its_closed_forms_say(self):
        read = columns(self.record(PENDULUM, "--columns", "pivot.*,bob.x,bob.y"))
        for i in range(1, len(read["time_s"])):
            angle, speed = read["pivot.angle"][i], read["pivot.angular_speed"][i]
            self.assertAlmostEqual(math.cos(angle), read["bob.x"][i], places=9)
            self.assertAlmostEqual(math.sin(angle), read["bob.y"][i], places=9)
            # Energy is kept: speed^2 / 2 = g sin(-angle), to the order of the integrator.
            self.assertAlmostEqual(speed**2 / 2, -9.81 * math.sin(angle), delta=2e-3)
            # The hinge holds weight and centripetal force: 3 m g sin(-angle), mean over the step.
            pull = math.hypot(read["pivot.reaction_fx"][i], read["pivot.reaction_fy"][i])
            middle = (angle + read["pivot.angle"][i - 1]) / 2
            wanted = -3 * math.sin(middle) * 2 * 9.81
            self.assertAlmostEqual(pull, wanted, delta=0.06)

    def test_a_stack_bears_the_weights_above(self):
        read = columns(self.record(SCENES / "stack.json", "--duration", 2, "--columns",
                                   "*.contact*"))
        self.assertNotIn("b0.x", read)
        self.assertEqual(read["b9.contacts"][-1], 1)
        self.assertEqual(read["b4.contacts"][-1], 2)
        one = read["b9.contact_fy"][-1]
        self.assertAlmostEqual(read["floor.contact_fy"][-1] / one, -10, delta=1e-5)
        self.assertAlmostEqual(read["b0.contact_fy"][-1] / one, 1, delta=1e-5)

    def test_a_cable_carries_what_hangs_from_it(self):
        scene = {"version": 1, "duration": 1,
                 "bodies": [{"name": "load", "position": [0, -1, 0], "mass": 3,
                             "inertia": [0.1, 0.1, 0.1]}],
                 "cables": [{"name": "rope", "a": "world", "b": "load", "anchor_a": [0, 0, 0],
                             "anchor_b": [0, 0, 0], "length": 1}]}
        read = columns(self.record(scene, "--columns", "*.tension"))
        self.assertEqual(list(read), ["time_s", "rope.tension"])
        self.assertAlmostEqual(read["rope.tension"][-1], 3 * 9.81, delta=1e-3)

    def test_chosen_columns_are_those_of_the_whole_record(self):
        whole = columns(self.record(PENDULUM))
        some = columns(self.record(PENDULUM, "--columns", "bob.q?,energy_j"))
        self.assertEqual(list(some), ["time_s", "bob.qx", "bob.qy", "bob.qz", "bob.qw",
                                      "energy_j"])
        for name, values in some.items():
            self.assertEqual(values, whole[name])
        rounded = self.record(PENDULUM, "--columns", "bob.x", "--digits", 3)
        cells = [row.split(",")[1] for row in rounded.splitlines()[1:]]
        self.assertEqual(cells, [f"{x:.3g}" for x in whole["bob.x"]])

    def test_arrays_for_numpy_hold_the_numbers_of_the_table(self):
        """Read by the description of the format, and by numpy where it is installed."""
        wanted = columns(self.record(SCENES / "stack.json", "--duration", 0.2, "--columns", "b1.*"))
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a.npz"
            done = pantin("run", SCENES / "stack.json", "--duration", 0.2, "--columns", "b1.*",
                          "--record", path)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual([p.name for p in path.parent.iterdir()], ["a.npz"])
            read = {}
            with zipfile.ZipFile(path) as archive:
                self.assertIsNone(archive.testzip())
                for name in archive.namelist():
                    data = archive.read(name)
                    self.assertEqual(data[:8], b"\x93NUMPY\x01\x00")
                    start = 10 + int.from_bytes(data[8:10], "little")
                    self.assertEqual((start % 64, data[start - 1:start]), (0, b"\n"))
                    head = ast.literal_eval(data[10:start].decode())
                    self.assertEqual((head["descr"], head["fortran_order"]), ("<f8", False))
                    (count,) = head["shape"]
                    self.assertTrue(name.endswith(".npy"))
                    read[name[:-4]] = list(struct.unpack(f"<{count}d", data[start:]))
            self.assertEqual(list(read), list(wanted))
            for name, values in wanted.items():
                self.assertEqual(len(read[name]), len(values))
                for x, y in zip(read[name], values):
                    self.assertTrue(x == y or math.isnan(x) and math.isnan(y), name)
            try:
                import numpy
            except ImportError:
                return
            with numpy.load(path) as loaded:
                self.assertEqual(list(loaded), list(wanted))
                self.assertEqual(loaded["b1.y"].tolist(), wanted["b1.y"])

    def test_what_cannot_be_recorded_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "r.csv"
            for options, told in (
                    (("--record", path, "--columns", "pivot.angel"), 'nearest is "pivot.angle"'),
                    (("--columns", "*"), "found no record to write"),
                    (("--digits", 3), "found no record to write"),
                    (("--record", "-", "--json"), "expected one of them"),
                    (("--record", path, "--digits", 18), "from 1 to 17")):
                with self.subTest(options=options):
                    done = pantin("run", "-", *options, stdin=json.dumps(PENDULUM))
                    self.assertEqual(done.returncode, 2)
                    self.assertIn(told, done.stderr)
                    self.assertEqual(len(done.stderr.splitlines()), 1)
                    self.assertFalse(path.exists())

    def test_values_that_are_set_are_those_of_the_file(self):
        heavy = json.loads(json.dumps(PENDULUM))
        heavy["bodies"][0]["mass"], heavy["bodies"][0]["position"] = 4, [0, 1, 0.5]
        heavy["solver"]["integrator"] = "rattle"
        heavy["gravity"] = [1, -9, 0]
        sets = ("--set", "bodies/bob/mass=4", "--set", "/bodies/0/position=[0, 1, 0.5]",
                "--set", "solver/integrator=rattle", "--set", "gravity=[1, -9, 0]")
        self.assertEqual(self.record(PENDULUM, *sets), self.record(heavy))
        self.assertNotEqual(self.record(PENDULUM), self.record(heavy))

    def test_values_that_cannot_be_set_are_refused_in_one_line(self):
        text = json.dumps(PENDULUM)
        for setting, told in (("bodies/bob/mass", "expected POINTER=VALUE"),
                              ("bodies/bop/mass=2", 'found no "bop" in /bodies'),
                              ("bodies/bob/mass=heavy", "mass"), ("bodies/bob/mas=2", '"mas"'),
                              ("bodies/bob/mass=-1", "mass")):
            done = pantin("run", "-", "--set", setting, stdin=text)
            self.assertEqual(done.returncode, 2, setting)
            self.assertIn(told, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)

    def test_a_seed_is_that_of_the_gusts_or_an_error(self):
        still = pantin("run", SCENES / "mobile.json", "--duration", 1, "--json")
        hashes = {json.loads(pantin("run", SCENES / "mobile.json", "--duration", 1, "--json",
                                    "--seed", seed).stdout)["hash"] for seed in (1, 2, 2, 3)}
        self.assertEqual(len(hashes), 3)
        seeds = [e.get("seed", 1) for e in json.loads((SCENES / "mobile.json").read_text())["events"]
                 if "gusts" in e]
        own = pantin("run", SCENES / "mobile.json", "--duration", 1, "--json", "--seed", seeds[0])
        self.assertEqual(json.loads(own.stdout)["hash"], json.loads(still.stdout)["hash"])
        refused = pantin("run", SCENES / "pendulum.json", "--seed", 3)
        self.assertEqual((refused.returncode, len(refused.stderr.splitlines())), (2, 1))
        self.assertIn("found nothing random in the scene", refused.stderr)


if __name__ == "__main__":
    unittest.main()
