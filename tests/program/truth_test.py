#!/usr/bin/env python3
"""The truth table tells right from wrong: the family of CONTRIBUTING.md is green, and red where
what it calls exact is not."""
import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
TOOL = ROOT / "tools/truth"


def recipe():
    guide = (ROOT / "CONTRIBUTING.md").read_text()
    return json.loads(re.search(r"^```json tests/truth/dropped.json\n(.*?)^```$", guide, re.M | re.S)[1])


class Truth(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def run_with(self, family, *options):
        path = pathlib.Path(self.folder.name, "dropped.json")
        path.write_text(json.dumps(family))
        return subprocess.run([TOOL, "--families", self.folder.name, "--all", "--jobs", "2", *options],
                              capture_output=True, text=True, env=os.environ)

    def test_the_recipe_is_green(self):
        done = self.run_with(recipe())
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("6 cells: 6 green", done.stdout)

    def test_what_is_wrong_is_red(self):
        wrong = recipe() | {"let": {"g": "9.9"}}
        done = self.run_with(wrong)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertIn("6 red (0 known)", done.stdout)
        known = [{"solver": s, "rates": [60, 240, 960], "why": "a wrong g"} for s in wrong["solvers"]]
        self.assertEqual(self.run_with(wrong | {"known": known}).returncode, 0)
        mended = self.run_with(recipe() | {"known": known[:1]})
        self.assertEqual(mended.returncode, 1, mended.stdout)
        self.assertIn('take it out of "known"', mended.stdout)

    def test_refusals_and_findings_are_told(self):
        family = recipe()
        family["scene"]["bodies"][0]["mass"] = -1
        done = self.run_with(family)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("6 told", done.stdout)

    def test_it_draws_and_transforms(self):
        for options in (["--random", "6"], ["--alike"]):
            done = self.run_with(recipe(), "--out", self.folder.name + "/out", *options)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            cells = json.loads(pathlib.Path(self.folder.name, "out/truth.json").read_text())
            self.assertEqual({c["verdict"] for c in cells}, {"green"})
            self.assertIn("dropped", pathlib.Path(self.folder.name, "out/truth.html").read_text())

    def test_formulas_do_no_harm(self):
        for formula in ("().__class__", "open('x')", "[].append(1)", "lambda: 0", "__import__('os')"):
            done = self.run_with(recipe() | {"let": {"g": formula}})
            self.assertEqual(done.returncode, 2, formula + done.stdout)
            self.assertIn("tools/truth: ", done.stderr)


if __name__ == "__main__":
    unittest.main()
