"""Scene files in mm: every shipped scene, converted by the units that the schema states, is the same scene.

Needs PANTIN and PANTIN_ASSETS.
"""
import copy
import csv
import io
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]
ASSETS = pathlib.Path(os.environ["PANTIN_ASSETS"])
SCHEMA = json.loads((ASSETS / "schema" / "scene.schema.json").read_text())["$defs"]
TYPED = {"shape": "", "event": "_event", "face": "_face", "curve": "_curve"}
# Along a travel: what the same keys are in.
TRAVEL = {"stiffness": -1, "damping": -1, "viscous": -1, "dry": 0, "slip": 1, "rest": 1, "gain": -1,
          "cap": 0, "velocity": 1, "position": 1}
ANGLE = {"stiffness": 1, "damping": 1, "viscous": 1, "dry": 1, "gain": 1, "cap": 1}
OLD = {"strings": "cables", "drives": "paths", "ratios": "gears"}


def exponent(text):
    """The power of m in the unit at the end of a description."""
    unit = re.search(r"(?:In|in) ((?:(?!\. )[^,])*?)\.?$", text)
    if not unit or "kg/m^3" in unit[1]:
        return 0
    power, sign = 0, 1
    for part in re.findall(r"/|[A-Za-z]+(?:\^\d)?", unit[1].split(" or ")[0]):
        if part == "/":
            sign = -1
        elif part.split("^")[0] == "m":
            power += sign * int(part.partition("^")[2] or 1)
    return power


def scaled(value, factor):
    if isinstance(value, list):
        return [scaled(item, factor) for item in value]
    return value * factor if isinstance(value, (int, float)) and not isinstance(value, bool) else value


class Converter:
    """A scene in m as one in mm."""

    def __init__(self, scene):
        self.scene = copy.deepcopy(scene)
        self.kinds = {}

    def converted(self):
        whole = self.object("scene", self.scene)
        return {"version": 1, "units": "mm"} | whole

    def kind_of(self, joint):
        for holder in (joint, *self.classes_of(joint)):
            if "kind" in holder:
                return holder["kind"]
        return "ball"

    def classes_of(self, joint):
        by_name = {c["name"]: c for c in self.scene.get("classes", [])}
        name = joint.get("class")
        while name in by_name:
            yield by_name[name].get("joint", {})
            name = by_name[name].get("class")
        yield self.scene.get("defaults", {}).get("joint", {})

    def laws(self, law, along):
        powers = TRAVEL if along == "travel" else ANGLE
        return {key: scaled(value, 1000 ** powers.get(key, 0)) for key, value in law.items()}

    def object(self, what, value, along="angle"):
        if not isinstance(value, dict):
            return value
        if what in TYPED:
            what = value["type"] + TYPED[what]
        if what in ("spring", "friction", "motor"):
            return self.laws(value, along)
        if what == "drive_motion":
            return self.motion(value, along)
        properties, out = SCHEMA[what]["properties"], {}
        if what in ("joint", "joint_class", "chain") and self.kind_of(value) == "prismatic":
            along = "travel"
        if what == "motor_event":
            along = self.motor_of(value["joint"])
            return self.laws(value, along) | {k: value[k] for k in value if k not in TRAVEL}
        for key, inner in value.items():
            if key in ("homogeneous", "waypoints"):
                raise unittest.SkipTest(key)
            if key == "trims" or key == "max_torque" and along == "travel":
                out[key] = inner  # of parameters; N
                continue
            kind = re.search(r'"#/\$defs/(\w+)"', json.dumps(properties[key]))
            to = kind[1] if kind and kind[1] not in ("vector", "name") else None
            if what == "gear" and key in ("ratio", "offset"):
                out[key] = self.gear(value, key)
            elif to and isinstance(inner, list):
                out[key] = [self.object(to, item, along) for item in inner]
            elif to and isinstance(inner, dict):
                dof = {"angle": "angle", "travel": "travel"}.get(key, along) if to == "dof" else along
                out[key] = self.object(to, inner, dof)
            else:
                out[key] = scaled(inner, 1000 ** exponent(properties[key].get("description", "")))
        return out

    @staticmethod
    def motion(value, along):
        out = dict(value)
        if value.get("along", along) == "travel":
            for key in {"offset", "speed", "amplitude"} & value.keys():
                out[key] = 1000 * value[key]
            if "table" in value:
                out["table"] = [[time, 1000 * at] for time, at in value["table"]]
        return out

    def motor_of(self, name):
        (joint,) = [j for j in self.scene.get("joints", []) if j.get("name") == name] or [{}]
        return "travel" if self.kind_of(joint) == "prismatic" else "angle"

    def gear(self, gear, key):
        travels = {side: gear.get(side + "_coordinate",
                                  self.motor_of(gear[side])) == "travel" for side in ("first", "second")}
        factor = 1000.0 if travels["second"] else 1.0
        return gear[key] * (factor / (1000.0 if travels["first"] and key == "ratio" else 1.0))


