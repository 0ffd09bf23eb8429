"""[limit] The failures that the atlas shows, as they are.

For each map and method of assets/atlas the failing point nearest to where the method works is run
again and has to fail alike. An improvement turns this red: `tools/atlas` then draws the new limits.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]
ASSETS = pathlib.Path(os.environ["PANTIN_ASSETS"])
sys.path.insert(0, str(ASSETS.parent / "tools/table"))
from atlas import ENTRIES  # noqa: E402

MEASURED = {"stalls"}  # by the clock of the machine


def value(axis, part):
    if axis["log"]:
        x = axis["from"] * (axis["to"] / axis["from"]) ** part
    else:
        x = axis["from"] + (axis["to"] - axis["from"]) * part
    return round(x) if axis["whole"] else x


def neighbours(points, size):
    """Of each point, the known points within an eighth of the map."""
    reach = size // 8
    for (x, y), symptom in points.items():
        yield (x, y), symptom, [s for (a, b), s in points.items()
                                if abs(a - x) <= reach and abs(b - y) <= reach]


def limit_of(one, symptoms):
    """A failing point in the midst of its like, as near as can be to a point that is ok."""
    points = {(x, y): symptoms[s] for x, y, s in one["points"]}
    good = [at for at, s in points.items() if s == "ok"]
    best = None
    for (x, y), symptom, around in neighbours(points, one["size"]):
        if symptom in ("ok", "refused") or symptom in MEASURED:
            continue
        alike = sum(s == symptom for s in around) / len(around)
        near = min(((x - a) ** 2 + (y - b) ** 2 for a, b in good), default=0)
        key = (alike < 1, -alike if alike < 1 else 0, near, x, y)
        if best is None or key < best[0]:
            best = key, (x, y), symptom
    return best and best[1:]


class Limits(unittest.TestCase):
    def run_again(self, entry, chart, one, at):
        line = ["stability", entry["scene"], "--methods", one["method"], "--grid", "1", "--halvings", "0",
                "--duration", repr(chart["duration_s"]), "--json"]
        for axis, place in zip(chart["axes"], at):
            line += ["--over", f"{axis['name']}={value(axis, place / one['size'])!r}"]
        if "step" in entry:
            line += ["--step", repr(entry["step"])]
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([PANTIN, *line, "--out", folder], cwd=ASSETS.parent, text=True,
                                  stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL, timeout=120,
                                  env={**os.environ, "PATH": folder})
        self.assertEqual(done.returncode, 0)
        (word,) = json.loads(done.stdout)["maps"][0]["shares"]
        return word

    def test_what_fails_in_the_atlas_fails(self):
        seen = set()
        for entry in ENTRIES:
            chart = json.loads((ASSETS / f"atlas/{entry['name']}.json").read_text())
            for one in chart["maps"]:
                limit = limit_of(one, chart["symptoms"])
                if not limit:
                    continue
                at, symptom = limit
                with self.subTest(map=entry["name"], method=one["method"], at=at):
                    self.assertEqual(self.run_again(entry, chart, one, at), symptom)
                    seen.add((entry["name"], one["method"]))
        self.assertGreater(len(seen), 40)

    def test_the_atlas_has_all_solvers(self):
        shown = set()
        for entry in ENTRIES:
            chart = json.loads((ASSETS / f"atlas/{entry['name']}.json").read_text())
            self.assertEqual([m["method"] for m in chart["maps"]], entry.get("methods") or ["scene"])
            shown |= {m["method"].split("/")[0] for m in chart["maps"]}
            self.assertEqual(entry["mechanism"].count(". ") + entry["mechanism"].count("."), 1,
                             entry["name"])
        self.assertGreaterEqual(len(ENTRIES), 16)
        self.assertLessEqual({"auto", "sweep", "shake2", "procedural", "lagrangian", "planar", "scene"},
                             shown)


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
