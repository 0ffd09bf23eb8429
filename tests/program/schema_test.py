"""pantin schema, and whether it says the same of scenes as the loader does."""
import copy
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

try:
    import jsonschema
except ImportError:
    print("python3-jsonschema is not installed")
    sys.exit(77)

PANTIN = os.environ["PANTIN"]
ASSETS = pathlib.Path(os.environ["PANTIN_ASSETS"])
# What a schema can say too; the loader refuses more, such as names that nothing has.
REFUSED_BY_BOTH = re.compile(
    'found key "|expected (a number|a whole number|text|true or false|an array|an object|a size|'
    'an angle|a time|a direction|1, the version)')


def pantin(*arguments):
    return subprocess.run([PANTIN, *map(str, arguments)], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=500)


def objects_in(value, path=()):
    """Every object of a scene with the way to it, the first of each kind of place only."""
    if isinstance(value, dict):
        yield path, value
        for key, inner in value.items():
            yield from objects_in(inner, path + (key,))
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from objects_in(inner, path + (i,))


def kinds_of_places(scene):
    """The objects of a scene, one for each kind of place and set of keys."""
    seen = set()
    for path, value in objects_in(scene):
        kind = (tuple(p for p in path if isinstance(p, str)), tuple(sorted(value)),
                str(value.get("kind")), str(value.get("type")))
        if kind not in seen:
            seen.add(kind)
            yield path, value


def changed(scene, path, change):
    other = copy.deepcopy(scene)
    place = other
    for step in path:
        place = place[step]
    change(place)
    return other


def mutants(scene):
    """Scenes that differ from this one by one member."""
    for path, value in kinds_of_places(scene):
        yield changed(scene, path, lambda o: o.update(frobnicate=1))
        for key, old in value.items():
            yield changed(scene, path, lambda o, k=key: o.pop(k))
            for other in (None, True, -3.5e12, "", [], {}, [old], "frobnicate"):
                yield changed(scene, path, lambda o, k=key, v=other: o.update({k: v}))


# One of each type that a slider-crank can have.
EVENTS = [
    {"type": "push", "body": "crank", "force": [1, 0, 0], "torque": [0, 0, 1], "anchor": [0, 0, 0],
     "from": 1, "to": 2, "every": 3},
    {"type": "impulse", "body": "piston", "impulse": [1, 0, 0], "point": [0, 0, 0], "at": 1},
    {"type": "wind", "velocity": [1, 0, 0], "gusts": 2, "gust_time": 0.5, "seed": 3, "drag": 0.1,
     "bodies": ["crank"]},
    {"type": "pull", "body": "piston", "target": [0, 0, 0], "from": 1, "to": 2, "over": 1},
    {"type": "motor", "joint": "shaft", "velocity": 1, "gain": 1, "cap": 2, "at": 1, "over": 1},
    {"type": "gravity", "gravity": [0, 0, 0], "at": 1, "over": 1},
    {"type": "solver", "solver": "lagrangian", "at": 1},
]


class Schema(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        done = pantin("schema")
        assert done.returncode == 0, done.stderr
        cls.text = done.stdout
        cls.check = jsonschema.Draft202012Validator(json.loads(cls.text))

    def test_is_a_schema_and_the_shipped_one(self):
        jsonschema.Draft202012Validator.check_schema(self.check.schema)
        self.assertEqual(self.text, (ASSETS / "schema" / "scene.schema.json").read_text())

    def test_is_written_to_a_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "s.json"
            done = pantin("schema", "--out", path)
            self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
            self.assertEqual(path.read_text(), self.text)
            done = pantin("schema", "--out", path / "in" / "it")
            self.assertEqual((done.returncode, len(done.stderr.splitlines())), (4, 1))

    def test_old_names_are_deprecated(self):
        for old, scene in {
                "strings": {"strings": []}, "drives": {"drives": []}, "ratios": {"ratios": []},
                "rounds": {"solver": {"rounds": 3}}, "passes": {"solver": {"passes": 3}}}.items():
            with self.subTest(old):
                scene["version"] = 1
                self.assertEqual([f.message for f in self.check.iter_errors(scene)], [])
                defs = self.check.schema["$defs"]
                holder = defs["solver" if "solver" in scene else "scene"]
                self.assertTrue(holder["properties"][old]["deprecated"])
                self.assertTrue(holder["properties"][old]["doNotSuggest"])  # while one types

    def test_old_words_are_deprecated(self):
        for holder, key, old, new in (("solver", "type", "paper", "procedural"),
                                      ("body", "motion", "driven", "kinematic")):
            with self.subTest(old):
                value = self.check.schema["$defs"][holder]["properties"][key]
                today, deprecated = value["anyOf"]
                self.assertIn(new, today["enum"])
                self.assertEqual(deprecated, {"enum": [old], "deprecated": True})

    def test_agrees_with_the_loader_about_scenes_that_differ_by_one_member(self):
        names = ["drape", "cut", "gate", "slider_crank", "four_bar", "spinning_top",
                 "chain"]
        scenes = []
        for name in names:
            scene = json.loads((ASSETS / "scenes" / f"{name}.json").read_text())
            scene["step"], scene["substeps"] = 1e-4, 1
            if name == "slider_crank":
                scene["events"] = EVENTS
            scenes.append(scene)
        with tempfile.TemporaryDirectory() as folder:
            paths = {}
            for scene in scenes:
                for mutant in mutants(scene):
                    path = pathlib.Path(folder) / f"{len(paths)}.json"
                    path.write_text(json.dumps(mutant))
                    paths[path] = mutant
            self.assertGreater(len(paths), 3000)
            self.compare(paths)

    def compare(self, paths):
        done = pantin("check", "--json", *paths)
        is_refused = {s["scene"]: s["status"] == "refused"
                      for s in json.loads(done.stdout)["scenes"]}
        complaints = {}
        for line in done.stderr.splitlines():
            complaints.setdefault(line.split(".json:")[0] + ".json", []).append(line)
        wrong = []
        for path, scene in paths.items():
            fits = self.check.is_valid(scene)
            if fits and is_refused[str(path)]:
                wrong += [line[:300] for line in complaints[str(path)]
                          if REFUSED_BY_BOTH.search(line)]
            elif not fits and not is_refused[str(path)]:
                fault = jsonschema.exceptions.best_match(self.check.iter_errors(scene))
                wrong.append(f"taken by the loader: {fault.json_path} {fault.message}"[:300])
        self.assertEqual(wrong, [])


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
