"""What the window of `pantin view` offers beyond dragging: its size, the panel, two panes, reading
files again, tools, films. By scripts, and by a window that nobody sees.

Needs PANTIN and PANTIN_ASSETS, like view_test.py. Ends with 77 where the build has no window or no
OpenGL works.
"""
import csv
import json
import math
import pathlib
import re
import select
import shutil
import signal
import subprocess
import time
import unittest
import zlib

import model_test
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
                            for y in range(270))
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
        self.assertIn('no knob stpe; nearest is "step"', got["notes"][0])

    def test_a_moved_slider_of_a_spring_or_a_limit_is_written_into_the_file(self):
        hinge = {"name": "h", "kind": "hinge", "a": "world", "b": "arm", "anchor": [0, 0, 0],
                 "axis": [0, 0, 1], "spring": {"stiffness": 2, "damping": 0.1},
                 "limits": {"angle_deg": [-90, 90]}, "motor": {"velocity_deg": 10, "gain": 1}}
        scene = {"version": 1, "solver": {"type": "lagrangian"}, "joints": [hinge], "bodies": [
            {"name": "arm", "position": [0.5, 0, 0], "shape": {"type": "box", "size": [1, 0.1, 0.1]}}]}
        knobs = [event(0, "knob", name=name, to=to) for name, to in (
            ("stiffness h", 7), ("most h", 0.5), ("motor h", 1), ("gravity", 3), ("step", 5))]
        for unit, metre in (("m", 1), ("mm", 1000)):
            path = self.write("tuned.json", json.dumps(scene | {"units": unit}))
            got = self.play([*knobs, *keys(0.1, "u"), event(0.3, "quit")], scene=path)
            self.assertIn("wrote the sliders", "\n".join(got["notes"]))
            new = json.loads(path.read_text())
            joint = new["joints"][0]
            self.assertAlmostEqual(joint["spring"]["stiffness"], 7 * metre)
            self.assertEqual(joint["spring"]["damping"], 0.1)
            self.assertAlmostEqual(joint["limits"]["angle_deg"][1], math.degrees(0.5))
            self.assertEqual(joint["limits"]["angle_deg"][0], -90)
            self.assertAlmostEqual(joint["motor"]["velocity_deg"], math.degrees(1))
            self.assertAlmostEqual(new["gravity"][1], -3 * metre)
            self.assertAlmostEqual(new["step"], 0.005)
        chain = self.write("chain.json", SCENE)
        got = self.play([event(0, "knob", name="least chain/0-1", to=1), event(0.2, "quit")],
                        scene=chain)
        self.assertIn("no knob least chain/0-1", got["notes"][0])  # it has no limits

    def test_sliders_of_copies_chains_classes_and_two_coordinates_are_written_at_their_source(self):
        arm = {"name": "arm", "position": [0.5, 0, 0],
               "shape": {"type": "box", "size": [1, 0.1, 0.1]}}
        hinge = {"name": "h_l", "kind": "hinge", "a": "world", "b": "arm", "anchor": [0, 0, 0],
                 "axis": [0, 0, 1], "spring": {"stiffness": 2, "damping": 0.1},
                 "limits": {"angle_deg": [-90, 90]}}
        slider = {"name": "s", "a": "world", "b": "rod", "anchor": [0, 3, 0], "axis": [1, 0, 0]}
        scene = {
            "version": 1, "solver": {"type": "lagrangian"},
            "prefabs": [{"name": "leg", "bodies": [arm], "joints": [hinge]},
                        {"name": "pair", "instances": [{"name": "one", "prefab": "leg"}]},
                        {"name": "kept", "file": "kept.json"}],
            "instances": [{"name": "i", "prefab": "pair"},
                          {"name": "m", "prefab": "leg", "mirror": "x", "position": [0, 1, 0]},
                          {"name": "k", "prefab": "kept", "position": [0, 2, 0]}],
            "generators": {
                "grids": [{"name": "g", "prefab": "leg", "count": [2, 1, 1], "spacing": [3, 1, 1],
                           "position": [0, 4, 0]}],
                "chains": [{"name": "c", "kind": "hinge", "links": 3, "length": 0.2,
                            "start": [0, 6, 0], "attach": "world", "axis": [0, 0, 1],
                            "shape": {"type": "capsule", "radius": 0.02, "length": 0.1},
                            "limits": {"angle_deg": [-30, 30]}}]},
            "classes": [{"name": "stiff", "joint": {"spring": {"stiffness": 5}}},
                        {"name": "both", "class": "stiff", "joint": {"kind": "hinge"}}],
            "bodies": [arm | {"name": "rod", "position": [0.5, 3, 0]},
                       arm | {"name": "leaf", "position": [0.5, 7, 0]},
                       arm | {"name": "bob", "position": [0, 9, 0]}],
            "joints": [slider | {"kind": "cylindrical",
                                 "angle": {"motor": {"velocity": 1, "gain": 2}},
                                 "travel": {"spring": {"stiffness": 8}},
                                 "limits": {"travel": [-1, 1]}},
                       {"class": "both", "name": "l", "a": "world", "b": "leaf",
                        "anchor": [0, 7, 0], "axis": [0, 0, 1]},
                       {"kind": "spring", "name": "z", "a": "world", "b": "bob",
                        "point_a": [0, 10, 0], "stiffness": 50}]}
        self.write("kept.json", {"version": 1, "bodies": [arm], "joints": [hinge]})

        def tuned(name, to, unit="m"):
            path = self.write("tuned.json", scene | {"units": unit})
            got = self.play([event(0, "knob", name=name, to=to), *keys(0.1, "u"),
                             event(0.2, "quit")], scene=path)
            return json.loads(path.read_text()), "\n".join(got["notes"])

        leg = lambda new: new["prefabs"][0]["joints"][0]
        for name in ("i/one/h_l", "m/h_r", "g/1/h_l"):
            new, notes = tuned("stiffness " + name, 7)
            self.assertIn("of all copies of the prefab leg", notes)
            self.assertEqual(leg(new)["spring"], {"stiffness": 7, "damping": 0.1}, name)
        new, notes = tuned("most c/0-1", 0.5)
        self.assertIn("of all joints of the chain c", notes)
        self.assertAlmostEqual(new["generators"]["chains"][0]["limits"]["angle_deg"][1],
                               math.degrees(0.5))
        new, notes = tuned("stiffness l", 6)
        self.assertEqual(new["classes"][0]["joint"]["spring"]["stiffness"], 6)
        for unit, metre in (("m", 1), ("mm", 1000)):
            both = [tuned(*knob, unit)[0]["joints"][0] for knob in (
                ("motor s.angle", 3), ("stiffness s.travel", 9), ("least s.travel", -0.5))]
            self.assertEqual(both[0]["angle"]["motor"]["velocity"], 3)
            self.assertAlmostEqual(both[1]["travel"]["spring"]["stiffness"], 9 / metre)
            self.assertAlmostEqual(both[2]["limits"]["travel"][0], -0.5 * metre)
            self.assertEqual([b["limits"]["travel"][1] for b in both], [1, 1, 1])
            new, _ = tuned("stiffness z", 60, unit)
            self.assertAlmostEqual(new["joints"][2]["stiffness"], 60 / metre)
        new, notes = tuned("stiffness k/h_l", 7)
        self.assertIn("did not write stiffness k/h_l: it is in kept.json: open that file", notes)
        self.assertEqual(new, scene | {"units": "m"})

    PENDULUM = {
        "version": 1, "step": 0.005, "duration": 0.8, "solver": {"type": "lagrangian"},
        "joints": [{"name": "pivot", "kind": "hinge", "a": "world", "b": "arm",
                    "anchor": [0, 0, 0], "axis": [0, 0, 1], "motor": {"velocity": 1, "gain": 2}}],
        "bodies": [{"name": "arm", "position": [0.5, 0, 0],
                    "shape": {"type": "box", "size": [1, 0.1, 0.1]}}],
        "camera": {"eye": [0, 0, 4], "target": [0, 0, 0], "automatic": False}}

    def record_of(self, scene, *words):
        path = self.folder / "wanted.csv"
        subprocess.run([PANTIN, "run", scene, "--record", path, *words], check=True,
                       capture_output=True, timeout=120)
        return self.rows_of(path)

    def rows_of(self, path):
        with open(self.folder / path, newline="") as file:
            return list(csv.DictReader(file))

    def test_a_click_plots_the_columns_of_a_record(self):
        scene = self.write("pendulum.json", self.PENDULUM)
        wanted = self.record_of(scene, "--columns", "pivot.*,arm.*", "--duration", "0.5")
        # Away from the body, so that the run is not held up: a click there, or the key.
        for name, look in (("pivot", [event(0, "mouse_move", x=160, y=90), *keys(0, "n")]),
                           ("pivot", [event(0, "mouse_move", x=160, y=97), *keys(0, "n")]),
                           ("arm", [event(0, "mouse_move", body="arm"), *keys(0, "n")])):
            got = self.play([*look, event(0.5, "quit")], scene=scene)
            plots = {p["name"]: p for p in got["plots"]}
            self.assertIn(f"plots {name}: ", got["notes"][0])
            self.assertEqual(set(plots), {c for c in wanted[0] if c.startswith(name + ".") and
                                          ".q" not in c and not c.endswith(("gap_m", ".fx", ".fy",
                                                                            ".fz", ".tx", ".ty",
                                                                            ".tz"))})
            (last,) = [row for row in wanted if abs(float(row["time_s"]) - got["simulated_s"]) < 1e-9]
            for column, plot in plots.items():
                values = [float(r[column]) for r in wanted[1:plot["samples"] + 1]]
                self.assertEqual(plot["samples"], got["steps"])
                self.assertAlmostEqual(plot["last"], float(last[column]), places=9)
                self.assertAlmostEqual(plot["most"], max(values), places=9)
                self.assertAlmostEqual(plot["least"], min(values), places=9)
        self.assertEqual(plots["arm.x"]["unit"], "m")
        clicked = self.play([event(0.1, "mouse_down", body="arm"), event(0.1, "mouse_up"),
                             event(0.3, "mouse_down", x=5, y=5), event(0.3, "mouse_up"),
                             event(0.5, "quit")], scene=scene)
        self.assertEqual(clicked["plots"][0]["name"], "arm.x")
        self.assertIn("no body at 5, 5", clicked["notes"][-1])
        dragged = self.play([event(0.1, "mouse_down", body="chain/3"),
                             event(0.2, "mouse_move", dx=20, dy=0), event(0.3, "mouse_up"),
                             event(0.5, "quit")])
        self.assertEqual(dragged["plots"], [])
        other = self.play([event(0, "mouse_move", x=160, y=90), *keys(0, "n"), *keys(0.3, "r"),
                           event(0.5, "open", scene=str(self.scene)), event(0.6, "quit")], scene=scene)
        self.assertEqual(other["plots"], [])  # there is no pivot

    def test_a_run_is_recorded_from_now_on_or_from_its_start(self):
        scene = self.write("pendulum.json", self.PENDULUM)
        wanted = self.record_of(scene, "--columns", "*")
        got = self.play([*keys(0.2, "y"), *keys(0.5, "y"), *keys(0.55, "y"), *keys(0.6, "r"),
                         event(0.7, "key", key="y", shift=True), event(2.5, "quit")], scene=scene)
        self.assertEqual(got["saved"], [f"./run_{i}.{ext}" for i in (1, 2, 3) for ext in ("csv", "glb")])
        for number, first, last in ((1, 0.2, 0.5), (2, 0.55, 0.6), (3, 0, 0.8)):
            rows = self.rows_of(f"run_{number}.csv")
            self.assertAlmostEqual(float(rows[0]["time_s"]), first, delta=0.021)
            self.assertAlmostEqual(float(rows[-1]["time_s"]), last, delta=0.021)
            start = [r["time_s"] for r in wanted].index(rows[0]["time_s"])
            self.assertEqual(rows, wanted[start:start + len(rows)]
                             if number == 3 else self.without_first_readings(rows, wanted, start))
            model = model_test.Model(self.folder / f"run_{number}.glb")
            times, places = model.channel(model.node("arm"), "translation")
            self.assertAlmostEqual(times[-1], float(rows[-1]["time_s"]) - float(rows[0]["time_s"]),
                                   delta=0.021)
            for time, place in zip(times, places):
                (row,) = [r for r in rows if
                          abs(float(r["time_s"]) - float(rows[0]["time_s"]) - time) < 1e-5]
                for axis, at in zip("xyz", place):
                    self.assertAlmostEqual(at, float(row["arm." + axis]), delta=1e-5)

    def without_first_readings(self, rows, wanted, start):
        """What a record would have; forces of its first row are those of a step before it."""
        return [rows[0], *wanted[start + 1:start + len(rows)]]

    def test_a_run_stops_or_starts_again_at_the_end_of_the_scene(self):
        short = self.write("short.json", SCENE | {"duration": 0.5, "step": 0.01})
        got = self.play([event(2, "quit")], "--at-end", "stop", scene=short)
        self.assertTrue(got["paused"])
        self.assertAlmostEqual(got["simulated_s"], 0.5, delta=0.02)
        got = self.play([*keys(1, "space"), event(2, "quit")], "--at-end", "stop", scene=short)
        self.assertFalse(got["paused"])  # goes on beyond it
        self.assertGreater(got["simulated_s"], 1)
        got = self.play([event(2, "quit")], "--at-end", "loop", scene=short)
        self.assertGreaterEqual(got["restarts"], 3)
        self.assertLess(got["simulated_s"], 0.52)
        got = self.play([*keys(0.1, "j"), event(2, "quit")], scene=short)
        self.assertTrue(got["paused"])
        self.assertEqual(self.play([event(2, "quit")], scene=short)["restarts"], 0)

    def test_distances_and_angles_are_measured_under_the_mouse(self):
        at = {"a": (0, 1), "b": (0, 0), "c": (0.8, 0)}
        eye, radius = (0, 0, 4), 0.1
        scene = self.write("three.json", {
            "version": 1, "ground": False,
            "bodies": [{"name": n, "motion": "fixed", "position": [*p, 0],
                        "shape": {"type": "sphere", "radius": radius}} for n, p in at.items()],
            "camera": {"eye": eye, "target": [0, 0, 0]}})
        got = self.play([e for i, n in enumerate(at) for e in
                         (event(0.2 + i / 2, "mouse_move", body=n), *keys(0.3 + i / 2, "g"))],
                        scene=scene, size=(960, 540))

        def front(p):
            to = [e - x for e, x in zip(eye, (*p, 0))]
            far = math.hypot(*to)
            return [x + radius * t / far for x, t in zip((*p, 0), to)]

        a, b, c = (front(p) for p in at.values())
        note = [n for n in got["notes"] if "angle" in n and "deg" in n][-1]
        first, second, angle = (float(x) for x in re.search(
            r"distance (\S+) m and (\S+) m, angle (\S+) deg", note).groups())
        self.assertAlmostEqual(first, math.dist(a, b), delta=0.02)
        self.assertAlmostEqual(second, math.dist(b, c), delta=0.02)
        self.assertAlmostEqual(angle, 90, delta=2)

    def test_views_of_technical_drawings_and_the_way_back(self):
        scene = self.write("still.json", {
            "version": 1, "gravity": [0, 0, 0], "bodies": [
                {"name": "a", "shape": {"type": "box", "size": [0.6, 0.2, 0.1]}},
                {"name": "b", "position": [0, 0.5, 0.3], "shape": {"type": "cone", "radius": 0.1,
                                                                  "height": 0.3}}]})
        names = ("", "e", "d", "t", "i", "a", "e home", "a a")
        pictures = {}
        for name in names:
            presses = [e for i, key in enumerate(name.split())
                       for e in keys(0.3 + i / 10, key)]
            got = self.play([*presses, *keys(4, "s")], scene=scene)
            pictures[name] = self.pixels_without_labels(got)
        different = {pictures[name] for name in ("", "e", "d", "t", "i", "a")}
        self.assertEqual(len(different), 6)
        self.assertEqual(pictures["e home"], pictures[""])
        self.assertEqual(pictures["a a"], pictures[""])

    def pixels_without_labels(self, got):
        width, height, at = pixels(self.folder / got["saved"][-1])
        return tuple(at(x, y) for x in range(0, width, 2) for y in range(height // 2, height, 2))

    def test_the_title_is_out_of_the_way_after_three_seconds(self):
        paused = keys(0, "space")
        pictures = [self.play([*paused, *keys(0.1, "h"), *keys(t, "s")])["saved"][0] for t in
                    (1, 4, 5)]
        early, late, later = ((self.folder / p).read_bytes() for p in pictures)
        self.assertNotEqual(early, late)
        self.assertEqual(late, later)

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
