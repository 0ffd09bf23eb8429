"""`pantin view` under scripts of events: dragging, keys, bad scripts, saved frames; under Xvfb too.

Needs PANTIN (the program) and PANTIN_ASSETS. Ends with 77 where the build has no window or no
OpenGL works.
"""
import json
import math
import os
import pathlib
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PANTIN = os.environ["PANTIN"]
SCENES = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes"
SIZE = (320, 180)

LINKS, RADIUS, DISTANCE, FIELD = 8, 0.03, 4.0, 0.7
SCENE = {
    "version": 1,
    "title": "Hanging chain",
    "bodies": [{"name": "nail", "motion": "fixed", "position": [0, 1.8, 0],
                "shape": {"type": "box", "size": [0.1, 0.1, 0.1]}}],
    "generators": {"chains": [{
        "name": "chain", "links": LINKS, "length": 0.12, "start": [0, 1.75, 0], "attach": "nail",
        "density": 500, "drag": 2,
        "shape": {"type": "capsule", "radius": RADIUS, "length": 0.05}}]},
    "camera": {"eye": [0, 1.2, DISTANCE], "target": [0, 1.2, 0], "automatic": False,
               "field_of_view_deg": math.degrees(FIELD)},
}
LAST = f"chain/{LINKS - 1}"
CARRIED = {
    "version": 1,
    "bodies": [{"name": "bar", "motion": "kinematic", "position": [0, 1, 0],
                "shape": {"type": "sphere", "radius": 0.1}}],
    "paths": [{"body": "bar", "lissajous": {"centre": [0, 1, 0], "amplitude": [0.3, 0, 0],
                                             "frequency": [1, 0, 0]}}],
    "camera": {"eye": [0, 1, 3], "target": [0, 1, 0], "automatic": False},
}


def metres(pixels):
    """Length of a row of pixels in the plane through the front of the hanging chain."""
    return pixels * 2 * math.tan(FIELD / 2) * (DISTANCE - RADIUS) / SIZE[1]


def event(t, kind, **more):
    return {"t": t, "type": kind, **more}


def keys(t, *names):
    return [event(t, "key", key=name) for name in names]


def drag(start, end, body, dx, dy, **how):
    """A drag in ten moves, half of the time; then the hand rests."""
    down = event(start, "mouse_down", body=body, **how)
    moves = [event(start + (end - start) / 2 * (i + 1) / 10, "mouse_move", dx=dx / 10, dy=dy / 10)
             for i in range(10)]
    up = event(end, "mouse_up", **{k: v for k, v in how.items() if k == "button"})
    return [down, *moves, up]


def unseen():
    """An environment without any display."""
    drop = ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")
    return {k: v for k, v in os.environ.items() if k not in drop}


