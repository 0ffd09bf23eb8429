"""What the window of `pantin view` offers beyond dragging: its size, the panel, two panes, reading
files again, tools, films. By scripts, and by a window that nobody sees.

Needs PANTIN and PANTIN_ASSETS, like view_test.py. Ends with 77 where the build has no window or no
OpenGL works.
"""
import json
import pathlib
import select
import shutil
import signal
import subprocess
import time
import unittest
import zlib

import view_test
from view_test import PANTIN, SCENE, event, keys, unseen


def pixels(path):
    """Width, height and the rows of a picture that this program has written: filter 0 throughout."""
    data, at, packed = pathlib.Path(path).read_bytes(), 8, b""
    width, height = (int.from_bytes(data[i:i + 4], "big") for i in (16, 20))
    while at < len(data):
        length, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        packed += data[at + 8:at + 8 + length] if kind == b"IDAT" else b""
        at += length + 12
    raw, depth = zlib.decompress(packed), 4 if data[25] == 6 else 3
    line = 1 + depth * width
    return width, height, lambda x, y: tuple(raw[y * line + 1 + depth * x:y * line + 4 + depth * x])


class Window(view_test.View):
    def last_picture(self, events, *words):
        got = self.play([*events, *keys(events[-1]["t"] + 0.1, "s")], *words, size=(960, 540))
        return (got, *pixels(self.folder / got["saved"][-1]))

    def test_pictures_follow_the_size_of_the_window(self):
        for size in ((500, 300), (1100, 640)):
            got = self.play([event(0.1, "resize", width=size[0], height=size[1]),
                             *keys(0.4, "s")])
            self.assertEqual(pixels(self.folder / got["saved"][0])[:2], size)

    def test_a_panel_stands_beside_the_scene_and_its_buttons_work(self):
        off, *_ = self.last_picture([event(0.2, "mouse_move", x=5, y=5)])
        # "Pause" stands below the two lines at the panel's top.
        click = [event(0.2, "mouse_down", x=640 + 40, y=56), event(0.4, "mouse_up")]
        got, width, height, at = self.last_picture(click, "--panel", "on")
        self.assertEqual((width, height), (960, 540))
        self.assertFalse(off["panel"])
        self.assertEqual(got["paused"], got["panel"])
        self.assertEqual(off["paused"], False)
        dark = sum(max(at(x, y)) < 60 for x in range(645, 950, 5) for y in range(5, 535, 5))
        self.assertEqual(dark > 61 * 106 / 2, got["panel"])  # without the library it is no panel
        light = sum(min(at(x, y)) > 200 for x in range(645, 950) for y in range(5, 250))
        self.assertEqual(light > 300, got["panel"])  # letters

    def test_two_solvers_stand_side_by_side(self):
        alone = self.play([event(1, "quit")])
        got, _, _, at = self.last_picture([event(0.9, "mouse_move", x=5, y=5)], "--beside", "sweep")
        self.assertEqual((got["solver"], got["beside"]), ("auto", "sweep"))
        self.assertEqual([at(480, y) for y in range(0, 540, 20)], [(40, 40, 40)] * 27)
        same = self.play([event(1, "quit")], "--beside", "lagrangian")
        self.assertEqual(same["hash"], alone["hash"])
        back = self.play([*keys(0.3, "c"), *keys(0.6, "c"), event(1, "quit")])
        self.assertNotIn("beside", back)

    def test_a_scene_that_cannot_be_read_is_told_in_red_and_the_old_one_goes_on(self):
        broken = self.write("broken.json", '{"version": 1, "bodis": []}')
        calm, _, _, clean = self.last_picture([event(0.3, "mouse_move", x=5, y=5)])
        got, width, _, at = self.last_picture([event(0.2, "open", scene=str(broken)),
                                               event(0.3, "mouse_move", x=5, y=5)])
        self.assertEqual(got["title"], SCENE["title"])
        self.assertEqual(got["hash"], calm["hash"])
        self.assertIn("broken.json:1:", "\n".join(got["notes"]))
        red = lambda p: sum(p(x, y)[0] > 200 > 2 * p(x, y)[1] for x in range(width)
                            for y in range(200))
        self.assertGreater(red(at), 100)
        self.assertEqual(red(clean), 0)
        other = self.write("other.json", SCENE | {"title": "Another"})
        got = self.play([event(0.2, "open", scene=str(other)), event(0.5, "quit")])
        self.assertEqual(got["title"], "Another")

    def test_keys_cut_pin_and_shoot_at_what_is_under_the_mouse(self):
        over = event(0.1, "mouse_move", body="chain/3")
        for key, words in (("x", "cut "), ("p", "pinned chain/3")):
            got = self.play([over, *keys(0.2, key), event(0.5, "quit")])
            self.assertIn(words, "\n".join(got["notes"]))
        still = self.play([over, event(1, "quit")])
        shot = self.play([over, *keys(0.2, "b"), event(1, "quit")])
        self.assertNotEqual(shot["hash"], still["hash"])

    def test_knobs_of_a_script(self):
        got = self.play([event(0, "knob", name="step", to=5), event(0.5, "quit")])
        self.assertEqual(got["step_s"], 0.005)
        self.assertIn(got["steps"], (99, 100))  # the last may wait for a rounding error
        got = self.play([event(0, "knob", name="stpe", to=5), event(0.1, "quit")])
        self.assertIn("no knob stpe", got["notes"][0])

    def test_forces_and_wires_are_drawn(self):
        pictures = set()
        for key in ("", "f", "w", "o"):
            got = self.play([*keys(0.3, *key), event(0.3, "mouse_move", x=5, y=5), *keys(0.4, "s")])
            pictures.add((self.folder / got["saved"][0]).read_bytes())
        self.assertEqual(len(pictures), 4)

    @unittest.skipUnless(shutil.which("ffmpeg"), "ffmpeg is not installed")
    def test_a_film_begins_and_ends_by_a_key(self):
        got = self.play([*keys(0.2, "v"), *keys(0.7, "v"), event(0.8, "quit")])
        (film,) = got["saved"]
        self.assertEqual(pathlib.Path(film).name, "film_1.mp4")
        self.assertGreater((self.folder / film).stat().st_size, 2000)

    def test_a_file_is_read_again_while_a_user_looks(self):
        run = subprocess.Popen([PANTIN, "view", self.scene, "--json", "--size", "64x64"],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=self.folder,
                               env=unseen() | {"SDL_VIDEODRIVER": "dummy"})
        self.addCleanup(lambda: (run.kill(), run.wait(), run.stdout.close(), run.stderr.close()))

        def told(words):
            """What stands on stderr after a change, within a time that suffices by far."""
            end = time.monotonic() + 60
            while time.monotonic() < end:
                if select.select([run.stderr], [], [], 1)[0]:
                    line = run.stderr.readline().decode()
                    if words in line:
                        return
            self.fail("nobody told of " + words)

        time.sleep(2)
        self.write("scene.json", '{"version": 1, "bodis": []}')
        told("bodis")
        self.write("scene.json", SCENE | {"title": "Mended"})
        told("reloaded")
        run.send_signal(signal.SIGINT)
        out, _ = run.communicate(timeout=60)
        self.assertEqual(run.returncode, 130)
        self.assertEqual(json.loads(out)["title"], "Mended")


if __name__ == "__main__":
    view_test.run_all()
