"""The examples that the program's help gives, run as they stand."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]
ASSETS = pathlib.Path(os.environ["PANTIN_ASSETS"])
# Only to be quick, and to end without a user.
BRIEF = {"run": "--duration 0.05", "bench": "--duration 0.05", "view": "--duration 0.05"}
QUIT = '[{"t": 0.05, "type": "quit"}]'


def call(line, folder):
    """A command line as a shell takes it, where `pantin` is on PATH; its exit code and output."""
    paths = f"{pathlib.Path(PANTIN).parent}{os.pathsep}{os.environ['PATH']}"
    return subprocess.run(line, shell=True, cwd=folder, env={**os.environ, "PATH": paths},
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, timeout=120)


class Folder(unittest.TestCase):
    """A folder with the shipped scenes, in which examples are run."""

    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)
        (self.folder / "assets").symlink_to(ASSETS.resolve())
        (self.folder / "out").mkdir()

    def tearDown(self):
        self.kept.cleanup()

    def run_example(self, command, line, script):
        """Runs a line of the help; 1 means that this build or machine cannot draw."""
        name = re.search(r"--script (\S+)", line)
        if name:
            (self.folder / name[1]).write_text(script)
        elif command == "view":
            (self.folder / "quit.json").write_text(QUIT)
            line += " --script quit.json"
        if re.search("--(video|gif)", line) and not shutil.which("ffmpeg"):
            return
        line = line.split(" && ")[0]
        # One scene stands for all: those have a test of their own.
        line = line.replace("/*.json", "/chain10.json")
        if "--duration" not in line and not name:
            line += " " + BRIEF.get(command, "")
        done = call(line, self.folder)
        needs_pictures = command == "view" or re.search("--(frames|video|gif|strip|picture)", line)
        if done.returncode == 1 and needs_pictures:
            return
        self.assertEqual(done.returncode, 0, f"{line}\n{done.stderr}")
        if "--json" in line.split(" -- ")[0]:
            json.loads(done.stdout)
        if name:
            self.assertNotIn("nothing was dragged", done.stdout)


class Examples(Folder):
    def help_of(self, command):
        done = call(f"pantin {command} --help", self.folder)
        self.assertEqual(done.returncode, 0)
        return done.stdout

    def test_every_example_of_every_command_works(self):
        for command in ("run", "check", "bench", "chart", "stability", "tune", "sweep", "doctor", "view", "schema", "surface",
                        "modes", "new", "completion", "help"):
            text = self.help_of(command)
            lines = re.findall(r"^\s*(pantin .*)$", text.split("Examples:")[1], re.M)
            self.assertGreater(len(lines), 0, command)
            script = re.search(r"^\s*(\[\{.*?\}\])$", text, re.M | re.S)
            if script:
                json.loads(script[1])
            for line in lines:
                with self.subTest(line):
                    self.assertTrue(line.startswith(f"pantin {command}"))
                    self.run_example(command, line, script and script[1])

    def test_the_scenes_of_the_page_on_motors_load_and_their_columns_exist(self):
        page = (ASSETS.parent / "engine" / "joints" / "MOTORS.md").read_text(encoding="utf-8")
        scenes = re.findall(r"^```json (\w+\.json)\n(.*?)^```$", page, re.M | re.S)
        self.assertEqual([name for name, _ in scenes], ["motors.json", "drives.json"])
        for name, text in scenes:
            (self.folder / name).write_text(text)
            done = call(f"pantin check {name}", self.folder)
            self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        line, = re.findall(r"`(pantin run motors.json [^`]*)`", page)
        done = call(line, self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [row.split(",") for row in done.stdout.splitlines()]
        self.assertEqual(rows[0], ["time_s", "shoulder.motor"])
        # The arm's weight, before it is raised: m g l / 2.
        (held,) = [float(row[1]) for row in rows[1:] if abs(float(row[0]) - 0.9) < 1e-3]
        self.assertAlmostEqual(held, 9.81 * 0.2, delta=1e-3)
        done = call("pantin run drives.json --duration 0.5 --json", self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        summary = json.loads(done.stdout)
        self.assertEqual(summary["status"], "ok")
        self.assertEqual(list(summary["sensors"]), ["effort"])
        self.assertEqual(summary["solver"], "lagrangian")


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
