"""Films of `pantin run`: what --gif and --video take and leave behind."""
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]
CHAIN = str(pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes" / "chain.json")


def run(*arguments, **options):
    return subprocess.run([PANTIN, "run", CHAIN, "--json", *map(str, arguments)],
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, timeout=120, **options)


def can_draw():
    with tempfile.TemporaryDirectory() as folder:
        return run("--frames", folder, "--size", "32x32", "--duration", "0.02").returncode != 1


class Film(unittest.TestCase):
    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)
        self.gif = self.folder / "a.gif"

    def tearDown(self):
        self.kept.cleanup()

    def test_names_of_films_are_checked(self):
        for option, name, ending in (("--gif", "a.webp", ".gif"), ("--video", "a.gif", ".mkv"),
                                     ("--video", "a", ".mp4")):
            done = run(option, self.folder / name)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            for word in (option, name, ending):
                self.assertIn(word, done.stderr)
        self.assertEqual(os.listdir(self.folder), [])

    @unittest.skipUnless(can_draw(), "nothing can be drawn here")
    def test_a_strip_is_no_wider_than_a_mail_shows(self):
        for options, wanted in (((), (1600, 450)), (("--size", "320x180"), (1280, 360))):
            path = self.folder / "strip.png"
            run("--duration", 0.1, "--strip", path, "--strip-columns", 4, "--strip-rows", 2, *options)
            head = path.read_bytes()[16:24]
            self.assertEqual((int.from_bytes(head[:4], "big"), int.from_bytes(head[4:], "big")), wanted)

    def test_strips_spread_over_a_period_of_a_motion_that_repeats(self):
        """A crank at a constant rate; a pendulum that slows down; one that is too slow."""
        scene = {"version": 1, "step": 0.01, "duration": 3, "solver": {"type": "lagrangian"},
                 "bodies": [{"name": "crank", "position": [0, 0.3, 0], "drag": 0,
                             "shape": {"type": "capsule", "radius": 0.02, "length": 0.5}}],
                 "joints": [{"kind": "hinge", "a": "world", "b": "crank", "anchor": [0, 0, 0],
                             "axis": [0, 0, 1]}]}
        motor = {"velocity": 7, "gain": 100}

        def period(scene, *words):
            path = self.folder / "scene.json"
            path.write_text(json.dumps(scene))
            done = subprocess.run([PANTIN, "run", path, "--strip", self.folder / "a.png", "--size",
                                   "32x32", *words], capture_output=True, text=True, timeout=120)
            self.assertEqual(done.returncode, 0, done.stderr)
            found = re.search(r"last period of (\S+) s", done.stdout)
            return float(found[1]) if found else None

        joint = scene["joints"][0]
        joint["motor"] = motor
        self.assertAlmostEqual(period(scene), 2 * math.pi / 7, delta=0.002)
        self.assertIsNone(period(scene, "--strip-times", "run"))
        self.assertIsNone(period(scene | {"duration": 1.5}))  # fewer than two turns
        del joint["motor"]
        scene["bodies"][0]["drag"] = 1
        self.assertIsNone(period(scene))

    @unittest.skipUnless(can_draw(), "nothing can be drawn here")
    def test_sides_and_states_change_the_picture(self):
        pictures = set()
        for words in ((), ("--from", "front"), ("--from", "top"), ("--states",)):
            path = self.folder / "strip.png"
            done = run("--duration", 0.1, "--strip", path, "--size", "64x64", *words)
            self.assertEqual(done.returncode, 0, done.stderr)
            pictures.add(path.read_bytes())
        self.assertEqual(len(pictures), 4)
        done = run("--duration", 0.1, "--from", "top")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--from: found no pictures to draw", done.stderr)

    @unittest.skipUnless(can_draw(), "nothing can be drawn here")
    def test_without_ffmpeg_it_is_told_before_the_run(self):
        done = run("--gif", self.gif, "--duration", 40, env={**os.environ, "PATH": str(self.folder)})
        self.assertEqual((done.returncode, done.stdout), (4, ""))
        self.assertIn("a.gif: ffmpeg is not on PATH", done.stderr)
        self.assertEqual(os.listdir(self.folder), [])

    @unittest.skipUnless(shutil.which("ffmpeg") and can_draw(), "no ffmpeg, or nothing can be drawn")
    def test_a_gif_is_small_and_slow_unless_size_and_rate_are_given(self):
        def form(*words):
            """Frames drawn; pictures, width and height of the GIF."""
            done = run("--duration", 0.2, "--gif", self.gif, *words)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(os.listdir(self.folder), ["a.gif"])
            data = self.gif.read_bytes()
            self.assertEqual(data[:6], b"GIF89a")
            pictures = data.count(b"\x21\xf9\x04")  # each says how long it is shown
            size = [int.from_bytes(data[i:i + 2], "little") for i in (6, 8)]
            return [json.loads(done.stdout)["frames_written"], pictures, *size]

        self.assertEqual(form(), [12, 5, 640, 360])
        self.assertEqual(form("--size", "701x301", "--fps", 20), [4, 4, 701, 301])


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
