"""What README.md tells a newcomer to type: the first scene and the commands, as they stand."""
import csv
import json
import pathlib
import re
import sys
import unittest

import examples_test
from examples_test import ASSETS, call

README = (ASSETS.parent / "README.md").read_text(encoding="utf-8")


class FirstFiveMinutes(examples_test.Folder):
    def test_the_first_scene_is_ten_lines_and_does_what_is_said(self):
        (text,) = re.findall(r"^```json first.json\n(.*?)^```$", README, re.M | re.S)
        self.assertLessEqual(len(text.splitlines()), 10)
        (self.folder / "first.json").write_text(text)
        checked = call("pantin check first.json", self.folder)
        self.assertEqual((checked.returncode, checked.stderr), (0, ""))
        done = call("pantin run first.json --duration 2 --record first.csv --json", self.folder)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(json.loads(done.stdout)["status"], "ok")
        with (self.folder / "first.csv").open() as record:
            rows = list(csv.DictReader(record))

        def at(time):
            row = min(rows, key=lambda r: abs(float(r["time_s"]) - time))
            return [float(row[f"ball.{axis}"]) for axis in ("x", "y", "z")]

        self.assertLess(at(0.5)[1], at(0)[1] - 0.5)  # falls
        self.assertEqual(at(0.95)[2], 0)             # in its plane
        self.assertGreater(at(1.6)[2], 0.2)          # until it is pushed aside

    def test_commands_work_as_they_stand(self):
        lines = [line.replace("build/release/bin/", "")
                 for line in re.findall(r"^    (?:.* && )?(build/release/bin/pantin .*)$", README, re.M)]
        self.assertGreaterEqual(len(lines), 3)
        for line in lines:
            with self.subTest(line):
                self.run_example(line.split()[1], line, None)

    def test_commands_that_are_named_exist(self):
        told = call("pantin --help", self.folder).stdout
        for name in set(re.findall(r"`pantin (\w+)", README)):
            self.assertRegex(told, rf"(?m)^  {name} ")
        options = call("pantin run --help", self.folder).stdout + \
            call("pantin view --help", self.folder).stdout
        row = next(r for r in README.splitlines() if r.startswith("| `pantin run SCENE`"))
        for option in re.findall(r"`(--[\w-]+)", row):
            self.assertIn(option + " ", options)


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
