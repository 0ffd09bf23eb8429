"""Files that the program is told to write: none takes the place of another, and what could not be
written is told by one exit code."""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]
CHAIN = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes" / "chain10.json"


def pantin(*arguments, **options):
    return subprocess.run([PANTIN, *map(str, arguments)], stdin=subprocess.DEVNULL, text=True,
                          **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "timeout": 120,
                             **options})


class Files(unittest.TestCase):
    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)
        self.scene = self.folder / "scene.json"
        self.scene.write_bytes(CHAIN.read_bytes())

    def tearDown(self):
        self.kept.cleanup()

    def assert_refused(self, *arguments):
        before = {path: path.read_bytes() for path in self.folder.iterdir() if path.is_file()}
        done = pantin(*arguments)
        self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        self.assertIn("expected another file", done.stderr)
        after = {path: path.read_bytes() for path in self.folder.iterdir() if path.is_file()}
        self.assertEqual(after, before)

    def test_two_outputs_that_mean_one_new_file_are_refused(self):
        link = self.folder / "link.csv"
        link.symlink_to("new.csv")
        old = os.getcwd()
        os.chdir(self.folder)
        try:
            for name in ("./new.csv", self.folder / "new.csv", "link.csv"):
                with self.subTest(name=name):
                    self.assert_refused("run", self.scene, "--duration", 0.1, "--record", name,
                                        "--save", "new.csv")
        finally:
            os.chdir(old)

    def test_an_output_onto_the_scene_is_refused(self):
        link = self.folder / "link.json"
        link.symlink_to(self.scene)
        twin = self.folder / "twin.json"
        os.link(self.scene, twin)
        for name in (self.scene, self.folder / "." / "scene.json", link, twin,
                     self.folder / "x" / ".." / "scene.json"):
            for option in ("--record", "--save", "--strip"):
                with self.subTest(option=option, name=name):
                    self.assert_refused("run", self.scene, "--duration", 0.1, option, name)
        self.assert_refused("bench", self.scene, "--csv", self.scene)

    def test_two_outputs_of_one_name_are_refused(self):
        out = self.folder / "out"
        self.assert_refused("run", self.scene, "--record", out, "--save", out)
        self.assert_refused("run", self.scene, "--save", out, "--strip", self.folder / "." / "out")
        out.write_text("kept")
        self.assert_refused("run", self.scene, "--record", out, "--save", out)
        self.assertEqual(out.read_text(), "kept")

    def test_a_state_may_be_gone_on_from_in_its_own_file_and_devices_be_shared(self):
        state = self.folder / "state"
        for words in (("--save", state), ("--load", state, "--save", state),
                      ("--record", "/dev/null", "--save", "/dev/null")):
            done = pantin("run", self.scene, "--duration", 0.1, *words)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(sorted(os.listdir(self.folder)), ["scene.json", "state"])

    @unittest.skipUnless(os.path.exists("/dev/full"), "no device that is always full")
    def test_what_cannot_be_printed_ends_with_one_exit_code(self):
        for words in ((), ("--help",), ("--version",), ("help", "run"), ("help", "--man"),
                      ("run", "--help"), ("schema",), ("completion", "bash"), ("doctor", "--json"),
                      ("check", self.scene), ("run", self.scene, "--duration", 0.1, "--json"),
                      ("run", self.scene, "--duration", 0.1)):
            with self.subTest(words), open("/dev/full", "w") as full:
                done = pantin(*words, stdout=full)
                self.assertEqual(done.returncode, 4, done.stderr)
                self.assertIn("could not write to the standard output", done.stderr)

    def test_a_word_that_nobody_knows_is_no_call_for_help(self):
        for words in (("frobnicate", "--help"), ("--help", "frobnicate"), ("frobnicate", "-h"),
                      ("runn", "--help")):
            done = pantin(*words)
            self.assertEqual((done.returncode, done.stdout), (2, ""), words)
            self.assertIn(f'found "{[w for w in words if w[0] != "-"][0]}"', done.stderr)
        for words in (("--help",), ("run", "--help"), ("run", self.scene, "--help")):
            self.assertEqual(pantin(*words).returncode, 0, words)

    def test_values_that_an_option_cannot_take_are_named_with_what_it_can(self):
        for words, told in (
                (("run", self.scene, "--record", ""), 'found "", expected the name of a file'),
                (("run", self.scene, "--frames", ""), 'found "", expected the name of a folder'),
                (("run", self.scene, "--solver", "swep"), 'nearest is "sweep"'),
                (("help", "runn"), 'found "runn", expected one of help, run'),
                (("run", self.scene, "--substeps", "1e2"), "a whole number from 1 to 1000"),
                (("run", self.scene, "--substeps", "0x2"), "a whole number from 1 to 1000"),
                (("--json", "run", self.scene), 'found "--json" before the command')):
            with self.subTest(words):
                done = pantin(*words)
                self.assertEqual((done.returncode, done.stdout), (2, ""))
                self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
                self.assertIn(told, done.stderr)

    def test_names_with_a_zero_byte_name_no_file(self):
        (self.folder / "part.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n")
        shape = {"type": "hull", "file": "part.obj\0.png"}
        self.scene.write_text(json.dumps({"version": 1, "bodies": [
            {"name": "a", "mass": 1, "inertia": [1, 1, 1], "shape": shape}]}))
        done = pantin("check", self.scene)
        self.assertEqual(done.returncode, 2, done.stdout)
        self.assertIn("zero byte", done.stderr)

    @unittest.skipUnless(shutil.which("ffmpeg"), "no ffmpeg")
    def test_a_disk_that_is_full_leaves_no_part_of_a_film(self):
        # A file that may not grow is what a full disk looks like to ffmpeg, but for its words.
        script = self.folder / "ffmpeg"
        script.write_text("#!/bin/sh\nfor last; do :; done\ncat > /dev/null\n"
                          "echo beginning > \"${last#file:}\"\n"
                          "echo 'Error: No space left on device' >&2\nexit ${STATUS}\n")
        script.chmod(0o755)
        for status in ("0", "1"):
            for option, name in (("--gif", "a.gif"), ("--video", "a.mp4")):
                done = pantin("run", self.scene, "--duration", 0.1, option, self.folder / name,
                              env={**os.environ, "STATUS": status,
                                   "PATH": f"{self.folder}:{os.environ['PATH']}"})
                if "no OpenGL context" in done.stderr:
                    self.skipTest("nothing can be drawn here")
                self.assertEqual(done.returncode, 4, done.stderr)
                self.assertIn("No space left on device", done.stderr)
                self.assertEqual(sorted(os.listdir(self.folder)), ["ffmpeg", "scene.json"])


if __name__ == "__main__":
    unittest.main()
