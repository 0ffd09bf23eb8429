"""pantin modes, seen from outside: what it tells of the shipped laminas, and what it refuses."""
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]
LAMINAS = pathlib.Path(os.environ["PANTIN_ASSETS"]).resolve() / "laminas"


def pantin(*arguments, folder=None):
    return subprocess.run([PANTIN, *map(str, arguments)], stdin=subprocess.DEVNULL, cwd=folder,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=120)


def modes(name, *arguments):
    done = pantin("modes", LAMINAS / f"{name}.json", *arguments, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


class Folder(unittest.TestCase):
    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)

    def tearDown(self):
        self.kept.cleanup()


class Answers(Folder):
    def test_a_grasp_has_one_mode_whose_forces_balance_the_load(self):
        told = modes("grasp")
        self.assertEqual(told["verdict"], "unique")
        (mode,) = told["modes"]
        self.assertEqual(mode["mode"], "SSS")
        force = [0.0, 0.0, 0.0]
        for contact, part in zip(told["contacts"], mode["contacts"]):
            (x, y), (nx, ny) = contact["point"], contact["normal"]
            fx = part["normal_force"] * nx - part["tangent_force"] * ny
            fy = part["normal_force"] * ny + part["tangent_force"] * nx
            force = [force[0] + fx, force[1] + fy, force[2] + x * fy - y * fx]
            self.assertAlmostEqual(abs(part["tangent_force"]), 0.5 * part["normal_force"])
            self.assertLess(part["tangent_force"] * part["slip"], 0)
        for sum_of, load in zip(force, told["load"]):
            self.assertAlmostEqual(sum_of + load, 0, places=12)
        self.assertAlmostEqual(mode["equal_friction"][0][1], 0.682265, places=6)

    def test_three_fingers_may_leave_four_modes_open(self):
        told = modes("ambiguous")
        self.assertEqual(told["verdict"], "ambiguous")
        self.assertEqual([m["mode"] for m in told["modes"]], ["SSS", "RBS", "SRB", "SBR"])
        self.assertEqual([m["index"] for m in told["modes"]], [1, 1, -1, -1])

    def test_a_peg_jams_where_friction_is_high(self):
        free = modes("peg")
        self.assertEqual(free["verdict"], "unique")
        most = free["modes"][0]["any_friction_up_to"]
        self.assertAlmostEqual(most, 0.5373, places=4)
        self.assertEqual(modes("peg", "--mu", most * 0.999)["verdict"], "unique")
        self.assertEqual(modes("peg", "--mu", most * 1.001)["verdict"], "none (conflict)")

    def test_probabilities_are_of_what_the_map_shows(self):
        told = modes("grasp", "--uncertain")
        names = {m["mode"]: m["probability"] for m in told["modes"]}
        # By area: cells of the map between 0.3 and 0.9 in which each mode is.
        pantin("modes", LAMINAS / "grasp.json", "--map", "mu1,mu2", "--range", "0.3,0.9", "--out",
               self.folder / "map.csv")
        rows = list(csv.DictReader((self.folder / "map.csv").open()))
        for name, short in (("SSS", "3S"), ("SRB", "R2S1")):
            share = sum(short in r["modes"].split() for r in rows) / len(rows)
            self.assertAlmostEqual(names[name], share, delta=0.01)
        self.assertAlmostEqual(told["none"] + told["unique"] + told["ambiguous"], 1)

    def test_a_map_as_json_tells_the_shares_of_its_cells(self):
        path = self.folder / "map.csv"
        for scene in ("grasp", "ambiguous"):
            told = modes(scene, "--map", "mu2,mu1", "--range", "0,2", "--size", "64")
            with_file = modes(scene, "--map", "mu2,mu1", "--range", "0,2", "--size", "64", "--out",
                              path)
            self.assertEqual(with_file.pop("out"), str(path))
            self.assertEqual(told, with_file)
            self.assertEqual((told["from"], told["to"], told["columns"]), (0, 2, 64))
            self.assertEqual((told["across"], told["up"]), ("mu2 (index)", "mu1 (thumb)"))
            cells = [r["modes"].split() for r in csv.DictReader(path.open())]
            self.assertEqual(len(cells), 64 * 64)
            names = [m["mode"] for m in told["modes"]]
            self.assertEqual(set(names), {name for cell in cells for name in cell})
            for m in told["modes"]:
                self.assertEqual(m["share"], sum(m["mode"] in c for c in cells) / len(cells))
            self.assertEqual(told["several"], sum(len(c) > 1 for c in cells) / len(cells))
            self.assertEqual(told["none"], sum(not c for c in cells) / len(cells))

    def test_two_fingers_at_one_point_are_a_tie(self):
        def tell(twin, *arguments):
            path = self.folder / "two.json"
            path.write_text(json.dumps({
                "version": 1, "title": "Two fingers", "gravity": [0, 0, 0],
                "laminas": [{"name": "part", "centre_of_mass": [0.5, 0.2], "force": [0.1, -1],
                             "fingers": [
                    {"name": "left", "point": [0, 0], "normal": [0, 1], "velocity": [0.2, 0.1],
                     "friction": 0.3},
                    {"name": "twin", "point": [0, 0], "normal": [0.6, 0.8], "velocity": twin,
                     "friction": 0.3},
                    {"name": "right", "point": [1, 0], "normal": [0.1, 0.99498743710662],
                     "velocity": [0, 0.1], "friction": 0.5}]}]}))
            done = pantin("modes", path, *arguments)
            self.assertEqual(done.returncode, 0, done.stderr)
            return done.stdout
        words = tell([0.2, 0.1])
        self.assertIn("one motion holds, in which a finger may carry force or not: a tie", words)
        self.assertRegex(words, "twin +no force, stays in contact")
        self.assertNotIn("separates at", words)
        mode = json.loads(tell([0.2, 0.1], "--json"))["modes"][0]
        self.assertTrue(mode["break_tie"])
        self.assertEqual(mode["contacts"][1]["does"], "stays")
        # A finger that goes away slowly separates, and there is one mode.
        words = tell([0.2 - 0.6e-3, 0.1 - 0.8e-3])
        self.assertIn("one mode holds\n", words)
        self.assertRegex(words, "twin +separates at 0.001 m/s")
        told = json.loads(tell([0.2 - 0.6e-3, 0.1 - 0.8e-3], "--json"))
        self.assertEqual([m["break_tie"] for m in told["modes"]], [False])

    def test_advice_makes_a_mode_certain(self):
        told = modes("grasp", "--advise")
        self.assertTrue(told["certain"])
        scene = json.loads((LAMINAS / "grasp.json").read_text())
        for by, is_certain in ((told["by"], True), (told["by"] * 0.99, False)):
            changed = json.loads(json.dumps(scene))
            for finger in changed["laminas"][0]["fingers"]:
                if finger["name"] == told["finger"]:
                    nx, ny = finger["normal"]
                    finger["point"] = [finger["point"][0] + by * ny, finger["point"][1] - by * nx]
            path = self.folder / "moved.json"
            path.write_text(json.dumps(changed))
            outlook = json.loads(pantin("modes", path, "--uncertain", "--json").stdout)
            seen = [m["occurrence"] for m in outlook["modes"]]
            self.assertEqual(seen == ["always"], is_certain)


