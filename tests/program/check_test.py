"""What `pantin check` asks of joints and says of freedoms."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]


def pulley(name, x, y):
    return {"name": name, "position": [x, y, 0], "mass": 1, "inertia": [0.01, 0.01, 0.02]}


def hinge(a, b, at, axis=(0, 0, 1), **more):
    return {"kind": "hinge", "a": a, "b": b, "anchor": list(at), "axis": list(axis), **more}


class Check(unittest.TestCase):
    def check(self, scene):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "scene.json"
            path.write_text(json.dumps({"version": 1, **scene}))
            done = subprocess.run([PANTIN, "check", "--json", str(path)], text=True, timeout=120,
                                  stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE)
        return done.returncode, json.loads(done.stdout)["scenes"][0]

    def test_plain_loops_are_held_to_what_loops_promise(self):
        balls = [{"a": a, "b": b, "anchor": at} for a, b, at in (
            ("world", "crank", [0, 0, 0]), ("crank", "coupler", [0, 0.3, 0]),
            ("coupler", "rocker", [0.8, 0.5, 0]), ("rocker", "world", [0.7, 0, 0]))]
        bodies = [{"name": name, "position": at, "shape": {"type": "sphere", "radius": 0.04}}
                  for name, at in (("crank", [0, 0.15, 0]), ("coupler", [0.4, 0.4, 0]),
                                   ("rocker", [0.75, 0.25, 0]))]
        code, told = self.check({"bodies": bodies, "joints": balls})
        self.assertEqual((code, told["status"]), (0, "ok"), told)
        self.assertLess(told["worst_gap_rel"], 1e-5)
        code, told = self.check({"bodies": bodies, "joints": balls, "drift_bound": 1e-16})
        self.assertEqual((code, told["status"]), (3, "failed"), told)

    def test_wheels_on_one_axle_are_named(self):
        def wheel(body, z, radius=0.2):
            return {"name": f"{body} rolls", "kind": "wheel", "a": "world", "b": body,
                    "anchor": [0, 0.2, z], "axis": [0, 0, 1], "across": [0, 1, 0],
                    "radius": radius}

        def body(name, z, mass=1):
            return {"name": name, "position": [0, 0.2, z], "mass": mass, "drag": 0,
                    "inertia": [0.02, 0.02, 0.03], "collision": False}

        def warnings(bodies, joints, integrator="rk4"):
            code, told = self.check({"bodies": bodies, "joints": joints, "step": 0.005,
                                     "solver": {"type": "lagrangian", "integrator": integrator}})
            self.assertEqual((code, told["status"]), (0, "ok"), told)
            return told["warnings"]

        level = {"kind": "planar", "a": "world", "b": "frame", "anchor": [0, 0.2, 0],
                 "axis": [0, 1, 0]}
        bodies = [body("frame", 0, 4), body("left", -0.3), body("right", 0.3)]

        def axles(second="hinge", z=0.3, x=0):
            return [level, hinge("frame", "left", [0, 0.2, -0.3]),
                    {**hinge("frame", "right", [x, 0.2, z]), "kind": second},
                    wheel("left", -0.3), {**wheel("right", z), "anchor": [x, 0.2, z]}]

        for integrator in ("rk4", "rattle"):
            told = warnings(bodies, axles(), integrator)
            self.assertEqual(len(told), 1, told)
            for words in ("left rolls and right rolls are on one axle", integrator, "cylindrical",
                          "radau"):
                self.assertIn(words, told[0])
        self.assertEqual(warnings(bodies, axles(), "radau"), [])
        self.assertEqual(warnings(bodies, axles("cylindrical")), [])
        ahead = [*bodies[:2], {**bodies[2], "position": [0.5, 0.2, 0.3]}]
        self.assertEqual(warnings(ahead, axles(x=0.5)), [])
        # Both rigidly on one body, which rolls straight on.
        told = warnings([body("axle", 0)],
                        [wheel("axle", -0.3), {**wheel("axle", 0.3), "name": "other"}])
        self.assertEqual(len(told), 1, told)

    def test_a_comment_key_is_refused_with_the_place_for_comments(self):
        for key in ("comment", "_comment", "//"):
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder) / "scene.json"
                path.write_text(json.dumps({"version": 1, key: "mine"}))
                done = subprocess.run([PANTIN, "check", path], capture_output=True, text=True)
                self.assertEqual(done.returncode, 2)
                self.assertIn("after // in a file named .json5", done.stderr)

    def test_belts_take_freedoms(self):
        places = {"a": (0, 0), "b": (1, 0), "c": (0.5, 0.8)}
        scene = {"gravity": [0, 0, 0],
                 "bodies": [pulley(name, *at) for name, at in places.items()],
                 "joints": [hinge("world", name, [*at, 0]) for name, at in places.items()],
                 "belts": [{"pulleys": [{"body": name, "radius": 0.1} for name in ("a", "b", "c")]}]}
        for solver in ("planar", "lagrangian"):
            code, told = self.check({**scene, "solver": {"type": solver}})
            self.assertEqual((code, told["freedoms"]), (0, 1), (solver, told))
            scene_without = {**scene, "belts": []}
            self.assertEqual(self.check({**scene_without, "solver": {"type": solver}})[1]["freedoms"], 3)

    def test_a_motor_on_a_linkage_that_an_askew_axis_locks_is_warned_of(self):
        for askew in (0, 0.05):
            motor = {"motor": {"velocity": 1, "gain": 1}}
            scene = {"solver": {"type": "lagrangian"}, "bodies": [
                pulley("crank", 0, 0.15), pulley("coupler", 0.4, 0.4), pulley("rocker", 0.75, 0.25)],
                "joints": [hinge("world", "crank", [0, 0, 0], **motor),
                           hinge("crank", "coupler", [0, 0.3, 0], (askew, 0, 1)),
                           hinge("coupler", "rocker", [0.8, 0.5, 0]),
                           hinge("rocker", "world", [0.7, 0, 0])]}
            told = self.check(scene)[1]
            self.assertEqual(told["freedoms"], 0 if askew else 1, told)
            warned = any("no degree of freedom" in line for line in told["warnings"])
            self.assertEqual(warned, askew > 0)


if __name__ == "__main__":
    unittest.main()
