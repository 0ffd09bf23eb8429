"""pantin new: scenes to begin with, and what it never does to a file that is there."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]


def pantin(*arguments):
    return subprocess.run([PANTIN, *map(str, arguments)], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=120)


class New(unittest.TestCase):
    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)

    def tearDown(self):
        self.kept.cleanup()

    def test_every_template_is_checked_clean_and_runs(self):
        for name in ("pendulum", "chain", "linkage"):
            with self.subTest(name):
                path = self.folder / f"{name}.json"
                self.assertEqual(pantin("new", path, "--from", name).returncode, 0)
                checked = pantin("check", path)
                self.assertEqual((checked.returncode, checked.stderr), (0, ""))
                run = pantin("run", path, "--duration", "3", "--json")
                self.assertEqual((run.returncode, run.stderr), (0, ""))
                self.assertEqual(json.loads(run.stdout)["status"], "ok")
                self.assertTrue((self.folder / json.loads(path.read_text())["$schema"]).exists())

    def test_the_motor_of_the_linkage_turns_its_crank(self):
        path = self.folder / "linkage.json"
        pantin("new", path, "--from", "linkage")
        record = self.folder / "record.csv"
        self.assertEqual(pantin("run", path, "--duration", "2", "--record", record).returncode, 0)
        rows = [line.split(",") for line in record.read_text().splitlines()]
        column = next(i for i, name in enumerate(rows[0]) if name.startswith("crank") and "y" in name)
        heights = [float(row[column]) for row in rows[1:]]
        self.assertGreater(max(heights), 1.09)
        self.assertLess(min(heights), 0.91)

    def test_no_file_is_written_over_unless_asked(self):
        path = self.folder / "mine.json"
        path.write_text("mine")
        refused = pantin("new", path)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("found a file, expected none", refused.stderr)
        self.assertEqual(path.read_text(), "mine")
        self.assertEqual(pantin("new", path, "--replace").returncode, 0)
        self.assertEqual(json.loads(path.read_text())["version"], 1)

    def test_the_scene_does_not_take_the_name_of_its_schema(self):
        refused = pantin("new", self.folder / "scene.schema.json")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("found the name of the schema", refused.stderr)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_what_cannot_be_written_or_is_no_template(self):
        self.assertEqual(pantin("new", self.folder / "no" / "such" / "scene.json").returncode, 4)
        wrong = pantin("new", self.folder / "a.json", "--from", "pendulun")
        self.assertEqual(wrong.returncode, 2)
        self.assertFalse((self.folder / "a.json").exists())

    def test_alone_the_program_prints_its_help(self):
        alone = pantin()
        self.assertEqual((alone.returncode, alone.stderr), (0, ""))
        self.assertEqual(alone.stdout, pantin("--help").stdout)


if __name__ == "__main__":
    unittest.main()