class Motions(Folder):
    def test_the_rod_switches_where_the_recursion_says(self):
        done = pantin("modes", LAMINAS / "rod.json", "--move", self.folder / "rod.csv", "--samples",
                      "321")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = list(csv.DictReader((self.folder / "rod.csv").open()))
        self.assertEqual(len(rows), 321)
        at = {round(float(r["time_s"]), 6): float(r["x_m"]) for r in rows}
        self.assertAlmostEqual(at[12.5], -0.125, places=9)
        self.assertAlmostEqual(at[20.5], -0.045, places=9)
        self.assertEqual(rows[-1]["switches"], "8")
        # However few samples there are.
        told = modes("rod", "--move", self.folder / "rod.csv", "--samples", "33")
        times = [12.5, 20.5, 25.3, 28.18, 29.908, 30.9448, 31.56688, 31.940128]
        self.assertEqual(len(told["modes"]), 1 + len(times))
        self.assertEqual(told["modes"][0], {"time": 0, "mode": "+R"})
        for mode, time in zip(told["modes"][1:], times):
            self.assertAlmostEqual(mode["time"], time, places=7)

    def test_the_bar_is_handed_on(self):
        told = modes("regrasp", "--move", self.folder / "bar.csv")
        self.assertEqual(told["stopped"], "")
        first, last = told["modes"][0]["mode"], told["modes"][-1]["mode"]
        self.assertEqual((first[2], last[1]), (".", "."))  # the third comes, the second goes
        self.assertNotIn(".", first[:2] + last[0] + last[2])

    def test_a_path_bears_so_much_friction(self):
        told = modes("push", "--path", self.folder / "bound.csv")
        rows = list(csv.DictReader((self.folder / "bound.csv").open()))
        self.assertEqual(told["poses"], len(rows))
        least = min(float(r["any_friction_up_to"]) for r in rows)
        self.assertAlmostEqual(told["any_friction_up_to"], least, places=8)
        # With less the box goes as planned; with more it tips.
        pantin("modes", LAMINAS / "push.json", "--move", self.folder / "less.csv", "--mu",
               least * 0.999)
        rows = list(csv.DictReader((self.folder / "less.csv").open()))
        self.assertAlmostEqual(float(rows[-1]["x_m"]), 0.9, places=9)
        self.assertAlmostEqual(float(rows[-1]["angle_rad"]), 0, places=9)
        stopped = modes("push", "--move", self.folder / "more.csv", "--mu", least * 1.01)
        self.assertTrue(stopped["stopped"] or abs(stopped["angle"]) > 1e-6)

    def test_dynamics_comes_nearer_as_fingers_slow_down(self):
        told = modes("rod", "--against", "dynamics", "--duration", "12")
        apart = [run["apart"] for run in told["runs"]]
        for fast, slow in zip(apart, apart[1:]):
            self.assertLess(slow, 0.6 * fast)
        self.assertLess(apart[-1], 0.005 * told["way"])
        self.assertLess(modes("peg", "--against", "dynamics", "--duration", "1")["runs"][0]["apart"], 1e-5)

    def test_dynamics_bounces_in_friction_space_as_modes_do(self):
        told = modes("rod", "--against", "dynamics")
        apart = [run["apart"] for run in told["runs"]]
        for fast, slow in zip(apart, apart[1:]):
            self.assertLess(slow, 0.6 * fast)
        self.assertTrue(all(run["words"] == "they agree" for run in told["runs"]))
        self.assertTrue(all(run["breaches"] == [] for run in told["runs"]))
        drawn = self.folder / "both.svg"
        done = pantin("modes", LAMINAS / "rod.json", "--against", "dynamics", "--duration", "2", "--out",
                      drawn)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("friction used at left", drawn.read_text())

    def parted(self, change):
        scene = json.loads((LAMINAS / "rod.json").read_text())
        change(scene)
        path = self.folder / "changed.json"
        path.write_text(json.dumps(scene))
        done = pantin("modes", path, "--against", "dynamics", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)["runs"]

    def test_where_they_part_the_broken_assumption_is_measured(self):
        def faster(scene):
            scene["duration"] = 0.8
            for finger in scene["laminas"][0]["fingers"]:
                finger["velocity"] = [40 * v for v in finger["velocity"]]
        first = self.parted(faster)[0]
        self.assertIn("they diverge at", first["words"])
        self.assertIn("inertia reaches", first["words"])
        sizes = [b["size"] / b["bound"] for b in first["breaches"]]
        self.assertEqual(sizes, sorted(sizes, reverse=True))
        self.assertGreater(sizes[0], 1)

    def test_modes_are_told_of_a_scene_on_its_way(self):
        for time, mode in (("12", "+R"), ("13", "R-"),
                           ("0.05", "dynamics: several modes hold, or only an unstable one")):
            self.assertEqual(modes("rod", "--at", time)["running"], mode)
        told = modes("rod", "--at", "10")
        self.assertAlmostEqual(told["contacts"][0]["point"][0], -0.3, places=9)
        self.assertAlmostEqual(told["contacts"][1]["point"][0], 0.15, places=9)
        done = pantin("modes", LAMINAS / "grasp.json", "--at", "1")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn('found no "outline"', done.stderr)

    def test_a_motion_is_a_scene_that_runs(self):
        done = pantin("modes", LAMINAS / "peg.json", "--move", self.folder / "peg.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        done = pantin("check", self.folder / "peg.json")
        self.assertEqual(done.returncode, 0, done.stderr)


class Drawings(Folder):
    def test_maps_are_drawn(self):
        for name in ("map.svg", "map.png"):
            done = pantin("modes", LAMINAS / "ambiguous.json", "--map", "mu1,mu2", "--out",
                          self.folder / name)
            if done.returncode == 1:  # a build without pictures
                self.assertIn("PNG", done.stderr)
                continue
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertGreater((self.folder / name).stat().st_size, 5000)
        text = (self.folder / "map.svg").read_text()
        self.assertIn("thumb slides, index sticks, middle separates", text)

    def test_maps_are_told_in_a_terminal(self):
        done = pantin("modes", LAMINAS / "ambiguous.json", "--map", "1,2")
        self.assertIn("1346", done.stdout)
        self.assertIn("none holds", done.stdout)


class Refusals(Folder):
    def refused(self, lamina, *expected, **scene):
        path = self.folder / "bad.json"
        path.write_text(json.dumps({"version": 1, "laminas": [lamina], **scene}))
        done = pantin("modes", path, "--move", self.folder / "out.csv")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        for words in expected:
            self.assertIn(words, done.stderr)
        self.assertFalse((self.folder / "out.csv").exists())

    def test_what_means_nothing_is_refused_by_name_and_place(self):
        square = [[0, 0], [1, 0], [1, 1], [0, 1]]
        finger = {"point": [0.5, 0]}
        self.refused({"name": "a", "fingers": []}, "/laminas/0/fingers", "1 to 32 fingers")
        self.refused({"name": "a", "fingers": [{"point": [0, 0], "normal": [0, 0]}]},
                     "/fingers/0/normal", "not both 0")
        self.refused({"name": "a", "fingers": [{"point": [0, 0]}]}, "no \"normal\"")
        self.refused({"name": "a", "outline": square, "fingers": [{"point": [0.5, 0.25]}]},
                     "/fingers/0/point", "0.25 m inside")
        self.refused({"name": "a", "outline": square, "fingers": [{"point": [0, 0]}]},
                     "a corner of the outline")
        self.refused({"name": "a", "outline": square,
                      "fingers": [{"point": [0.5, 0], "normal": [1, 0]}]}, "the edge's own, [0, 1]")
        self.refused({"name": "a", "outline": square, "fingers": [finger, finger]},
                     "/fingers/1", "again")
        self.refused({"name": "a", "outline": square, "fingers": [{**finger, "friction": -0.1}]},
                     "/fingers/0/friction", "-0.1")
        self.refused({"name": "a", "outline": square,
                      "fingers": [{**finger, "friction_between": [0.5, 0.2]}]}, "lower one first")
        self.refused({"name": "a", "outline": square,
                      "fingers": [{**finger, "waypoints": [[2, 0, 0], [1, 0, 0]]}]},
                     "/waypoints/1", "a later one")
        self.refused({"name": "a", "outline": square[:2], "fingers": [finger]}, "three corners")
        self.refused({"name": "a", "outline": [[0, 0], [1, 0], [2, 0]], "fingers": [finger]},
                     "/outline", "on one line")
        self.refused({"name": "a", "outline": [[0, 0], [1, 1], [1, 0], [0, 1]],
                      "fingers": [finger]}, "/outline", "intersect")
        self.refused({"name": "a", "outline": square, "fingers": [finger]}, "found no load",
                     gravity=[0, 0, 0])
        self.refused({"name": "a", "fingers": [{"point": [0, 0], "normal": [0, 1]}]},
                     "no \"outline\"")

    def test_what_a_lamina_of_a_world_cannot_be_is_refused(self):
        rod = {"name": "rod", "outline": [[-0.6, 0], [0.6, 0], [0.6, 0.02], [-0.6, 0.02]],
               "fingers": [{"name": "a", "point": [-0.4, 0]}, {"name": "b", "point": [0.25, 0]}]}
        tiny = dict(rod, outline=[[1e-100 * x, 1e-100 * y] for x, y in rod["outline"]])
        ball = {"name": "ball", "mass": 1, "inertia": [1, 1, 1]}
        self.refused(tiny, "/laminas/0/outline", "expected 1e-9 m or more")
        self.refused(rod, "/joints/0", "on a lamina", "supports fingers only",
                     joints=[{"a": "world", "b": "rod", "anchor": [0, 0, 0]}])
        self.refused(rod, "/pins/0", "on a lamina", pins=[{"body": "rod", "target": [0, 0, 0]}])
        self.refused(rod, "/paths/0/body", 'found "rod/a", expected no finger of a lamina',
                     paths=[{"body": "rod/a", "keyframes": [{"time": 0}]}])
        self.refused(rod, "/bodies/0", 'body "ball" solved by "quasistatic"', bodies=[ball],
                     solver={"type": "quasistatic"})
        self.refused(rod, "/events/0/solver", 'body "ball", which is not a lamina', bodies=[ball],
                     events=[{"type": "solver", "solver": "quasistatic", "at": 1}])
        self.refused(rod, "/laminas/0/name", 'found the name "rod" again',
                     bodies=[dict(ball, name="rod")])

    def test_a_lamina_that_no_finger_touches_has_no_modes(self):
        rod = {"name": "rod", "outline": [[-0.6, 0], [0.6, 0], [0.6, 0.02], [-0.6, 0.02]],
               "fingers": [{"name": "a", "point": [-0.4, 0], "velocity": [0, -5]},
                           {"name": "b", "point": [0.25, -0.5]}]}
        path = self.folder / "drop.json"
        path.write_text(json.dumps({"version": 1, "laminas": [rod]}))
        done = pantin("modes", path, "--at", "0.1")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn('lamina "rod": found no finger in contact at 0.1 s, expected one: '
                      "without contacts there are no modes (dynamics: ", done.stderr)
        rod["fingers"] = rod["fingers"][1:]
        path.write_text(json.dumps({"version": 1, "laminas": [rod]}))
        for more in ([], ["--json"], ["--advise"], ["--uncertain"], ["--map", "mu1,mu2"]):
            done = pantin("modes", path, *more)
            self.assertEqual((done.returncode, done.stdout), (1, ""), more)
            self.assertIn("in contact at 0 s", done.stderr)

    def test_laminas_have_no_mirror_image_and_no_prefab(self):
        rod = {"name": "rod_l", "outline": [[-0.6, 0], [0.6, 0], [0.6, 0.02], [-0.6, 0.02]],
               "fingers": [{"name": "a_l", "point": [-0.4, 0]}, {"point": [0.25, 0]}]}
        mirrored = {"generators": {"mirrors": [{"bodies": ["rod_l/a_l"]}]}}
        self.refused(rod, "/generators/mirrors/0/bodies", 'found "rod_l/a_l", expected no lamina',
                     **mirrored)
        mirrored["generators"]["mirrors"][0]["bodies"] = ["rod_l"]
        part = self.folder / "part.json"
        part.write_text(json.dumps({"version": 1, "laminas": [rod], **mirrored}))
        done = pantin("check", part)
        self.assertEqual(done.returncode, 2)
        self.assertIn('found "rod_l", expected no lamina', done.stderr)
        part.write_text(json.dumps({"version": 1, "laminas": [rod]}))
        whole = self.folder / "whole.json"
        whole.write_text(json.dumps({"version": 1, "prefabs": [{"name": "p", "file": "part.json"}],
                                     "instances": [{"name": "i", "prefab": "p"}]}))
        done = pantin("check", whole)
        self.assertEqual(done.returncode, 0)
        self.assertIn("part.json:1:27: /laminas: laminas belong to the whole scene; in a prefab "
                      "they are ignored", done.stderr)

    def test_a_run_tells_when_dynamics_moves_a_lamina(self):
        done = pantin("run", LAMINAS / "rod.json", "--json", "--record", self.folder / "rod.csv")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        told = json.loads(done.stdout)
        self.assertEqual((told["solver"], told["mode_switches"]), ("quasistatic", 8))
        to, back = told["hand_overs"]
        self.assertEqual((to["lamina"], to["to"], to["why"]),
                         ("rod", "dynamics", "several modes hold, or only an unstable one"))
        self.assertEqual((back["lamina"], back["to"]), ("rod", "modes"))
        self.assertEqual(told["steps_by_dynamics"], 6)
        self.assertIn("is left to dynamics", pantin("run", LAMINAS / "rod.json").stdout)
        self.assertEqual(len((self.folder / "rod.csv").read_text().splitlines()), 1922)

    def test_a_coefficient_that_is_no_number_is_refused(self):
        for value in ("NaN", "1e999", "\"much\""):
            path = self.folder / "bad.json"
            path.write_text('{"version": 1, "laminas": [{"name": "a", "fingers": [{"point": [0, 0], '
                            '"normal": [0, 1], "friction": %s}]}]}' % value)
            done = pantin("modes", path)
            self.assertEqual(done.returncode, 2)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)

    def test_command_lines_that_mean_nothing_are_refused(self):
        rod = LAMINAS / "rod.json"
        for arguments in (["--map", "mu1"], ["--map", "mu1,mu1"], ["--map", "mu1,mu3"],
                          ["--mu", "0.1,0.2,0.3"], ["--mu", "-1"], ["--mu", "nan"],
                          ["--lamina", "rot"], ["--range", "1,0"], ["--against", "luck"],
                          ["--map", "mu1,mu2", "--uncertain"],
                          ["--map", "mu1,mu2", "--out", "map.bmp"]):
            done = pantin("modes", rod, *arguments, folder=self.folder)
            self.assertEqual((done.returncode, done.stdout), (2, ""), arguments)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertEqual(list(self.folder.iterdir()), [])
        self.assertIn('nearest is "rod"', pantin("modes", rod, "--lamina", "rot").stderr)

    def test_a_scene_without_laminas_is_refused(self):
        path = self.folder / "empty.json"
        path.write_text('{"version": 1}')
        done = pantin("modes", path)
        self.assertEqual(done.returncode, 2)
        self.assertIn('found no "laminas"', done.stderr)


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
