"""pantin surface: what it tells, writes and refuses."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]
ASSETS = pathlib.Path(os.environ["PANTIN_ASSETS"])
HELPER = pathlib.Path(PANTIN).parent / "pantin-step"
TORUS = '{"faces": [{"type": "torus", "radius": 1, "tube": 0.25}]}'
DISC = '''{"faces": [{"type": "plane", "size": [2, 2], "trims": [
  {"type": "circle", "radius": 0.35, "position": [0.5, 0.5, 0]},
  {"type": "circle", "radius": 0.1, "position": [0.5, 0.5, 0]}]}]}'''
TUBE = '''{"faces": [{"type": "cylinder", "radius": 0.5, "height": 1, "trims": [
  {"type": "outline", "points": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]},
  {"type": "circle", "radius": 0.1, "position": [0.5, 0.5, 0]}]}]}'''
PI = 3.141592653589793


def pantin(*arguments, program=PANTIN):
    return subprocess.run([program, *map(str, arguments)], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300)


class Folder(unittest.TestCase):
    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)
        self.torus = self.folder / "torus.json"
        self.torus.write_text(TORUS)

    def tearDown(self):
        self.kept.cleanup()

    def told(self, *arguments):
        done = pantin("surface", *arguments, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def assert_refused(self, done, *words):
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        for word in words:
            self.assertIn(word, done.stderr)


class Surface(Folder):
    def test_tells_what_is_there(self):
        told = self.told(self.torus)
        self.assertEqual(len(told["faces"]), 1)
        self.assertEqual(told["faces"][0]["degrees"], [2, 2])
        self.assertEqual(told["faces"][0]["periodic"], [True, True])
        self.assertTrue(told["closed"])
        self.assertFalse(told["convex"])
        self.assertAlmostEqual(told["area_m2"], 4 * PI * PI * 0.25, delta=1e-9)
        self.assertAlmostEqual(told["volume_m3"], 2 * PI * PI * 0.0625, delta=1e-9)
        done = pantin("surface", self.torus)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("1 faces, closed", done.stdout)
        self.assertNotIn("volume_m3", self.told(ASSETS / "surfaces" / "groove.json"))

    def test_writes_what_it_reads_again_to_the_letter(self):
        once, twice = self.folder / "once.json", self.folder / "twice.json"
        self.assertEqual(pantin("surface", self.torus, "--out", once).returncode, 0)
        self.assertEqual(pantin("surface", once, "--out", twice).returncode, 0)
        self.assertEqual(once.read_text(), twice.read_text())
        self.assertEqual(self.told(once)["area_m2"], self.told(twice)["area_m2"])

    def test_tells_of_seams_along_trims(self):
        seam = self.folder / "seam.json"
        faces = json.loads(DISC)["faces"] + json.loads(TUBE)["faces"]
        seam.write_text(json.dumps({"faces": faces}))
        self.assertEqual(len(self.told(seam)["warnings"]), 1)
        done = pantin("surface", seam)
        self.assertEqual(done.returncode, 0)
        for words in (str(seam), "2 of 2 faces trimmed", "not joined along trims",
                      "a contact of a surface joint ends there"):
            self.assertIn(words, done.stderr)
        seam.write_text(json.dumps({"faces": faces[:1]}))
        self.assertEqual(self.told(seam)["warnings"], [])

    def test_tells_trims_and_their_share(self):
        disc = self.folder / "disc.json"
        disc.write_text(DISC)
        told = self.told(disc)
        self.assertEqual(told["faces"][0]["trims"], 2)
        self.assertAlmostEqual(told["area_m2"], PI * 0.45, delta=1e-12)
        self.assertAlmostEqual(told["faces"][0]["trim_share"], PI * 0.45 / 4, delta=1e-12)
        self.assertFalse(told["closed"])
        done = pantin("surface", disc)
        self.assertIn("trimmed by 2 loops to 35.34 % of its area", done.stdout)
        self.assertEqual(self.told(self.torus)["faces"][0]["trims"], 0)

    def test_draws_a_picture(self):
        picture = self.folder / "torus.png"
        done = pantin("surface", self.torus, "--picture", picture, "--size", "320x240")
        if done.returncode == 1:
            self.skipTest("no way to OpenGL here")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(picture.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(pantin("surface", self.torus, "--picture", picture, "--size", "7").returncode, 2)

    def test_refuses_bad_files_with_their_place(self):
        self.assert_refused(pantin("surface", self.folder / "nowhere.json"), "nowhere.json")
        bad = self.folder / "bad.json"
        bad.write_text('{"faces": [\n {"type": "torus", "radius": 1, "tube": -1}]}')
        out = self.folder / "out.json"
        self.assert_refused(pantin("surface", bad, "--out", out), f"{bad}:2", "/faces/0/tube")
        self.assertFalse(out.exists())
        for option, name in (("--out", "out.txt"), ("--picture", "out.jpg")):
            self.assert_refused(pantin("surface", self.torus, option, self.folder / name),
                                f"{option}: found", "expected a name that ends in")
            self.assertFalse((self.folder / name).exists())

    def test_without_the_helper_a_cad_file_is_refused_clearly(self):
        alone = self.folder / "bin"
        alone.mkdir()
        shutil.copy(PANTIN, alone / "pantin")
        part = self.folder / "part.step"
        part.write_text("ISO-10303-21;\n")
        self.assert_refused(pantin("surface", part, program=alone / "pantin"), "PANTIN_STEP",
                            "libocct-data-exchange-dev")


@unittest.skipUnless(HELPER.exists(), "built without PANTIN_STEP")
class Cad(Folder):
    def test_step_and_iges_come_back_as_they_went(self):
        before = self.told(self.torus)
        for name in ("torus.step", "torus.igs"):
            with self.subTest(name):
                part = self.folder / name
                done = pantin("surface", self.torus, "--out", part)
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                after = self.told(part)
                self.assertAlmostEqual(after["area_m2"], before["area_m2"], delta=1e-9)
                self.assertEqual(after["cad"]["faces"], 1)
                self.assertEqual(after["cad"]["trimmed"], 0)
                self.assertTrue(after["closed"])

    def test_trims_go_out_and_come_back(self):
        for shape, text in (("disc", DISC), ("tube", TUBE)):
            source = self.folder / f"{shape}.json"
            source.write_text(text)
            before = self.told(source)
            for ending in ("step", "igs"):
                with self.subTest(f"{shape}.{ending}"):
                    part = self.folder / f"{shape}.{ending}"
                    done = pantin("surface", source, "--out", part)
                    self.assertEqual((done.returncode, done.stderr), (0, ""))
                    after = self.told(part)
                    self.assertEqual(after["cad"]["trimmed"], 1)
                    self.assertEqual(after["cad"]["whole"], 0)
                    self.assertEqual(after["faces"][0]["trims"], 2)
                    self.assertAlmostEqual(after["area_m2"], before["area_m2"], delta=1e-5)

    def test_units_of_the_file_are_honoured(self):
        part = self.folder / "torus.igs"
        pantin("surface", self.torus, "--out", part)
        text = part.read_text()
        self.assertIn("2HMM", text)
        # The same numbers taken as inches: flag 1 in place of 2.
        part.write_text(text.replace("1.,2,2HMM,", "1.,1,2HIN,"))
        told = self.told(part)
        self.assertAlmostEqual(told["high"][0], 1.25 * 25.4, delta=1e-6)

    def test_what_is_no_cad_file_is_refused(self):
        for name in ("part.step", "part.igs"):
            part = self.folder / name
            part.write_text("nothing of the kind\n")
            self.assert_refused(pantin("surface", part), "part.")


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
