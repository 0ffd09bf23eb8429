"""Findings of pantin run, seen from outside: lines, JSON, --strict; shipped scenes have none."""
import json
import os
import pathlib
import re
import subprocess
import sys
import unittest

PANTIN = os.environ["PANTIN"]
SCENES = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes"
NET = SCENES / "net.json"
ROOT = pathlib.Path(__file__).parents[2]
README = ROOT / "engine/runtime/README.md"


def run(*arguments):
    return subprocess.run([PANTIN, "run", *map(str, arguments)], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300)


class Findings(unittest.TestCase):
    def test_shipped_scenes_have_none(self):
        for scene in sorted(SCENES.glob("*.json")):
            with self.subTest(scene.stem):
                done = run(scene, "--duration", 3, "--json", "--strict")
                told = json.loads(done.stdout)
                self.assertEqual((told["status"], told["findings"]), ("ok", []))
                self.assertEqual(done.returncode, 0, done.stderr)

    def test_open_joints_are_told(self):
        arguments = (NET, "--solver", "sweep", "--duration", 0.5)
        told = json.loads(run(*arguments, "--json").stdout)
        self.assertEqual(told["status"], "doubtful")
        gaps = [f for f in told["findings"] if f["kind"] == "joint_open"]
        self.assertGreater(len(gaps), 10)
        worst = max(gaps, key=lambda f: f["amount"])
        self.assertAlmostEqual(worst["amount"], told["worst_gap_m"], delta=1e-9)
        self.assertEqual(worst["unit"], "m")
        self.assertGreater(worst["steps"], 0)
        done = run(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = [line for line in done.stdout.splitlines() if line.startswith("  found ")]
        line = next(line for line in lines if "joint_open" in line)
        self.assertIn(worst["where"], line)
        self.assertIn(f"{worst['amount']:.3g} m", line)

    def test_every_kind_has_an_example_that_has_it(self):
        rows = re.findall(r"^\| `(\w+)` \|.*\| ([^|]*) \|$", README.read_text(), re.MULTILINE)
        self.assertGreater(len(rows), 15)
        for kind, example in rows:
            command = re.search(r"`pantin run (\S+)([^`]*)`", example)
            if not command:
                self.assertIn("none is known", example)
                continue
            with self.subTest(kind):
                told = json.loads(run(ROOT / command[1], *command[2].split(), "--json").stdout)
                self.assertIn(kind, {f["kind"] for f in told["findings"]})
                self.assertNotEqual(told["status"], "ok")

    def test_a_top_that_spins_faster_than_contacts_follow_is_told(self):
        scene = ROOT / "tests/data/findings/top_on_floor.json"
        for step, told in ((1 / 60, True), (1 / 100, True), (1 / 120, True), (1 / 240, False)):
            arguments = (scene, "--solver", "lagrangian", "--step", step, "--json")
            findings = json.loads(run(*arguments).stdout)["findings"]
            with self.subTest(step):
                self.assertEqual("turned_too_far" in {f["kind"] for f in findings}, told)

    def test_uncertain_places_of_contact_are_told(self):
        scene = ROOT / "tests/data/findings/tight_bowl.json"
        told = json.loads(run(scene, "--json").stdout)
        found = [f for f in told["findings"] if f["kind"] == "place_uncertain"]
        self.assertEqual([f["where"] for f in found], ["touch"])
        self.assertAlmostEqual(found[0]["amount"], found[0]["steps"] / 240, delta=1e-9)
        lines = [line for line in run(scene).stdout.splitlines() if "place_uncertain" in line]
        self.assertEqual(len(lines), 1)
        self.assertIn("touch", lines[0])
        wide = ("--set", "/bodies/1/shape/radius=0.2", "--set", "/bodies/1/position/1=-0.1")
        told = json.loads(run(scene, *wide, "--json").stdout)
        self.assertEqual((told["status"], told["findings"]), ("ok", []))

    def test_strict_makes_findings_exit_three(self):
        arguments = (NET, "--solver", "sweep", "--duration", 0.2)
        self.assertEqual(run(*arguments).returncode, 0)
        self.assertEqual(run(*arguments, "--strict").returncode, 3)


def main():
    tests = unittest.defaultTestLoader.loadTestsFromTestCase(Findings)
    result = unittest.TextTestRunner(stream=sys.stdout).run(tests)
    failed = len({str(test).split(" (")[0] for test, _ in result.failures + result.errors})
    print(f"{result.testsRun - len(result.skipped) - failed} passed, {failed} failed")
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
