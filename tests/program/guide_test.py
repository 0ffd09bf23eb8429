"""The scenes and the commands of assets/GUIDE.md and the named scenes of assets/README.md, as they stand."""
import re
import sys
import unittest

import examples_test
from examples_test import ASSETS, call

PAGES = {name: (ASSETS / name).read_text(encoding="utf-8") for name in ("GUIDE.md", "README.md")}


class Guide(examples_test.Folder):
    def test_scenes_load_and_run(self):
        count = 0
        for page, text in PAGES.items():
            for name, scene in re.findall(r"^```json (\S+\.json)\n(.*?)^```$", text, re.M | re.S):
                with self.subTest(page=page, scene=name):
                    (self.folder / name).write_text(scene)
                    done = call(f"pantin run {name} --json --strict", self.folder)
                    self.assertEqual((done.returncode, done.stderr), (0, ""))
                    count += 1
        self.assertGreaterEqual(count, 3)

    def test_commands_work(self):
        lines = re.findall(r"^    (pantin .*)$", PAGES["GUIDE.md"], re.M)
        self.assertGreaterEqual(len(lines), 4)
        for line in lines:
            with self.subTest(line):
                done = call(line, self.folder)
                self.assertEqual(done.returncode, 0, done.stderr)

    def test_lines_that_are_explained_are_printed(self):
        told = call("pantin check assets/scenes/four_bar.json", self.folder).stdout
        for words in ("freedoms", "articulated and 1 Lagrangian islands", "start gap", "worst gap", "kg"):
            self.assertIn(words, told)
        told = call("pantin run assets/scenes/four_bar.json --duration 1", self.folder).stdout
        for words in ("solver ", "worst gap ", "energy ", "time "):
            self.assertIn(f"\n  {words}", told)


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
