"""pantin assemble: parts come together, the scene that is written loads, contradictions are named."""
import csv
import json
import math
import os
import pathlib
import subprocess
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]
SCENES = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes"

# A four-bar linkage whose bars are written where they do not meet.
APART = """{
  // Bars of 0.3, 1 and 0.8 m.
  "version": 1, "title": "apart", "solver": {"type": "lagrangian"},
  "bodies": [
    {"name": "crank", "position": [3, 1, 0], "shape": {"type": "capsule", "radius": 0.02, "length": 0.3}},
    {"name": "coupler", "position": [-2, 2, 0.5], "shape": {"type": "capsule", "radius": 0.02, "length": 1}},
    {"name": "rocker", "position": [0, -2, 0.2], "rotation_deg": [30, 40, 50],
     "shape": {"type": "capsule", "radius": 0.02, "length": 0.8}}],
  "joints": [
    {"name": "A", "kind": "hinge", "a": "world", "b": "crank", "anchor_a": [0, 0, 0],
     "anchor_b": [0, -0.15, 0], %(axes)s},
    {"name": "B", "kind": "hinge", "a": "crank", "b": "coupler", "anchor_a": [0, 0.15, 0],
     "anchor_b": [0, -0.5, 0], %(axes)s},
    {"name": "C", "kind": "hinge", "a": "coupler", "b": "rocker", "anchor_a": [0, 0.5, 0],
     "anchor_b": [0, 0.4, 0], %(axes)s},
    {"name": "D", "kind": "hinge", "a": "rocker", "b": "world", "anchor_a": [0, -0.4, 0],
     "anchor_b": [1, 0, 0], %(axes)s}%(more)s],
}
"""
AXES = '"axis_a": [0, 0, 1], "across_a": [1, 0, 0], "axis_b": [0, 0, 1], "across_b": [1, 0, 0]'


def pantin(*arguments):
    return subprocess.run([PANTIN, *map(str, arguments)], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300)


