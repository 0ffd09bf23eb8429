"""pantin stability, seen from outside: boundaries, each symptom, places in scene files, resumption."""
import json
import math
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PANTIN = os.environ["PANTIN"]
SCENES = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes"
ATLAS = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "atlas/scenes"
FOUND = pathlib.Path(os.environ["PANTIN_TEST_DATA"]) / "findings"
FLAP = {"version": 1, "gravity": [0, 0, 0], "ground": False,
        "bodies": [{"name": "flap", "position": [0.5, 0, 0], "mass": 1, "inertia": [0.02, 0.09, 0.09],
                    "drag": 0}],
        "joints": [{"name": "hinge", "kind": "hinge", "a": "world", "b": "flap", "anchor": [0, 0, 0],
                    "axis": [0, 0, 1], "spring": {"stiffness": 34, "rest": 0.5}}]}


def pantin(*arguments, **how):
    return subprocess.run([PANTIN, *map(str, arguments)], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=240, **how)


class Stability(unittest.TestCase):
    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.addCleanup(self.kept.cleanup)
        self.folder = pathlib.Path(self.kept.name)
        self.count = 0

    def scene(self, scene):
        path = self.folder / "scene.json"
        path.write_text(json.dumps(scene))
        return path

    def map(self, scene, *options):
        self.count += 1
        path = scene if isinstance(scene, pathlib.Path) else self.scene(scene)
        done = pantin("stability", path, "--out", self.folder / f"out{self.count}", "--json", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def symptom(self, scene, step, *options):
        told = self.map(scene, "--over", f"step={step}", "--grid", 1, "--halvings", 0, *options)
        (one,) = told["maps"]
        (word,) = one["shares"]
        return word

    def test_the_boundary_of_rk4_is_where_theory_has_it(self):
        # An oscillation of frequency omega loses (omega h)^6 / 72 of its energy in each step of rk4,
        # and a twentieth of it in the time t for (omega h)^5 = 72 ln(1 / 0.95) / (omega t). The
        # moment of inertia about the hinge is 0.34 kg m^2.
        for stiffness, time in ((34, 3), (34, 10), (3400, 1)):
            omega = math.sqrt(stiffness / 0.34)
            expected = (72 * math.log(1 / 0.95) / (omega * time)) ** 0.2 / omega
            spring = {"spring": {"stiffness": stiffness, "rest": 0.5}}
            told = self.map(FLAP | {"joints": [FLAP["joints"][0] | spring]}, "--over", "step=1e-3..1",
                            "--methods", "lagrangian/rk4", "--duration", time, "--grid", 4,
                            "--halvings", 5)
            first = told["maps"][0]["boundaries"][0]
            self.assertEqual((first["before"], first["after"]), ("ok", "freezes"))
            self.assertLess(first["to"] / first["from"], 1.06)
            self.assertLess(first["from"], 1.05 * expected)
            self.assertGreater(first["to"], 0.95 * expected)

    def test_bisection_finds_what_a_fine_grid_finds(self):
        options = ("--over", "step=1e-2..1", "--methods", "lagrangian/rk4", "--duration", 3)
        coarse = self.map(FLAP, *options, "--grid", 4, "--halvings", 3)["maps"][0]
        fine = self.map(FLAP, *options, "--grid", 32, "--halvings", 0)["maps"][0]
        self.assertGreater(len(fine["boundaries"]), 0)
        for boundary in coarse["boundaries"]:
            self.assertIn(boundary, fine["boundaries"])
        self.assertLess(len(coarse["points"]), len(fine["points"]))
        at = {tuple(p[:2]): p[2] for p in fine["points"]}
        for x, y, symptom in coarse["points"]:
            self.assertEqual(at[x, y], symptom)
        # The cells of a plane cover it once.
        plane = self.map(FLAP, *options, "--over", "/joints/hinge/spring/stiffness=1..1e4", "--grid", 3,
                         "--halvings", 2)["maps"][0]
        self.assertEqual(sum(c[2] ** 2 for c in plane["cells"]), plane["size"] ** 2)
        self.assertGreater(len({c[2] for c in plane["cells"]}), 1)
        self.assertAlmostEqual(sum(plane["shares"].values()), 1)

    def test_each_symptom_has_a_scene(self):
        pendulum = SCENES / "double_pendulum.json"
        # The flap trembles within 5 mm, reversing every other step, while another body flies on.
        far = {"name": "far", "mass": 1, "inertia": [1, 1, 1], "drag": 0, "velocity": [1, 0, 0],
               "position": [9, 0, 0]}
        stiff = FLAP | {"bodies": FLAP["bodies"] + [far],
                        "joints": [FLAP["joints"][0] | {"spring": {"stiffness": 6664, "rest": 0.01}}]}
        # The weight acts beyond both fingers: nothing balances it.
        fingers = json.loads((ATLAS / "fingers.json").read_text())
        rod = fingers["laminas"][0] | {"centre_of_mass": [0.3, 0.01]}
        tipping = fingers | {"laminas": [rod]}
        for expected, scene, step, *options in (
                ("ok", pendulum, 0.005, "--methods", "lagrangian/rk4", "--duration", 2),
                ("refused", SCENES / "bricard.json", 0.01, "--methods", "planar"),
                ("blows up", SCENES / "bricard.json", 0.01, "--methods", "sweep"),
                ("does not converge", SCENES / "four_bar.json", 0.1, "--methods", "lagrangian/rk4"),
                ("does not converge", tipping, 1 / 60),
                ("tears", FOUND / "short_strap.json", 1 / 60),
                ("gains energy", FOUND / "no_room.json", 1 / 60, "--duration", 3),
                ("sinks", FOUND / "safe_on_crate.json", 1 / 60),
                ("freezes", pendulum, 1 / 60, "--methods", "lagrangian/euler"),
                ("jitters", stiff, 0.01, "--methods", "auto", "--duration", 1),
                ("stalls", SCENES / "chain_1000.json", 1e-5, "--duration", 0.02)):
            with self.subTest(expected):
                self.assertEqual(self.symptom(scene, step, *options), expected)

    def test_places_in_the_file(self):
        # By name, by number; a key that the file leaves out; several at once; whole numbers.
        for place in ("/joints/hinge/spring/stiffness", "/joints/0/spring/stiffness",
                      "/joints/hinge/spring/damping", "/bodies/flap/drag", "/solver/sweeps",
                      "/bodies/0/inertia/1,/bodies/0/inertia/2"):
            with self.subTest(place):
                told = self.map(FLAP, "--over", f"{place}=1..2", "--grid", 1, "--halvings", 0,
                                "--duration", 0.1)
                self.assertNotIn("refused", told["maps"][0]["shares"])
        chain = self.map(SCENES / "chain10.json", "--over", "/generators/chains/0/links=2..9",
                         "--grid", 4, "--halvings", 1, "--duration", 0.1)
        self.assertTrue(chain["axes"][0]["whole"])
        self.assertEqual(chain["maps"][0]["shares"], {"ok": 1})
        # A stiffness that is written acts: the flap turns over in half a period.
        for wrong, told in (("/joints/knee/spring/stiffness=1..2", 'no "knee" in /joints'),
                            ("/bodies/3/mass=1..2", 'no "3" in /bodies'),
                            ("/bodies/0/name=1..2", "no number at /bodies/0/name"),
                            ("mass=1..2", "JSON pointer"), ("step=2..1", "FROM..TO"),
                            ("step=0..1", "FROM..TO"), ("step=", "FROM..TO"), ("=1..2", "FROM..TO")):
            with self.subTest(wrong):
                done = pantin("stability", self.scene(FLAP), "--over", wrong, "--out",
                              self.folder / "bad")
                self.assertEqual((done.returncode, done.stdout), (2, ""))
                self.assertIn(told, done.stderr)
                self.assertEqual(done.stderr.count("\n"), 1)
        # A list that the file leaves out is not made of one of its numbers.
        bare = {key: value for key, value in FLAP.items() if key != "gravity"}
        done = pantin("stability", self.scene(bare), "--over", "/gravity/1=-10..-1", "--out",
                      self.folder / "bad")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn('no "gravity" in the scene, expected that list', done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)
        done = pantin("stability", self.scene(FLAP), *["--over", "step=1..2"] * 3)
        self.assertEqual(done.returncode, 2)

    def test_an_interrupted_map_goes_on(self):
        words = ["stability", self.scene(FLAP), "--over", "step=1e-3..1", "--over",
                 "/joints/hinge/spring/stiffness=1..1e4", "--methods", "lagrangian/rk4,auto",
                 "--duration", 5, "--grid", 4]
        journal = self.folder / "cut" / "runs.jsonl"
        with subprocess.Popen([PANTIN, *map(str, words), "--out", str(journal.parent)],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as run:
            while run.poll() is None and (not journal.exists() or
                                          journal.read_text().count("\n") < 5):
                time.sleep(0.002)
            run.send_signal(signal.SIGINT)
            run.stderr.read()
        kept = journal.read_text()
        if run.returncode == 130:
            self.assertFalse((journal.parent / "map.json").exists())
        for folder in ("cut", "whole"):
            done = pantin(*words, "--out", self.folder / folder)
            self.assertEqual(done.returncode, 0, done.stderr)
        cut, whole = (json.loads((self.folder / f / "map.json").read_text()) for f in ("cut", "whole"))
        self.assertEqual(cut["maps"], whole["maps"])
        self.assertTrue(journal.read_text().startswith(kept))

    def test_the_time_bounds_it(self):
        began = time.monotonic()
        told = self.map(SCENES / "heap.json", "--over", "step=1e-3..0.1", "--time", 2, "--duration", 1)
        self.assertLess(time.monotonic() - began, 60)
        self.assertFalse(told["maps"][0]["complete"])


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