class Units(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)

    def rows(self, scene, name, *words):
        path = self.folder / name
        path.write_text(json.dumps(scene))
        done = subprocess.run([PANTIN, "run", path, "--record", "-", *words], capture_output=True,
                              text=True, timeout=300)
        self.assertEqual(done.returncode, 0, f"{name}: {done.stderr}")
        return list(csv.reader(io.StringIO(done.stdout)))

    def check_same(self, scene, name, steps=3):
        words = ("--duration", str(steps * scene.get("step", 1 / 60)))
        ours, theirs = (self.rows(s, name, *words) for s in (scene, Converter(scene).converted()))
        self.assertEqual(ours[0], theirs[0])
        self.assertEqual(len(ours), len(theirs))
        for column in range(len(ours[0])):
            pairs = [(float(a[column]), float(b[column])) for a, b in zip(ours[1:], theirs[1:])
                     if a[column] and b[column]]
            size = max([abs(a) for a, _ in pairs] + [1])
            worst = max([abs(a - b) for a, b in pairs] + [0])
            self.assertLess(worst, 1e-6 * size, f"{name}: {ours[0][column]}")

    def test_shipped_scenes_are_the_same_in_mm(self):
        compared = 0
        for path in sorted((ASSETS / "scenes").glob("*.json")):
            scene = json.loads(path.read_text())
            text = json.dumps(scene)
            if '"file"' in text or '"surface": "../' in text or len(text) > 150_000:
                continue
            with self.subTest(path.name):
                try:
                    self.check_same(scene, path.name)
                    compared += 1
                except unittest.SkipTest:
                    pass
        self.assertGreater(compared, 60)

    def test_laws_along_rotations_and_translations(self):
        body = {"shape": {"type": "box", "size": [0.1, 0.2, 0.3]}}
        law = {"spring": {"stiffness": 3, "damping": 0.2, "rest": 0.01},
               "friction": {"viscous": 0.3, "dry": 0.1, "slip": 0.02},
               "motor": {"velocity": 0.4, "gain": 5, "cap": 2}}
        scene = {"version": 1, "step": 0.002, "solver": {"type": "lagrangian"},
                 "bodies": [body | {"name": n, "position": [i, 0, 0]}
                            for i, n in enumerate("abcdefgh")],
                 "joints": [
                     {"name": "turn", "kind": "hinge", "a": "world", "b": "a", "anchor": [0, 0.1, 0],
                      "axis": [0, 0, 1], **law},
                     {"name": "slide", "kind": "prismatic", "a": "world", "b": "b",
                      "anchor": [1, 0, 0], **law, "limits": {"travel": [-0.001, 0.02]}},
                     {"name": "both", "kind": "cylindrical", "a": "world", "b": "c",
                      "anchor": [2, 0, 0], "angle": law, "travel": law},
                     {"name": "screw", "kind": "screw", "a": "world", "b": "d", "anchor": [3, 0, 0],
                      "pitch": 0.02},
                     {"kind": "spring", "a": "world", "b": "e", "point_a": [4, 1, 0],
                      "stiffness": 40, "damping": 3, "length": 0.7},
                     {"kind": "distance", "a": "world", "b": "f", "point_a": [5.2, 0.3, 0]},
                     {"name": "rack", "kind": "prismatic", "a": "world", "b": "g",
                      "anchor": [6, 0, 0], "motor": {"position": 0.1, "gain": 9, "damping": 1}},
                     {"name": "wheel", "kind": "hinge", "a": "world", "b": "h", "anchor": [7, 0, 0]}],
                 "gears": [{"first": "wheel", "second": "rack", "ratio": 0.1, "offset": 0.002}],
                 "events": [
                     {"type": "motor", "joint": "slide", "velocity": -0.3, "gain": 7, "at": 0.01},
                     {"type": "motor", "joint": "turn", "position": 0.5, "gain": 3, "damping": 0.1,
                      "cap": 1, "at": 0.01},
                     {"type": "push", "body": "e", "force": [1, 2, 3], "torque": [0.1, 0, 0.2],
                      "anchor": [0.01, 0, 0], "from": 0, "to": 0.01},
                     {"type": "impulse", "body": "f", "impulse": [0, 0, 0.1],
                      "angular_impulse": [0.01, 0, 0], "at": 0.02}]}
        self.check_same(scene, "laws.json", 40)

    def test_a_point_mass_by_inertia_and_a_file_of_points_in_mm(self):
        (self.folder / "cube.obj").write_text("".join(
            f"v {x} {y} {z}\n" for x in (-50, 50) for y in (-50, 50) for z in (-50, 50)))
        scene = {"version": 1, "units": "mm", "bodies": [
            {"name": "a", "shape": {"type": "hull", "file": "cube.obj"}},
            {"name": "b", "mass": 2, "inertia": [3000, 4000, 5000], "angular_velocity": [1, 2, 3]}]}
        same = {"version": 1, "bodies": [
            {"name": "a", "shape": {"type": "box", "size": [0.1, 0.1, 0.1]}},
            {"name": "b", "mass": 2, "inertia": [0.003, 0.004, 0.005], "angular_velocity": [1, 2, 3]}]}
        for ours, theirs in zip(self.rows(scene, "a.json")[1:], self.rows(same, "b.json")[1:]):
            for x, y in zip(ours, theirs):
                self.assertAlmostEqual(float(x or 0), float(y or 0), delta=1e-9 * max(1, abs(float(y or 0))))

    def test_unknown_units_are_refused_and_poses_are_written_in_those_of_the_file(self):
        path = self.folder / "a.json"
        path.write_text('{"version": 1, "units": "inch"}')
        done = subprocess.run([PANTIN, "check", path], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        self.assertIn('found "inch"', done.stderr + done.stdout)
        path.write_text(json.dumps({
            "version": 1, "units": "mm", "bodies": [
                {"name": "a", "shape": {"type": "sphere", "radius": 100}, "position": [500, 0, 0]}],
            "joints": [{"a": "world", "b": "a", "anchor_a": [0, 0, 0], "anchor_b": [-300, 0, 0]}]}))
        done = subprocess.run([PANTIN, "assemble", path, "--out", self.folder / "b.json"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        (pose,) = json.loads((self.folder / "b.json").read_text())["poses"]
        self.assertAlmostEqual(pose["position"][0], 300, delta=1e-6)


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