class View(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.scene = self.write("scene.json", SCENE)

    def write(self, name, value):
        path = self.folder / name
        path.write_text(value if isinstance(value, str) else json.dumps(value))
        return path

    def call(self, *words, env=None):
        return subprocess.run([PANTIN, "view", *map(str, words)], capture_output=True, text=True,
                              env=env or unseen(), cwd=self.folder, timeout=120)

    def play(self, events, *words, scene=None, env=None, code=0, size=SIZE):
        script = self.write("events.json", events)
        done = self.call(scene or self.scene, "--script", script, "--json", "--size",
                         "%dx%d" % size, *words, env=env)
        self.assertEqual(done.returncode, code, done.stderr)
        return json.loads(done.stdout)


class Dragging(View):
    def test_an_exact_drag_brings_the_last_link_to_the_mouse(self):
        got = self.play(drag(0.1, 1.1, LAST, 30, -30))
        (pick,) = got["picks"]
        self.assertEqual((pick["body"], pick["grip"]), (LAST, "exact"))
        self.assertLess(abs(pick["distance_moved_m"] - metres(math.hypot(30, 30))), 2e-3)
        self.assertLess(pick["worst_residual_m"], 1e-9)
        self.assertLess(pick["worst_elsewhere_m"], 1e-3)
        self.assertLess(got["worst_gap_rel"], 1e-7)  # the hand is a second anchor: its joint counts
        self.assertTrue(pick["reachable"])
        self.assertEqual(got["status"], "ok")

    def test_a_spring_follows_with_a_lag_and_ends_near_the_mouse(self):
        for how in ({"button": "right"}, {"shift": True}):
            got = self.play(drag(0.1, 2.6, LAST, 30, -30, **how))
            (pick,) = got["picks"]
            self.assertEqual(pick["grip"], "spring")
            self.assertGreater(pick["worst_residual_m"], 1e-3)
            self.assertLess(pick["residual_m"], 0.05)
            self.assertLess(abs(pick["distance_moved_m"] - metres(math.hypot(30, 30))), 0.05)
            self.assertLess(got["worst_gap_rel"], 1e-12)

    def test_a_pull_out_of_reach_says_what_gave_way(self):
        got = self.play(drag(0.1, 0.6, LAST, 0, 60))
        (pick,) = got["picks"]
        self.assertLess(pick["worst_residual_m"], 1e-9)
        # It hung straight, so what the mouse pulls farther the nail lacks; half a link's length
        # is left to the last link, which may tilt about the point it is held by.
        self.assertLess(abs(pick["worst_elsewhere_m"] - metres(60)), 0.06)

    def test_a_point_of_a_body_and_a_place_in_pixels_are_found(self):
        got = self.play([event(0.1, "mouse_down", body=LAST, at=[0, 0.03, 0]),
                         event(0.2, "mouse_up")])
        self.assertEqual([p["body"] for p in got["picks"]], [LAST])
        middle = SIZE[0] // 2
        # The link's radius and three pixels to the side: beside the chain, near enough.
        beside = middle + round(RADIUS / metres(1)) + 3
        for x in (middle, beside):
            got = self.play([event(0.1, "mouse_down", x=x, y=SIZE[1] // 2), event(0.2, "mouse_up")])
            self.assertEqual(len(got["picks"]), 1, got["notes"])

    def test_a_press_on_nothing_and_on_a_fixed_body_picks_nothing(self):
        got = self.play([event(0.1, "mouse_down", x=2, y=2), event(0.2, "mouse_up"),
                         event(0.3, "mouse_down", body="nail"), event(0.4, "mouse_up")])
        self.assertEqual(got["picks"], [])
        notes = "\n".join(got["notes"])
        for words in ("no body at 2, 2", "nail is fixed", "nothing was dragged"):
            self.assertIn(words, notes)

    def test_pose_mode_drags_without_dynamics_and_keeps_the_pose_in_a_file(self):
        got = self.play([*keys(0.05, "m"), *drag(0.1, 1.1, LAST, 30, -30), *keys(1.2, "k"),
                         event(1.3, "quit")])
        (pick,) = got["picks"]
        self.assertEqual((pick["body"], pick["grip"]), (LAST, "pose"))
        self.assertLess(abs(pick["distance_moved_m"] - metres(math.hypot(30, 30))), 2e-3)
        self.assertLess(pick["residual_m"], 1e-6)
        self.assertTrue(got["posing"])
        self.assertLess(got["simulated_s"], 0.06)  # none after the key
        kept = self.folder / got["saved"][0]
        self.assertEqual(kept.name, "pose_1.json")
        poses = {p["body"]: p["position"] for p in json.loads(kept.read_text())["poses"]}
        self.assertEqual(len(poses), LINKS)
        # The link hung straight below the nail at x = 0.
        self.assertGreater(poses[LAST][0], metres(30) / 2)
        again = self.play([event(0.01, "quit")], scene=kept)
        self.assertEqual((again["status"], again["warnings"]), ("ok", []))
        self.assertLess(again["worst_gap_m"], 1e-9)

    def test_dynamics_go_on_from_a_pose_at_rest(self):
        got = self.play([*keys(0.05, "m"), *drag(0.1, 1.1, LAST, 30, -30), *keys(1.2, "m"),
                         event(1.7, "quit")])
        self.assertFalse(got["posing"])
        self.assertGreater(got["simulated_s"], 0.5)
        self.assertLess(got["worst_gap_rel"], 1e-7)
        self.assertIn("dynamics go on from this pose, at rest", "\n".join(got["notes"]))

    def test_a_kinematic_body_is_carried_and_led_back_to_its_path(self):
        scene = self.write("carried.json", CARRIED)
        still = self.play([event(2, "quit")], scene=scene)
        got = self.play([*drag(0.1, 1, "bar", 20, 20), event(2, "quit")], scene=scene)
        (pick,) = got["picks"]
        self.assertEqual(pick["grip"], "kinematic")
        self.assertGreater(pick["distance_moved_m"], 0.05)
        self.assertLess(pick["worst_residual_m"], 1e-9)
        self.assertEqual(got["hash"], still["hash"])
        away = self.play([*drag(0.1, 1, "bar", 20, 20)[:-1], event(1, "quit")], scene=scene)
        there = self.play([event(1, "quit")], scene=scene)
        self.assertNotEqual(away["hash"], there["hash"])


class Keys(View):
    def test_time_stands_still_steps_and_runs_slowly_or_fast(self):
        steps = lambda events: self.play([*events, event(1, "quit")])["steps"]
        self.assertEqual(steps([]), 60)
        self.assertEqual(steps(keys(0.5, "space")), 30)
        self.assertEqual(steps(keys(0.5, "space", ".", ".", ".")), 33)
        self.assertEqual(steps(keys(0.25, "space") + keys(0.5, "space")), 45)
        self.assertEqual(steps(keys(0, "[")), 30)
        self.assertEqual(steps(keys(0, *["["] * 9)), 3)
        self.assertEqual(steps(keys(0, "]")), 120)
        self.assertEqual(steps(keys(0, *["]"] * 9)), 240)
        got = self.play([*keys(0, "[", "space"), event(0.5, "quit")])
        self.assertEqual((got["paused"], got["speed"], got["steps"]), (True, 0.5, 0))

    def test_the_solver_is_switched_while_running(self):
        pull, hashes = drag(0.1, 0.6, LAST, 20, -20), set()
        for key, name in zip("1234", ("auto", "sweep", "shake2", "procedural")):
            got = self.play([*pull[:-1], *keys(0.5, key), pull[-1], event(0.9, "quit")])
            self.assertEqual(got["solver"], name)
            hashes.add(got["hash"])
        self.assertEqual(len(hashes), 4)

    def test_a_restart_is_the_beginning(self):
        pull = drag(0.1, 0.4, LAST, 20, -20)
        fresh = self.play([event(0.5, "quit")])
        got = self.play([*pull, *keys(0.5, "r"), event(1, "quit")])
        self.assertEqual((got["restarts"], got["steps"]), (1, 60))
        self.assertEqual(got["hash"], fresh["hash"])
        held = self.play([*pull[:-1], *keys(0.5, "r"), event(1, "quit")])
        self.assertEqual(held["hash"], fresh["hash"])
        self.assertEqual(len(held["picks"]), 1)

    def test_the_same_script_ends_in_the_same_bits(self):
        pull = [*drag(0.1, 0.6, LAST, 40, -20), *drag(0.7, 1, "chain/3", -20, 5, button="right")]
        one, two = self.play(pull), self.play(pull, "--threads", 4)
        self.assertEqual(one["hash"], two["hash"])
        self.assertEqual(one["picks"], two["picks"])
        self.assertNotEqual(one["hash"], self.play(pull[:5])["hash"])

    def test_q_escape_duration_and_the_end_of_the_script_end_it(self):
        self.assertEqual(self.play([*keys(0.5, "q"), event(5, "quit")])["steps"], 30)
        self.assertEqual(self.play([*keys(0.5, "escape"), event(5, "quit")])["steps"], 30)
        self.assertEqual(self.play(keys(0.5, "h"))["steps"], 90)
        self.assertEqual(self.play([event(5, "quit")], "--duration", 0.5)["steps"], 30)

    def test_an_interrupt_ends_it_with_a_summary(self):
        script = self.write("long.json", [event(3600, "quit")])
        words = [PANTIN, "view", self.scene, "--script", script, "--json", "--size", "64x64"]
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=unseen(),
                              cwd=self.folder) as run:
            time.sleep(2)
            run.send_signal(signal.SIGINT)
            out, _ = run.communicate(timeout=30)
        self.assertEqual(run.returncode, 130)
        self.assertEqual(json.loads(out)["status"], "interrupted")


class Frames(View):
    def save(self, *events):
        """The picture after some events, time standing still."""
        folder = tempfile.mkdtemp(dir=self.folder)
        got = self.play([*keys(0, "space"), *events, *keys(0.2, "s"), event(0.3, "quit")],
                        "--frames", folder)
        (path,) = got["saved"]
        return pathlib.Path(path).read_bytes()

    def test_a_saved_frame_is_a_png_of_the_window(self):
        png = self.save()
        self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(tuple(int.from_bytes(png[i:i + 4], "big") for i in (16, 20)), SIZE)
        self.assertEqual(png, self.save())

    def test_camera_overlay_and_help_change_the_picture(self):
        turn = [event(0.1, "mouse_down", x=100, y=90, button="middle"),
                event(0.1, "mouse_move", dx=40, dy=10), event(0.1, "mouse_up", button="middle")]
        pictures = {self.save(), self.save(*turn), self.save(event(0.1, "wheel", dy=3)),
                    self.save(*keys(0.1, "o")), self.save(*keys(0.1, "h"))}
        self.assertEqual(len(pictures), 5)

    def test_no_picture_is_overwritten(self):
        (self.folder / "frame_1.png").write_text("mine")
        got = self.play([*keys(0.1, "s"), *keys(0.2, "s"), event(0.3, "quit")])
        names = [pathlib.Path(p).name for p in got["saved"]]
        self.assertEqual(names, ["frame_2.png", "frame_3.png"])
        self.assertEqual((self.folder / "frame_1.png").read_text(), "mine")

    def test_a_folder_that_cannot_be_is_told(self):
        done = self.call(self.scene, "--script", self.write("e.json", []), "--frames",
                         self.scene / "frames")
        self.assertEqual(done.returncode, 4)
        self.assertIn("expected a folder for frames", done.stderr)


class Refusals(View):
    def refused(self, events, *words):
        script = self.write("events.json", events)
        done = self.call(self.scene, "--script", script)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertIn("events.json", done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)

    def test_text_that_is_no_json(self):
        self.refused('[{"t": 0,\n  }]', "events.json:2:3: found", "expected")
        self.refused("", "expected")
        self.refused({"t": 1}, "an array of events")

    def test_events_that_say_nothing_or_too_much(self):
        self.refused([event(0, "mousedown", x=1, y=1)], "/0/type", 'nearest is "mouse_down"')
        self.refused([event(0, "key", key="spac")], "/0/key", 'nearest is "space"')
        self.refused([event(0, "mouse_down", body="chain/77")], "/0/body", 'nearest is "chain/7"')
        self.refused([event(0, "mouse_down", x=1)], 'found no "y"')
        self.refused([event(0, "mouse_down", x=1, y=2, button="rigth")], 'nearest is "right"')
        self.refused([event(0, "mouse_move")], "found no place")
        self.refused([event(0, "mouse_move", x=1, y=2, body=LAST)], "more than one place")
        self.refused([event(0, "mouse_down", at=[0, 0, 0])], 'expected "body"')
        self.refused([event(0, "quit", x=1)], 'found key "x"')
        self.refused([{"type": "quit"}], 'found no "t"')
        self.refused([event(-1, "quit")], "/0/t", "found -1", "a time from 0")
        self.refused([event(1, "quit"), event(0.5, "quit")], "/1", "1 or later")
        self.refused([5], "/0: found 5")
        self.refused([event(0, "knob", name="step")], 'found no "to"')
        self.refused([event(0, "open")], 'found no "scene"')
        self.refused([event(0, "resize", width=2, height=20)], "/0/width", "from 16 to 8192")
        self.refused('[{"t": 1e999, "type": "quit"}]', "/0/t")

    def test_all_complaints_come_at_once(self):
        self.refused([event(0, "kye"), event(0, "wheel"), 7], "/0", "/1", "/2")

    def test_files_and_options(self):
        self.assertEqual(self.call(self.scene, "--script", "none.json").returncode, 2)
        self.assertEqual(self.call(self.scene, "--script", self.folder).returncode, 2)
        self.assertEqual(self.call("none.json").returncode, 2)
        self.assertEqual(self.call(self.scene, "--size", "9x9").returncode, 2)

    def test_without_a_display_or_with_a_broken_one_there_is_one_line(self):
        for more in ({}, {"DISPLAY": ":9999"}, {"SDL_VIDEODRIVER": "nothing"}):
            done = self.call(self.scene, env=unseen() | more)
            self.assertEqual(done.returncode, 1)
            ours = [line for line in done.stderr.splitlines() if line.startswith("pantin:")]
            self.assertEqual(len(ours), 1, done.stderr)


@unittest.skipUnless(shutil.which("Xvfb"), "Xvfb is not installed")
class Screen(View):
    def setUp(self):
        super().setUp()
        read, write = os.pipe()
        server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "800x600x24"],
                                  pass_fds=[write], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL)
        self.addCleanup(lambda: (server.terminate(), server.wait()))
        os.close(write)
        with os.fdopen(read) as number:
            ready, _, _ = select.select([number], [], [], 30)
            self.assertTrue(ready, "Xvfb did not start")
            self.env = unseen() | {"DISPLAY": ":" + number.readline().strip()}

    def test_a_script_does_the_same_on_a_screen(self):
        pull = drag(0.1, 0.6, LAST, 30, -30)
        got = self.play(pull, env=self.env)
        self.assertEqual(got["display"], "x11")
        self.assertEqual(got["hash"], self.play(pull)["hash"])

    @unittest.skipUnless(shutil.which("xdotool"), "xdotool is not installed")
    def test_a_real_mouse_drags_and_a_real_key_ends_it(self):
        def xdo(*words):
            done = subprocess.run(["xdotool", *words], env=self.env, capture_output=True, text=True,
                                  timeout=60)
            self.assertEqual(done.returncode, 0, done.stderr)
            return done.stdout

        words = [PANTIN, "view", self.scene, "--json", "--size", "%dx%d" % SIZE]
        run = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=self.env,
                               cwd=self.folder)
        self.addCleanup(lambda: (run.kill(), run.wait(), run.stdout.close()))
        window = xdo("search", "--sync", "--name", "Hanging chain").split()[0]
        time.sleep(1)
        place = dict(line.split("=") for line in
                     xdo("getwindowgeometry", "--shell", window).split())
        x, y = int(place["X"]) + SIZE[0] // 2, int(place["Y"]) + SIZE[1] // 2
        xdo("mousemove", str(x), str(y), "mousedown", "1")
        for i in range(1, 6):
            xdo("mousemove", str(x + 6 * i), str(y - i))
            time.sleep(0.1)
        time.sleep(0.5)
        xdo("mouseup", "1")
        time.sleep(0.3)
        xdo("key", "--window", window, "q")
        out, _ = run.communicate(timeout=30)
        self.assertEqual(run.returncode, 0)
        (pick,) = json.loads(out)["picks"]
        self.assertEqual(pick["grip"], "exact")
        self.assertLess(abs(pick["distance_moved_m"] - metres(math.hypot(30, 5))), 0.02)
        self.assertLess(pick["residual_m"], 1e-9)


def missing():
    """Why nothing can be shown here, or None."""
    with tempfile.TemporaryDirectory() as folder:
        script = pathlib.Path(folder) / "events.json"
        script.write_text('[{"t": 0, "type": "quit"}]')
        done = subprocess.run([PANTIN, "view", SCENES / "chain.json", "--script", script],
                              capture_output=True, text=True, env=unseen(), cwd=folder, timeout=120)
    lacks = done.returncode == 1 and ("this build" in done.stderr or "OpenGL" in done.stderr)
    return done.stderr if lacks else None


def run_all():
    """Every test of the module that is run; ends with 77 where nothing can be shown."""
    reason = missing()
    if reason:
        print(reason + "0 passed, 0 failed")
        sys.exit(77)
    result = unittest.main(exit=False).result
    bad = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - bad - len(result.skipped)} passed, {bad} failed")
    sys.exit(bad > 0)


if __name__ == "__main__":
    run_all()
