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
SCENES = sorted((ASSETS / "scenes").glob("*.json"))


class Schema(unittest.TestCase):
    def test_is_a_schema(self):
        jsonschema.Draft202012Validator.check_schema(SCHEMA)

    def test_describes_every_key(self):
        for name, kind in SCHEMA["$defs"].items():
            for key, value in kind.get("properties", {}).items():
                with self.subTest(f"{name}.{key}"):
                    said = value.get("$ref") or "const" in value or value.get("description")
                    self.assertTrue(said)

    def test_shipped_scenes_fit(self):
        self.assertGreaterEqual(len(SCENES), 12)
        for scene in SCENES:
            with self.subTest(scene.name):
                faults = CHECK.iter_errors(json.loads(scene.read_text()))
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
            ("drives", [{"body": "rod"}]),
            ("drives", [{"body": "rod", "lissajous": {}, "loop": True}]),
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