class Assemble(unittest.TestCase):
    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)
        self.apart = self.folder / "apart.json5"
        self.apart.write_text(APART % {"axes": AXES, "more": ""})

    def tearDown(self):
        self.kept.cleanup()

    def told(self, *arguments, code=0):
        done = pantin("assemble", *arguments, "--json")
        self.assertEqual(done.returncode, code, done.stderr)
        return json.loads(done.stdout)

    def test_parts_that_lie_apart_come_together(self):
        out = self.folder / "together.json5"
        told = self.told(self.apart, "--out", out)
        self.assertEqual(told["status"], "assembled")
        self.assertLess(told["residual"], 1e-12)
        self.assertEqual((told["rows"], told["rank"], told["mobility"]), (20, 17, 1))
        self.assertEqual(sum(law["rows"] for law in told["redundant"]), 3)
        self.assertGreater(told["moved_m"], 1)
        self.assertEqual({law["law"] for law in told["residuals"]}, {"A", "B", "C", "D"})
        # What was written is closed, and all else is as it was.
        self.assertIn("// Bars of 0.3, 1 and 0.8 m.", out.read_text())
        again = self.told(out)
        self.assertEqual(again["iterations"], 0)
        self.assertLess(again["residual"], 1e-12)
        self.assertLess(again["moved_m"], 1e-12)
        checked = pantin("check", out)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        # Poses that are there already are replaced.
        twice = self.folder / "twice.json5"
        self.told(out, "--scatter", "1", "--seed", "5", "--out", twice)
        self.assertEqual(twice.read_text().count('"poses"'), 1)
        self.assertLess(self.told(twice)["residual"], 1e-12)

    def test_every_kind_of_law_closes_from_scattered_bodies(self):
        for name in ("stewart", "bricard", "marionette", "elliptical_gears", "egg_in_bowl",
                     "curve_four_bar", "slider_crank", "planar_belts", "joint_ranges", "crane"):
            with self.subTest(name):
                out = SCENES / f"{name}.json"
                told = self.told(out, "--scatter", "0.2", "--seed", "3")
                self.assertLess(told["residual"], 1e-12)

    def test_the_last_arm_of_bent_pieces_gets_the_least_length_that_reaches(self):
        text = (SCENES / "bendy_flexible.json").read_text()
        whole, free = '"anchor_a": [0, 0.33, 0]', '  "free": ["joints/last/anchor_a"],\n'
        self.assertIn(whole, text)
        self.assertIn(free, text)

        def assembled(arm, frees, code=0):
            path = self.folder / "arm.json"
            anchor = whole.replace("[0, 0.33, 0]", json.dumps(arm))
            path.write_text(text.replace(whole, anchor).replace(free, free if frees else ""))
            return self.told(path, "--starts", "4", code=code)

        # It is long enough: nothing changes.
        change = assembled([0, 0.33, 0], True)["design"][0]
        self.assertLess(math.dist(change["before"], change["after"]), 1e-9)
        # It is too short: both corners open as far as they may, and the arm reaches just so far.
        told = assembled([0, 0.25, 0], True)
        self.assertEqual(set(told["at_limits"]), {"bend_1", "bend_4"})
        least = told["design"][0]["after"]
        self.assertGreater(math.dist(least, [0, 0.25, 0]), 0.04)
        self.assertLess(math.dist(least, [0, 0.25, 0]), 0.06)
        self.assertEqual(assembled(least, False)["status"], "assembled")
        shorter = [a + 0.99 * (b - a) for a, b in zip([0, 0.25, 0], least)]
        assembled(shorter, False, code=3)

    def test_jacobians_by_differences_close_the_same_contacts(self):
        iterations = {}
        for jacobians in ("analytic", "differences", "squared_distance"):
            told = self.told(SCENES / "egg_in_bowl.json", "--scatter", "0.2", "--seed", "1",
                             "--jacobians", jacobians)
            self.assertEqual(told["status"], "assembled")
            iterations[jacobians] = told["iterations"]
        self.assertEqual(iterations["differences"], iterations["analytic"])
        # The gradient of the squared distance vanishes with it: the gap halves in each iteration.
        self.assertGreater(iterations["squared_distance"], 2 * iterations["analytic"])
        refused = pantin("assemble", SCENES / "egg_in_bowl.json", "--jacobians", "exact")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("--jacobians", refused.stderr)
        for command in ("assemble", "run"):
            refused = pantin(command, SCENES / "four_bar.json", "--jacobians", "differences")
            self.assertEqual(refused.returncode, 2)
            self.assertIn("found --jacobians, expected it with a scene that has surface joints",
                          refused.stderr)

    def test_held_bodies_stay(self):
        out = self.folder / "held.json5"
        # Its hinge D is far away. The scene may follow the option.
        self.told("--hold", "rocker", self.apart, "--out", out, code=3)
        self.assertNotIn('"body": "rocker"', out.read_text())
        self.assertIn('"body": "crank"', out.read_text())

    def test_contradictions_are_named(self):
        strut = ''', {"name": "strut", "kind": "distance", "a": "world", "b": "coupler",
            "anchor_a": [0, 5, 0], "anchor_b": [0, 0, 0], "length": 1}'''
        self.apart.write_text(APART % {"axes": AXES, "more": strut})
        done = pantin("assemble", self.apart)
        self.assertEqual(done.returncode, 3)
        self.assertEqual(len(done.stderr.splitlines()), 1)
        self.assertIn("strut", done.stderr)
        self.assertIn("NOT assembled", done.stdout)
        told = self.told(self.apart, code=3)
        self.assertIn("strut", told["contradictory"])
        self.assertLess(len(told["contradictory"]), 5)
        self.assertGreater(told["residual"], 0.1)
        largest = [law["residual"] for law in told["residuals"]]
        self.assertEqual(largest, sorted(largest, reverse=True))

    def test_trace_and_methods(self):
        for method in ("auto", "gauss-newton", "lm", "gradient", "gradient-safe", "momentum",
                       "gauss-seidel", "euler-angles"):
            with self.subTest(method):
                trace = self.folder / f"{method}.csv"
                told = self.told(SCENES / "four_bar.json", "--scatter", "0", "--method", method,
                                 "--trace", trace, "--tolerance", "1e-6", "--iterations", "20000",
                                 "--starts", "0")
                with trace.open() as file:
                    rows = list(csv.DictReader(file))
                self.assertEqual(rows[0].keys(),
                                 {"iteration", "seconds", "residual", "merit", "damping"})
                self.assertLess(float(rows[-1]["residual"]), 1e-6)
                self.assertTrue(all(math.isfinite(float(row["merit"])) for row in rows))
                self.assertEqual(told["method"], method)

    def test_trials(self):
        told = self.told(SCENES / "four_bar.json", "--scatter", "1", "--trials", "50")
        self.assertEqual((told["trials"], told["assembled"], told["failed"]), (50, 50, []))
        self.assertGreater(told["iterations_median"], 2)

    def test_what_is_refused(self):
        for arguments, words in [
                ((self.folder / "none.json",), ["none.json"]),
                ((self.apart, "--hold", "rokcer"), ["--hold", '"rokcer"', 'nearest is "rocker"']),
                ((self.apart, "--method", "magic"), ["--method"]),
                ((self.apart, "--tolerance", "0"), ["--tolerance"]),
                ((SCENES / "stewart.json", "--out", self.folder / "no" / "such.json"), ["such.json"])]:
            done = pantin("assemble", *arguments)
            self.assertIn(done.returncode, (2, 4), arguments)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            for word in words:
                self.assertIn(word, done.stderr)


