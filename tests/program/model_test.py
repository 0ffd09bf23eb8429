"""The glTF models that `pantin run --gltf` writes: a valid file whose nodes move as the record says.

Needs PANTIN and PANTIN_ASSETS. Ends with 77 where the build cannot draw.
"""
import csv
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]
SCENES = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes"
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


class Model:
    """A binary glTF file: its JSON, and its accessors as tuples of numbers."""

    def __init__(self, path):
        data = pathlib.Path(path).read_bytes()
        magic, version, length = struct.unpack_from("<4sII", data)
        assert (magic, version, length) == (b"glTF", 2, len(data))
        chunks, at = {}, 12
        while at < len(data):
            size, kind = struct.unpack_from("<I4s", data, at)
            assert size % 4 == 0
            chunks[kind] = data[at + 8:at + 8 + size]
            at += 8 + size
        self.json, self.bytes = json.loads(chunks[b"JSON"]), chunks[b"BIN\0"]
        assert self.json["buffers"] == [{"byteLength": len(self.bytes)}]

    def numbers(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        width, count = WIDTHS[accessor["type"]], accessor["count"]
        letter = {5126: "f", 5125: "I"}[accessor["componentType"]]
        assert view["byteOffset"] % 4 == 0 and view["byteLength"] == 4 * width * count
        flat = struct.unpack_from(f"<{width * count}{letter}", self.bytes, view["byteOffset"])
        rows = [flat[i:i + width] for i in range(0, len(flat), width)]
        if "min" in accessor:
            assert list(map(min, zip(*rows))) == accessor["min"]
            assert list(map(max, zip(*rows))) == accessor["max"]
        return rows

    def node(self, name):
        (index,) = [i for i, node in enumerate(self.json["nodes"]) if node["name"] == name]
        return index

    def channel(self, node, path):
        """Times and values of a property of a node; none if it does not change."""
        for animation in self.json.get("animations", []):
            for channel in animation["channels"]:
                if channel["target"] == {"node": node, "path": path}:
                    sampler = animation["samplers"][channel["sampler"]]
                    return ([t for t, in self.numbers(sampler["input"])],
                            self.numbers(sampler["output"]))
        return None

    def corners(self, node):
        """The positions of a node's mesh, in its frame, all triangles checked."""
        all_positions = []
        for part in self.json["meshes"][self.json["nodes"][node]["mesh"]]["primitives"]:
            positions = self.numbers(part["attributes"]["POSITION"])
            normals = self.numbers(part["attributes"]["NORMAL"])
            indices = [i for i, in self.numbers(part["indices"])]
            assert len(indices) % 3 == 0 and max(indices) < len(positions) == len(normals)
            assert all(abs(math.hypot(*n) - 1) < 1e-5 for n in normals)
            assert 0 <= part["material"] < len(self.json["materials"])
            all_positions += positions
        return all_positions


def rows_of(path):
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    return [dict(zip(header, map(float, row))) for row in rows]


class Models(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_scene(self, scene, *words, code=0):
        path = scene
        if isinstance(scene, dict):
            path = self.folder / "scene.json"
            path.write_text(json.dumps(scene))
        done = subprocess.run([PANTIN, "run", str(path), *words], capture_output=True, text=True,
                              cwd=self.folder, timeout=120)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr

    def test_nodes_move_as_the_record_says(self):
        self.run_scene(SCENES / "four_bar.json", "--duration", "1", "--step", "0.004", "--gltf",
                       "run.glb", "--record", "run.csv")
        model, rows = Model(self.folder / "run.glb"), rows_of(self.folder / "run.csv")
        moved = 0
        for name in {column[:-2] for column in rows[0] if column.endswith(".x")}:
            node = model.node(name)
            times, places = model.channel(node, "translation") or ([0], [
                model.json["nodes"][node]["translation"]])
            _, turns = model.channel(node, "rotation") or (0, [
                model.json["nodes"][node]["rotation"]])
            moved += len(places) > 1
            for i, time in enumerate(times):
                (row,) = [r for r in rows if abs(r["time_s"] - time) < 1e-6]
                for k, axis in enumerate("xyz"):
                    self.assertAlmostEqual(places[i][k], row[f"{name}.{axis}"], delta=1e-6)
                if len(turns) > 1:
                    along = sum(q * row[f"{name}.q{a}"] for q, a in zip(turns[i], "xyzw"))
                    self.assertAlmostEqual(abs(along), 1, delta=1e-6)
            for one, other in zip(turns, turns[1:]):  # what lies between is the short way round
                self.assertGreater(sum(p * q for p, q in zip(one, other)), 0)
            if len(times) > 1:
                self.assertGreaterEqual(min(b - a for a, b in zip(times, times[1:])), 1 / 60 - 1e-6)
                self.assertGreater(times[-1], 0.97)
        self.assertGreaterEqual(moved, 3)

    def test_meshes_have_the_sizes_of_the_shapes_in_the_frame_of_the_body(self):
        shapes = {"box": ({"type": "box", "size": [0.2, 0.4, 0.6]}, (0.1, 0.2, 0.3)),
                  "ball": ({"type": "sphere", "radius": 0.3}, (0.3, 0.3, 0.3)),
                  "rod": ({"type": "capsule", "radius": 0.1, "length": 0.4}, (0.1, 0.3, 0.1)),
                  "drum": ({"type": "cylinder", "radius": 0.2, "length": 0.6}, (0.2, 0.3, 0.2)),
                  "hull": ({"type": "hull", "points": [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0],
                                                       [0, 0, 1], [0, 0, -1]]}, (1, 1, 1))}
        offset = (1, 2, 3)
        bodies = [{"name": name, "shape": shape | {"position": offset}}
                  for name, (shape, _) in shapes.items()]
        self.run_scene({"version": 1, "gravity": [0, 0, 0], "duration": 0.1, "bodies": bodies},
                       "--gltf", "still.glb")
        model = Model(self.folder / "still.glb")
        for name, (_, half) in shapes.items():
            corners = model.corners(model.node(name))
            for k in range(3):
                low, high = min(c[k] for c in corners), max(c[k] for c in corners)
                self.assertAlmostEqual(low, offset[k] - half[k], delta=0.02 * half[k])
                self.assertAlmostEqual(high, offset[k] + half[k], delta=0.02 * half[k])
        self.assertNotIn("animations", model.json)  # nothing moves
        self.assertEqual(len({json.dumps(n["mesh"]) for n in model.json["nodes"]}), len(shapes))

    def test_equal_bodies_share_their_mesh_and_colours_are_those_of_materials(self):
        balls = [{"name": f"b{i}", "position": [i, 1, 0],
                  "shape": {"type": "sphere", "radius": 0.2, "material": "red"}} for i in range(9)]
        self.run_scene({"version": 1, "duration": 0.5, "bodies": balls,
                        "materials": [{"name": "red", "colour": "#ff0000"}]}, "--gltf", "balls.glb")
        model = Model(self.folder / "balls.glb")
        self.assertEqual(len(model.json["meshes"]), 1)
        (material,) = model.json["materials"]
        self.assertEqual(material["pbrMetallicRoughness"]["baseColorFactor"], [1, 0, 0, 1])

    def test_the_tubes_of_a_cable_join_its_ends(self):
        self.run_scene({"version": 1, "duration": 1, "step": 1 / 60, "bodies": [
            {"name": "bob", "position": [1, 0, 0], "mass": 1, "inertia": [0.1, 0.1, 0.1]}],
            "cables": [{"name": "rope", "a": "world", "b": "bob", "anchor_a": [0, 0, 0],
                        "anchor_b": [0, 0, 0], "length": 1}]}, "--gltf", "rope.glb")
        model = Model(self.folder / "rope.glb")
        tubes = [i for i, n in enumerate(model.json["nodes"]) if n["name"] == "rope"]
        times, bob = model.channel(model.node("bob"), "translation")
        for k, _ in enumerate(times):
            end = (0, 0, 0)
            for tube in tubes:
                pick = lambda path: (model.channel(tube, path) or (0, [
                    model.json["nodes"][tube][path]] * len(times)))[1][k]
                for a, b in zip(pick("translation"), end):
                    self.assertAlmostEqual(a, b, delta=1e-5)
                x, y, z, w = pick("rotation")
                along = (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x))
                end = tuple(a + pick("scale")[1] * d for a, d in zip(pick("translation"), along))
            for a, b in zip(end, bob[k]):
                self.assertAlmostEqual(a, b, delta=1e-4)

    def test_a_place_that_cannot_be_written_is_one_line(self):
        told = self.run_scene(SCENES / "pendulum.json", "--duration", "0.1", "--gltf",
                              "none/run.glb", code=4)
        self.assertIn("none/run.glb", told)
        self.assertEqual(len([l for l in told.splitlines() if l.startswith("pantin:")]), 1)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        probe = subprocess.run([PANTIN, "run", SCENES / "pendulum.json", "--duration", "0.02",
                                "--gltf", pathlib.Path(place) / "probe.glb"], capture_output=True,
                               text=True, timeout=120)
    if "this build" in probe.stderr:
        print(probe.stderr + "0 passed, 0 failed")
        sys.exit(77)
    result = unittest.main(exit=False).result
    bad = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - bad} passed, {bad} failed")
    sys.exit(bad > 0)
