#!/usr/bin/env python3
"""Every shipped scene fits the JSON Schema, and the schema refuses what it should refuse."""
import copy
import json
import pathlib
import sys
import unittest

try:
    import jsonschema
except ImportError:
    print("python3-jsonschema is not installed")
    sys.exit(77)

ASSETS = pathlib.Path(__file__).resolve().parents[2] / "assets"
SCHEMA = json.loads((ASSETS / "schema" / "scene.schema.json").read_text())
CHECK = jsonschema.Draft202012Validator(SCHEMA)
SCENES = sorted((ASSETS / "scenes").glob("*.json")) + sorted((ASSETS / "prefabs").glob("*.json"))


class Schema(unittest.TestCase):
    def test_is_a_schema(self):
        jsonschema.Draft202012Validator.check_schema(SCHEMA)

    def test_describes_every_key(self):
        for name, kind in SCHEMA["$defs"].items():
            for key, value in kind.get("properties", {}).items():
                with self.subTest(f"{name}.{key}"):
                    self.assertGreater(len(value.get("description", "")), 4)

    def test_names_the_kinds_of_shapes_and_events(self):
        for what in ("shape", "event"):
            types = SCHEMA["$defs"][what]["properties"]["type"]["enum"]
            self.assertIn({"shape": "capsule", "event": "winch"}[what], types)
            suffix = "" if what == "shape" else "_event"
            for name in types:
                self.assertIn(name + suffix, SCHEMA["$defs"])

    def test_examples_are_examples(self):
        seen = 0
        for name, kind in SCHEMA["$defs"].items():
            check = CHECK.evolve(schema={**SCHEMA, "$ref": f"#/$defs/{name}"})
            for example in kind.get("examples", []):
                seen += 1
                with self.subTest(name):
                    self.assertEqual([f.message for f in check.iter_errors(example)], [])
        self.assertGreater(seen, 20)
        self.assertTrue(SCHEMA["$id"])

    def test_shipped_scenes_fit(self):
        self.assertGreaterEqual(len(SCENES), 12)
        for scene in SCENES:
            with self.subTest(scene.name):
                faults = CHECK.iter_errors(json.loads(scene.read_text()))
                self.assertEqual([f.message for f in faults], [])

    def test_takes_what_the_loader_takes(self):
        joint = {"a": "world", "b": "rod", "anchor": [0, 0, 0]}
        cube = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        for way in [
            ("joints", [{**joint, "kind": "hinge", "axis": [0, 0, 1], "rest_deg": 20,
                         "limits": {"angle_deg": [0, 90], "soft": {"zone": 0.1, "damping": 1}}}]),
            ("joints", [{**joint, "kind": "universal", "axis_a": [0, 1, 0], "across_a": [0, 0, 1],
                         "rest": [0.1, 0.2], "limits": {"first": [-1, 1], "second": [-1, 1]}}]),
            ("joints", [{**joint, "limits": {"twist": [0, 1], "swing_deg": [20, 30]},
                         "drive": {"stiffness": 1, "target": [0, 0, 0, 1], "max_torque": 2}}]),
            ("joints", [{**joint, "kind": "hinge", "drive": {"damping": 1, "loop": True, "keys": [
                {"time": 0, "angle": 1}, {"time": 1, "target": 1}]}}]),
            ("joints", [{**joint, "kind": "screw", "pitch": 0.1, "limits": {
                "travel": [0, 1], "restitution": 0.5}, "motor": {"velocity_deg": 90, "gain": 1}},
                        {**joint, "kind": "prismatic", "spring": {"damping": 1, "rest": 2},
                         "friction": {"dry": 1, "slip": 0.1}},
                        {**joint, "kind": "cylindrical", "angle": {"friction": {"viscous": 1}},
                         "travel": {"motor": {"position": 1, "gain": 1, "damping": 1, "cap": 2}}},
                        {"a": "world", "b": "rod", "kind": "distance", "point_a": [0, 1, 0]},
                        {"a": "world", "b": "rod", "kind": "spring", "anchor_b": [0, 1, 0],
                         "stiffness": 3, "damping": 0.1, "length": 0}]),
            ("gears", [{"first": "i", "second": "j", "ratio": -2, "offset_deg": 10},
                        {"name": "r", "first": "i", "first_coordinate": "angle", "second": "j",
                         "second_coordinate": "travel", "ratio": 0.1, "offset": 1}]),
            ("solver", {"type": "lagrangian", "integrator": "rattle", "baumgarte": 1,
                        "stabilisation": "none", "jacobians": "differences",
                        "step_tolerance": 1e-6, "damping_ratio": 1}),
            ("collision", {"friction": 1, "groups": ["a", 3], "with": [0], "self": True}),
            ("collision_groups", ["a", "b"]),
            ("bodies", [{"name": "a", "shape": {"type": "hull", "points": cube}, "collision": True},
                        {"name": "b", "motion": "fixed", "shapes": [
                            {"type": "plane", "size": 4}, {"type": "mesh", "file": "a.obj"},
                            {"type": "mesh", "points": cube, "triangles": [[0, 1, 2]]},
                            {"type": "height_field", "columns": 2, "rows": 2, "spacing": [1, 2],
                             "heights": [0, 0, 0, 1]}]}]),
            ("pins", [{"body": "a", "to": "b", "anchor_to": [0, 0, 0]}]),
            ("classes", [{"name": "c", "class": "b", "joint": {"kind": "screw", "pitch": 1},
                          "body": {"drag": 1}, "cable": {"slack": 2}, "pin": {"priority": 1}}]),
            ("joints", [{"a": "world", "b": "rod", "class": "c", "motor": {"gain": 1, "velocity": 1}}]),
            ("bodies", [{"name": "a", "parent": "b", "shape": {
                "type": "capsule", "radius": 1, "from": [0, 0, 0], "to": [0, 1, 0]}}]),
            ("prefabs", [{"name": "a", "file": "a.json"}, {"name": "b", "events": []}]),
            ("instances", [{"name": "i", "prefab": "a", "mirror": "y", "parent": "b"}]),
            ("events", [{"type": "push", "body": "a", "torque": [1, 0, 0], "to": 1, "every": 2},
                        {"type": "cut", "gear": "g", "at": 1},
                        {"type": "drive", "joint": "j", "max_torque": 0, "at": 1, "over": 2},
                        {"type": "winch", "cable": "c", "length": 1, "at": 0}]),
            ("generators", {"stairs": [{"name": "s", "count": 2, "width": 1, "rise": 1, "run": 1}],
                            "chains": [{"name": "c", "path": cube, "closed": True, "kind": "hinge",
                                        "axis": [0, 0, 1]}]}),
        ]:
            with self.subTest(way):
                faults = CHECK.iter_errors({"version": 1, way[0]: way[1]})
                self.assertEqual([f.message for f in faults], [])

    def test_refuses_faults(self):
        base = json.loads((ASSETS / "scenes" / "pendulum.json").read_text())
        for way in [
            ("version", 2),
            ("colour", "red"),
            ("step", 0),
            ("bodies", 0, "mass", -1),
            ("bodies", 0, "density", 5),
            ("bodies", 0, "name", "world"),
            ("bodies", 0, "name", "a/b"),
            ("bodies", 0, "rotation", [0, 0, 0, 1]),
            ("bodies", 0, "inertia", [1, 2]),
            ("bodies", 0, "shape", "radius", 0),
            ("bodies", 0, "shape", "size", [1, 1, 1]),
            ("joints", 0, "type", "hinge"),
            ("joints", 0, "anchor", [0, 0, 0]),
            ("joints", 0, "kind", "hinj"),
            ("joints", 0, "limits", {"cone": 1, "swing": [1, 1]}),
            ("joints", 0, "limits", {"soft": {"stiffness": 1}}),
            ("joints", 0, "kind", "custom"),
            ("joints", 0, "kind", "screw"),
            ("joints", 0, {"a": "world", "b": "rod", "kind": "distance", "anchor": [0, 0, 0]}),
            ("joints", 0, "kind", "spring"),
            ("joints", 0, "pitch", 1),
            ("joints", 0, "length", 1),
            ("joints", 0, "motor", {"velocity": 1, "gain": 1}),
            ("joints", 0, "limits", {"restitution": 1.1}),
            ("gears", [{"first": "i", "second": "j", "ratio": 0}]),
            ("gears", [{"first": "i", "second": "j"}]),
            ("solver", {"integrator": "rk5"}),
            ("solver", {"step_tolerance": 0}),
            ("joints", 0, "drive", {}),
            ("joints", 0, "drive", {"stiffness": -1}),
            ("joints", 0, "drive", {"stiffness": 1, "loop": True}),
            ("joints", 0, "drive", {"stiffness": 1, "keys": [{"time": 0}]}),
            ("bodies", 0, "collision", {"restitution": 2}),
            ("bodies", 0, "collision", {"groups": [32]}),
            ("bodies", 0, "shape", {"type": "hull"}),
            ("bodies", 0, "shape", {"type": "plane", "density": 1}),
            ("bodies", 0, "shape", {"type": "mesh", "points": []}),
            ("bodies", 0, "shape", {"type": "height_field", "columns": 1}),
            ("pins", [{"body": "rod", "anchor_to": [0, 0, 0]}]),
            ("generators", {"chains": [{"name": "c", "links": 3, "path": []}]}),
            ("generators", {"stairs": [{"name": "s", "count": 0}]}),
            ("collision_groups", ["a", "a"]),
            ("solver", {"sweeps": 0}),
            ("solver", {"sleep_speed": -0.001}),
            ("paths", [{"body": "rod"}]),
            ("classes", [{"body": {}}]),
            ("classes", [{"name": "c", "body": {"name": "a"}}]),
            ("defaults", {"body": {"drag": -1}}),
            ("bodies", 0, "shape", "from", [0, 0, 0]),
            ("bodies", 0, "shape", {"type": "capsule", "radius": 1, "from": [0, 0, 0]}),
            ("bodies", 0, "shape", {"type": "capsule", "radius": 1}),
            ("prefabs", [{"name": "a", "file": "a.json", "bodies": []}]),
            ("generators", {"mirrors": [{"axis": "x"}]}),
            ("instances", [{"name": "i", "prefab": "a", "mirror": "w"}]),
            ("events", [{"type": "blow"}]),
            ("events", [{"body": "rod", "force": [1, 0, 0]}]),
            ("events", [{"type": "push", "body": "rod"}]),
            ("events", [{"type": "push", "body": "rod", "force": [1, 0, 0], "every": 2}]),
            ("events", [{"type": "push", "body": "rod", "force": [1, 0, 0], "from": -1}]),
            ("events", [{"type": "cut", "at": 1}]),
            ("events", [{"type": "cut", "joint": "j", "pin": "p", "at": 1}]),
            ("events", [{"type": "gravity", "at": 1}]),
            ("paths", [{"body": "rod", "lissajous": {}, "loop": True}]),
        ]:
            scene = copy.deepcopy(base)
            *path, key, value = way
            place = scene
            for step in path:
                place = place[step]
            place[key] = value
            with self.subTest(way):
                self.assertFalse(CHECK.is_valid(scene))


if __name__ == "__main__":
    unittest.main()