# A frame of rods whose last one is 1 % too short, and a rope over two pulleys.
FRAME = """{
  "version": 1, "drift_bound": 1e-6, "solver": {"type": "lagrangian"},
  "bodies": [{"name": "tip", "position": [0.4, 0.3, 1], "mass": 1,
              "shape": {"type": "box", "size": [0.2, 0.1, 0.1], "position": [0.05, 0.02, 0]}}],
  "joints": [
    {"name": "one", "kind": "distance", "a": "world", "b": "tip", "point_a": [0, 0, 0]},
    {"name": "two", "kind": "distance", "a": "world", "b": "tip", "point_a": [1, 0, 0]},
    {"name": "three", "kind": "distance", "a": "world", "b": "tip", "point_a": [0, 1, 0]},
    {"name": "four", "kind": "distance", "a": "world", "b": "tip", "point_a": [1, 1, 0.5],
     // 1 %% too short.
     "length": %(short)r}]%(more)s
}
"""
FITS = math.sqrt(0.6 ** 2 + 0.7 ** 2 + 0.5 ** 2)


class Design(unittest.TestCase):
    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)
        self.scene = self.folder / "frame.json5"
        self.out = self.folder / "out.json5"
        self.write("")

    def tearDown(self):
        self.kept.cleanup()

    def write(self, more, short=0.99 * FITS):
        self.scene.write_text(FRAME % {"short": short, "more": more})

    def told(self, *arguments, code=0):
        done = pantin("assemble", self.scene, *arguments, "--json")
        self.assertEqual(done.returncode, code, done.stderr)
        return json.loads(done.stdout)

    def is_closed(self):
        """What was written is closed as it is, without freedom to change it."""
        done = pantin("assemble", self.out, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        again = json.loads(done.stdout)
        self.assertLess(again["residual"], 1e-12)
        self.assertLess(again["moved_m"], 1e-9)
        for change in again["design"]:
            before, after = (x if isinstance(x, list) else [x] for x in (change["before"], change["after"]))
            for x, y in zip(before, after, strict=True):
                self.assertLess(abs(x - y), 1e-12)
        checked = pantin("check", self.out)
        self.assertEqual(checked.returncode, 0, checked.stderr)

    def test_a_length_that_does_not_fit_becomes_the_one_that_fits(self):
        self.told(code=3)
        told = self.told("--free", "joints/3/length", "--out", self.out)
        change, = told["design"]
        self.assertEqual((change["of"], change["law"], change["in_file"]),
                         ("joints/3/length", "four", True))
        self.assertEqual(change["before"], 0.99 * FITS)
        self.assertLess(abs(change["after"] - FITS), 1e-11)
        self.assertIn("// 1 % too short.", self.out.read_text())
        self.is_closed()
        said = pantin("assemble", self.scene, "--free", "joints/four/length")
        self.assertIn("joints/four/length 1.0383", said.stdout)

    def test_the_scene_frees_numbers_within_bounds(self):
        self.write(', "free": [{"of": "joints/four/length", "min": 0.5, "max": %r}]' % (0.991 * FITS))
        done = pantin("assemble", self.scene)
        self.assertEqual(done.returncode, 3)
        self.assertIn("at a bound: joints/four/length", done.stderr)
        self.assertIn("(at its bound)", done.stdout)
        told = self.told("--free", "joints/0/anchor_a", "--out", self.out)
        self.assertTrue(told["design"][0]["at_bound"])
        self.assertEqual(told["design"][0]["after"], 0.991 * FITS)
        self.assertEqual(len(told["design"][1]["after"]), 3)
        self.assertNotEqual(told["design"][1]["after"], told["design"][1]["before"])
        self.assertIn('"anchor_a"', self.out.read_text())
        self.is_closed()

    def test_bodies_with_a_mass_centre_of_their_own_keep_their_anchors(self):
        told = self.told("--free", "joints/four/anchor_b", "--out", self.out)
        before = told["design"][0]["before"]
        self.assertEqual(before, [0, 0, 0])
        self.is_closed()

    def test_an_axis_that_leans_becomes_parallel(self):
        self.scene = self.folder / "leans.json5"
        leans = APART.replace('"version": 1,', '"version": 1, "drift_bound": 1e-9,')
        leans %= {"axes": AXES, "more": ""}
        first = leans.index('"name": "C"')
        self.scene.write_text(leans[:first] + leans[first:].replace(
            AXES, '"axis_a": [0.1, 0.2, 1], "across_a": [1, 0, 0], "axis_b": [0, 0, 1], '
                  '"across_b": [1, 0, 0]', 1))
        self.told(code=3)
        told = self.told("--free", "joints/C/axis_a", "--out", self.out)
        axis = told["design"][0]["after"]
        self.assertLess(math.hypot(axis[0], axis[1]), 1e-9)
        self.is_closed()

    def test_a_rope_over_pulleys_gets_radius_and_length(self):
        # Over a pulley on the world to the tip, which the rods hold.
        rope = ''', "cables": [{"name": "rope", "a": "world", "b": "tip", "point_a": [-1, 0.3, 2],
            "slack": 0.99, "over": [{"body": "world", "point": [1.5, 0.3, 1.8], "radius": 0.1,
            "axis": [0, 1, 0]}]}], "free": ["cables/0/%s"]'''
        for number in ("length", "over/0/radius", "anchor_a"):
            with self.subTest(number):
                self.write(rope % number, short=FITS)
                told = self.told("--out", self.out)
                self.assertNotEqual(told["design"][0]["after"], told["design"][0]["before"])
                self.assertNotIn("slack", self.out.read_text())
                self.is_closed()

    def test_numbers_of_generators_change_but_are_not_written(self):
        more = ''', "generators": {"chains": [{"name": "chain", "links": 2, "length": 0.5,
            "start": [5, 0, 0], "attach": "world", "end_attach": "world", "shape": {"type": "capsule", "radius": 0.02,
            "length": 0.4}}]}'''
        self.write(more)
        done = pantin("assemble", self.scene, "--free", "joints/chain/0-1/anchor_a", "--free",
                      "joints/3/length", "--out", self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("warning: ", done.stderr)
        self.assertIn('"joints/chain/0-1/anchor_a" in a prefab or generator', done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)

    WHEELS = """{"version": 1, "gravity": [0, 0, 0], "solver": {"type": "lagrangian"}, "bodies": [
      {"name": "a", "position": [0, 0, 0], "mass": 1, "inertia": [0.1, 0.1, 0.1]},
      {"name": "b", "position": [1, 0, 0], "mass": 1, "inertia": [0.1, 0.1, 0.1]}],
     "joints": [
      {"name": "A", "kind": "hinge", "a": "world", "b": "a", "anchor": [0, 0, 0], "axis": [0, 0, 1]},
      {"name": "B", "kind": "hinge", "a": "world", "b": "b", "anchor": [1, 0, 0], "axis": [0, 0, 1]},
      {"name": "rod", "kind": "distance", "a": "world", "b": "b", "anchor_a": [1, 2, 0],
       "anchor_b": [0.5, 0, 0], "length": %r}],
     "poses": [{"body": "a", "rotation_deg": [0, 0, 40]},
               {"body": "b", "position": [1, 0, 0], "rotation_deg": [0, 0, 25]}],
     %%s, "drift_bound": 1e-9}""" % math.dist((1, 2), (1 + 0.5 * math.cos(math.radians(25)),
                                                      0.5 * math.sin(math.radians(25))))

    def test_gears_and_belts_get_ratios_and_radii(self):
        for more, free, after in (
                ('''"gears": [ // first
                    {"name": "g", "first": "A", "second": "B", "ratio": 0.6, "offset_deg": 5}]''',
                 "gears/g/ratio", 20 / 40),
                ('''"belts": [{"name": "belt", "pulleys": [{"body": "a", "radius": 0.1},
                    {"body": "b", "radius": 0.15}]}]''', "belts/0/pulleys/1/radius", 0.1 * 40 / 25)):
            with self.subTest(free):
                self.scene.write_text(self.WHEELS % more)
                told = self.told("--hold", "a", "--free", free, "--out", self.out)
                change, = told["design"]
                self.assertTrue(change["in_file"])
                self.assertLess(abs(change["after"] - after), 1e-9)
                again = pantin("assemble", self.out, "--hold", "a", "--json")
                self.assertEqual(again.returncode, 0, again.stderr)
                self.assertLess(json.loads(again.stdout)["moved_m"], 1e-9)
                self.assertIn('"ratio": 0.5' if "gear" in free else '"radius": 0.16',
                              self.out.read_text().replace("0.4999999", "0.5")
                              .replace("0.15999999", "0.16"))

    HILL = """{"version": 1, "gravity": [0, 0, 0], "solver": {"type": "lagrangian"},
     "surfaces": [{"name": "hill", "faces": [{"type": "nurbs", "degrees": [2, 2],
       "knots_u": [0, 0, 0, 1, 1, 1], "knots_v": [0, 0, 0, 1, 1, 1],
       %s}]}],
     "bodies": [{"name": "frame", "motion": "fixed"},
       {"name": "ball", "position": [0.02, 0.01, 0.1], "shape": {"type": "sphere", "radius": 0.05}}],
     "joints": [{"name": "held", "kind": "fixed", "a": "world", "b": "ball", "anchor": [0, 0, 0]}],
     "surface_joints": [{"name": "touch", "a": {"body": "ball"},
       "b": {"body": "frame", "surface": "hill"}}], "free": ["surfaces/hill/%s/1/1"],
     "drift_bound": 1e-9}"""

    def test_control_points_and_weights_are_written_in_the_form_of_the_file(self):
        grid = [[x, y, 0.03 if x == y == 0 else 0] for x in (-0.5, 0, 0.5) for y in (-0.5, 0, 0.5)]
        points = '"points": ' + json.dumps(grid)
        homogeneous = '"homogeneous": ' + json.dumps([c for p in grid for c in (*p, 1)])
        lifted = json.dumps([p if p[2] == 0 else [0, 0, 0.3] for p in grid])
        for net, which in ((points, "points"), (homogeneous, "points"),
                           ('"points": ' + lifted, "weights"),
                           ('"points": ' + lifted + ', "weights": [1, 1, 1, 1, 0.9, 1, 1, 1, 1]',
                            "weights")):
            with self.subTest(net=net[:10], which=which):
                self.scene.write_text(self.HILL % (net, which))
                told = self.told("--out", self.out)
                change, = told["design"]
                self.assertEqual((change["law"], change["in_file"]), ("touch", True))
                self.assertNotEqual(change["before"], change["after"])
                self.is_closed()

    def test_only_control_points_as_the_file_gives_them_are_free(self):
        grid = [[x, y, 0.03 if x == y == 0 else 0] for x in (-0.5, 0, 0.5) for y in (-0.5, 0, 0.5)]
        scene = self.HILL % ('"points": ' + json.dumps(grid), "points")
        for change, words in (
                (("hill/points/1/1", "hill/points/3/0"), "expected a control point from 0/0 to 2/2"),
                (("hill/points/1/1", "hall/points/1/1"), 'nearest is "surfaces/hill"'),
                (("hill/points/1/1", "hill/points/1"), "expected a path such as"),
                (('"knots_u"', '"scale": 1.1, "knots_u"'), "neither moved nor scaled"),
                (('["surfaces/hill/points/1/1"]',
                  '[{"of": "surfaces/hill/points/1/1", "min": 0}]'), "of one number only")):
            with self.subTest(words):
                self.assertIn(change[0], scene)
                self.scene.write_text(scene.replace(*change))
                done = pantin("assemble", self.scene)
                self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
                self.assertIn(words, done.stderr)

    def test_surfaces_that_are_written_apart_are_brought_together(self):
        self.scene.write_text("""{"version": 1, "gravity": [0, 0, 0], "solver": {"type": "lagrangian"},
          "bodies": [{"name": "table", "motion": "fixed", "shape": {"type": "plane", "size": 4}},
            {"name": "ball", "position": [0, 3, 0], "shape": {"type": "sphere", "radius": 0.1}}],
          "joints": [{"name": "rod", "kind": "distance", "a": "world", "b": "ball",
            "anchor_a": [0, 1, 0], "anchor_b": [0, 0, 0], "length": 1.2}],
          "surface_joints": [{"name": "touch", "a": {"body": "ball"}, "b": {"body": "table"},
            "motion": "rolling"}], "drift_bound": 1e-9}""")
        for command in ("run", "check"):
            done = pantin(command, self.scene)
            self.assertEqual(done.returncode, 2)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn("found surfaces 2.9 m apart", done.stderr)
            self.assertIn("`pantin assemble` brings bodies together", done.stderr)
        told = self.told("--out", self.out)
        self.assertGreater(told["moved_m"], 1)
        self.is_closed()

    def test_bad_paths_are_refused_where_they_stand(self):
        for free, words in (
                ('"joints/9/length"', 'found "joints/9/length", expected in place of "9" the name of a joint'),
                ('"joints/fuor/length"', 'nearest is "four"'),
                ('"bodies/0/mass"', 'expected a path such as "joints/3/length"'),
                ('"joints/0/mass"', 'expected a path such as'),
                ('"joints/0/axis_a"', 'expected an axis of a joint that has one'),
                ('3', 'found 3, expected a path such as'),
                ('{"of": "joints/0/length", "min": 5}', 'expected bounds that its value, 1.118'),
                ('{"of": "joints/0/length", "min": 2, "max": 1}', 'expected a "min" of at most "max"'),
                ('{"of": "joints/0/anchor_a", "max": 1}', 'beside a quantity of one number only'),
                ('{"min": 1}', 'found no "of"')):
            with self.subTest(free):
                self.write(',\n  "free": [' + free + ']')
                done = pantin("check", self.scene)
                self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
                self.assertIn(words, done.stderr)
                self.assertIn("frame.json5:12:", done.stderr)
        self.write("")
        done = pantin("assemble", self.scene, "--free", "joints/9/length")
        self.assertEqual(done.returncode, 2)
        self.assertTrue(done.stderr.startswith('pantin: --free: found "joints/9/length"'))
        done = pantin("assemble", self.scene, "--free", "joints/3/length", "--method", "gradient")
        self.assertEqual(done.returncode, 2)
        self.assertIn("expected auto, gauss-newton or lm", done.stderr)


if __name__ == "__main__":
    unittest.main()
