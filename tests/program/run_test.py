"""pantin run, seen from outside: exit codes, JSON, records, frames, interrupts, hashes."""
import csv
import json
import os
import pathlib
import re
import resource
import signal
import stat
import subprocess
import sys
import tempfile
import time
import unittest

PANTIN = os.environ["PANTIN"]
SCENES = pathlib.Path(os.environ["PANTIN_ASSETS"]) / "scenes"
CHAIN, MARIONETTE = str(SCENES / "chain.json"), str(SCENES / "marionette.json")

KEYS = """scene status solver step_s steps bodies joints worst_gap_m worst_gap_rel energy_start_j
energy_end_j energy_max_j ns_per_link_step_median ns_per_link_step_p99 frame_ms_median frame_ms_p99
allocations_per_step hash frames_written warnings unreached""".split()


def pantin(*arguments, **options):
    return subprocess.run([PANTIN, *map(str, arguments)], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=120,
                          **options)


def run_json(*arguments):
    done = pantin("run", *arguments, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def can_draw():
    with tempfile.TemporaryDirectory() as folder:
        return pantin("run", CHAIN, "--frames", folder, "--size", "32x32", "--duration",
                      "0.02").returncode != 1


def own_device(folder, name, minor):
    """A device like /dev/`name` that may come to harm, where one can be made; else that one."""
    try:
        os.mknod(folder / name, 0o666 | stat.S_IFCHR, os.makedev(1, minor))
        (folder / name).open("w").close()
        return folder / name
    except OSError:
        return pathlib.Path("/dev") / name


class Run(unittest.TestCase):
    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)

    def tearDown(self):
        self.kept.cleanup()

    def assert_refused(self, done, *words):
        """Exit 2, nothing on standard output, one line that holds all the words."""
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)

    def assert_refused_lines(self, done, *words):
        """The same with a line for each fault."""
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stdout, "")
        for line in done.stderr.splitlines():
            for word in words:
                self.assertIn(word, line)

    def test_a_run_that_was_saved_and_loaded_ends_in_the_same_bits(self):
        state, other = self.folder / "half.world", self.folder / "other.world"
        half = run_json(MARIONETTE, "--duration", "0.5", "--save", state)
        rest = run_json(MARIONETTE, "--duration", "0.5", "--load", state)
        whole = run_json(MARIONETTE, "--duration", "1")
        self.assertEqual(half["steps"] + rest["steps"], whole["steps"])
        self.assertNotEqual(half["hash"], whole["hash"])
        self.assertEqual(rest["hash"], whole["hash"])
        other.write_bytes(state.read_bytes()[:-1])
        self.assert_refused(pantin("run", MARIONETTE, "--load", other), "other.world", "expected")
        missing = self.folder / "none" / "state.world"
        done = pantin("run", CHAIN, "--duration", "0.02", "--save", missing)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn(str(missing), done.stderr)

    def test_events_happen_and_a_saved_run_goes_on_with_them(self):
        scene = SCENES / "standing.json"  # pushed at 2 s and at 5.4 s
        quiet = self.folder / "quiet.json"
        whole = json.loads(scene.read_text())
        del whole["events"]
        quiet.write_text(json.dumps(whole))
        self.assertEqual(run_json(scene, "--duration", 1.9)["energy_end_j"],
                         run_json(quiet, "--duration", 1.9)["energy_end_j"])
        pushed = run_json(scene, "--duration", 6.5)
        self.assertLess(pushed["energy_end_j"], run_json(quiet, "--duration", 6.5)["energy_end_j"] - 50)
        state = self.folder / "half.world"
        run_json(scene, "--duration", 5.5, "--save", state)  # within the second push
        rest = run_json(scene, "--duration", 1, "--load", state, "--threads", 3)
        self.assertEqual(rest["hash"], pushed["hash"])

    def test_the_record_of_a_joint_that_is_cut_ends(self):
        path = self.folder / "r.csv"
        told = run_json(SCENES / "cut.json", "--duration", 0.6, "--record", path)
        self.assertEqual((told["status"], told["joints"]), ("ok", 24))
        rows = list(csv.DictReader(path.open()))
        gaps = [key for key in rows[0] if key.endswith(".gap_m")]
        self.assertEqual(len(gaps), 25)
        for row in rows:
            time, cut = float(row["time_s"]), row["chain/11-12.gap_m"] == ""
            self.assertEqual(cut, time > 0.51, time)
            self.assertTrue(all(row[key] != "" for key in row if key != "chain/11-12.gap_m"))

    def test_joints_that_contradict_one_another_are_refused_before_anything_is_written(self):
        with tempfile.TemporaryDirectory() as folder:
            scene, record = pathlib.Path(folder) / "s.json", pathlib.Path(folder) / "r.csv"
            joint = {"a": "world", "b": "rod", "kind": "ball"}
            scene.write_text(json.dumps({
                "version": 1, "step": 0.01, "duration": 1, "solver": {"type": "lagrangian"},
                "bodies": [{"name": "rod", "mass": 1, "inertia": [0.1, 0.1, 0.1]}],
                "joints": [{**joint, "name": "p", "anchor": [0, 0, 0]},
                           {**joint, "name": "q", "anchor_a": [1.1, 0, 0], "anchor_b": [1, 0, 0]}]}))
            done = pantin("run", scene, "--record", record)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertFalse(record.exists())
            # At the first of them, as every complaint about a scene.
            place = re.escape(str(scene)) + r":1:\d+: /joints/0: found inconsistent joints"
            self.assertRegex(done.stderr, place)
            for word in ("p, q stay open by up to 0.", "expected"):
                self.assertIn(word, done.stderr)

    def test_json_has_its_keys_and_sound_numbers(self):
        told = run_json(CHAIN, "--duration", 1)
        self.assertEqual([key for key in KEYS if key not in told], [])
        self.assertEqual((told["status"], told["solver"]), ("ok", "auto"))
        self.assertEqual((told["steps"], told["bodies"], told["joints"]), (60, 21, 20))
        self.assertEqual(told["frames_written"], 0)
        self.assertEqual(told["unreached"], [])
        self.assertTrue(0 <= told["worst_gap_rel"] < 1e-12)
        self.assertGreaterEqual(told["energy_max_j"], told["energy_start_j"])
        self.assertGreater(told["ns_per_link_step_p99"], 0)
        self.assertRegex(told["hash"], "^[0-9a-f]{16}$")

    def test_pins_out_of_reach_are_named(self):
        told = run_json(SCENES / "unreachable.json")
        self.assertEqual([u["name"] for u in told["unreached"]], ["pull"])
        self.assertAlmostEqual(told["unreached"][0]["residual_m"], 0.2263, delta=0.01)
        self.assertTrue(any("/pins/0" in line for line in told["warnings"]))

    def test_hashes_repeat_whatever_the_threads(self):
        crowd = SCENES / "crowd.json"
        hashes = {run_json(crowd, "--duration", 0.5, "--threads", n)["hash"] for n in (1, 1, 2, 4)}
        self.assertEqual(len(hashes), 1)
        self.assertNotEqual(run_json(CHAIN, "--duration", 0.5)["hash"],
                            run_json(CHAIN, "--duration", 0.5, "--solver", "sweep")["hash"])
        shown = pantin("run", CHAIN, "--duration", 1, "--hash").stdout
        self.assertIn(run_json(CHAIN, "--duration", 1)["hash"], shown)

    def test_the_solver_of_every_part_is_told(self):
        gate = SCENES / "gate.json"  # a rope tied to it goes by the gate's solver
        told = run_json(gate, "--duration", 0.1)
        self.assertEqual((told["solver"], told["solvers"]), ("lagrangian", {"lagrangian": 15}))
        ball = {"shape": {"type": "sphere", "radius": 0.1}, "density": 100}
        bodies = [ball | {"name": "a", "position": [0, 0, 0]}, ball | {"name": "b", "position": [9, 0, 0]}]
        bodies[1]["solver"] = {"type": "lagrangian"}
        with tempfile.TemporaryDirectory() as folder:
            mixed = pathlib.Path(folder) / "mixed.json"
            mixed.write_text(json.dumps({"version": 1, "bodies": bodies}))
            told = run_json(mixed, "--duration", 0.1)
            self.assertEqual((told["solver"], told["solvers"]), ("mixed", {"auto": 1, "lagrangian": 1}))
            shown = pantin("run", mixed, "--duration", 0.1).stdout
            for solver in told["solvers"]:
                self.assertIn(f"{solver} (1 bodies)", shown)
        told = run_json(gate, "--duration", 0.1, "--solver", "lagrangian")
        self.assertEqual((told["solver"], list(told["solvers"])), ("lagrangian", ["lagrangian"]))
        told = run_json(SCENES / "four_bar.json", "--duration", 0.1)
        self.assertEqual(told["solver"], "lagrangian")

    def test_every_solver_runs(self):
        for solver in ("auto", "sweep", "shake2", "procedural"):
            told = run_json(CHAIN, "--duration", 0.5, "--solver", solver)
            # Two keep no account of energy, and throw this chain.
            status = "doubtful" if solver in ("sweep", "shake2") else "ok"
            self.assertEqual((told["solver"], told["status"]), (solver, status))

    def test_an_old_name_of_a_solver_is_read_with_a_warning(self):
        done = pantin("run", CHAIN, "--duration", 0.1, "--json", "--solver", "paper")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads(done.stdout)["solver"], "procedural")
        self.assertIn('warning: --solver: "paper" is now called "procedural"',
                      done.stderr.splitlines())

    def test_a_record_changes_nothing(self):
        for scene in ("chain", "marionette", "stairs", "standing", "mobile", "pinned_chain",
                      "four_bar", "gate"):
            path = SCENES / f"{scene}.json"
            plain = run_json(path, "--duration", 0.3)
            told = run_json(path, "--duration", 0.3, "--record", self.folder / "r.csv")
            self.assertEqual((scene, told["hash"]), (scene, plain["hash"]))

    def test_cables_and_muscles_are_refused_with_solvers_that_do_not_know_them(self):
        for solver in ("sweep", "shake2", "procedural"):
            self.assert_refused_lines(pantin("run", MARIONETTE, "--solver", solver),
                                      "cable", solver, "auto")
            self.assert_refused_lines(pantin("run", SCENES / "standing.json", "--solver", solver),
                                      "drive", solver, "auto")

    def test_energy_that_grows_by_itself_ends_the_run(self):
        done = pantin("run", CHAIN, "--solver", "sweep", "--duration", 2, "--json")
        self.assertEqual(done.returncode, 3, done.stderr)
        told = json.loads(done.stdout)
        self.assertEqual(told["status"], "energy_grew")
        self.assertIn("body", told["lost"])
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        for word in ("chain.json", "energy", "sweep", told["lost"]["body"]):
            self.assertIn(word, done.stderr)
        # It is told long before it is out of all bounds.
        self.assertLess(told["energy_max_j"] - told["energy_start_j"], 1000)

    def test_step_and_duration_decide_the_number_of_steps(self):
        told = run_json(CHAIN, "--step", 0.01, "--substeps", 3, "--duration", 0.5)
        self.assertEqual((told["step_s"], told["steps"]), (0.01, 50))

    def test_bad_usage_is_one_line(self):
        self.assert_refused(pantin("dance"), "dance")
        self.assert_refused(pantin("run"), "required")
        self.assert_refused(pantin("run", CHAIN, "--no-such-option"), "--no-such-option")
        for option, value in (("--step", "-1"), ("--step", "0"), ("--step", "soon"),
                              ("--step", "nan"), ("--duration", "inf"), ("--duration", "-3"),
                              ("--fps", "0"), ("--threads", "0"), ("--threads", "two"),
                              ("--substeps", "1.5"), ("--solver", "magic"), ("--gl", "vulkan"),
                              ("--size", "640"), ("--size", "0x0"), ("--size", "640x480x3")):
            with self.subTest(option=option, value=value):
                self.assert_refused(pantin("run", CHAIN, "--frames", self.folder, option, value),
                                    option)
        self.assertEqual(os.listdir(self.folder), [])
        self.assert_refused(pantin("run", CHAIN, "--durration", 1), "nearest", "--duration")
        self.assert_refused(pantin("runs", CHAIN), "runs", "run")
        self.assert_refused(pantin("run", CHAIN, "--step", 1e-6, "--duration", 1e6), "steps")

    def test_options_of_pictures_are_refused_where_none_are_drawn(self):
        for option in (("--size", "64x36"), ("--fps", 12), ("--overlay",), ("--strip-rows", 3)):
            with self.subTest(option=option):
                self.assert_refused(pantin("run", CHAIN, *option), option[0], "expected", "with it")
        self.assert_refused(pantin("run", CHAIN, "--frames", self.folder, "--strip-columns", 3),
                            "--strip-columns", "expected --strip")

    def test_options_of_the_lagrangian_solver_are_refused_where_they_do_nothing(self):
        for command in ("run", "check", "bench"):
            for option, value in (("--integrator", "rk4"), ("--tolerance", "1e-6"),
                                  ("--stabilisation", "none"), ("--jacobians", "differences")):
                with self.subTest(command=command, option=option):
                    done = pantin(command, CHAIN, option, value)
                    self.assertEqual(done.returncode, 2)
                    self.assertEqual(done.stderr, f"{CHAIN}: found {option}, expected a scene "
                                     'solved by "lagrangian"; add --solver lagrangian\n')
        self.assert_refused(pantin("run", CHAIN, "--solver", "lagrangian", "--integrator", "euler",
                                   "--tolerance", "1e-6"), "--tolerance", '"euler"', 'rk4 or radau only')
        for option, value in (("--integrator", "rk5"), ("--tolerance", "0"), ("--tolerance", "-1"),
                              ("--tolerance", "nan"), ("--stabilisation", "some"),
                              ("--jacobians", "exact")):
            with self.subTest(option=option, value=value):
                self.assert_refused(pantin("run", CHAIN, "--solver", "lagrangian", option, value),
                                    option)

    def test_bad_scenes_are_refused_with_their_place(self):
        self.assert_refused(pantin("run", "nowhere.json"), "nowhere.json")
        bad = self.folder / "bad.json"
        bad.write_text('{"version": 1,\n "bodys": []}')
        self.assert_refused(pantin("run", bad), f"{bad}:2:2", "bodys", "bodies")

    def test_help_has_examples_and_exit_codes(self):
        for command in ((), ("run",), ("check",), ("bench",), ("doctor",), ("view",), ("schema",),
                        ("surface",), ("new",), ("completion",), ("help",)):
            done = pantin(*command, "--help")
            self.assertEqual(done.returncode, 0)
            self.assertIn("Examples:", done.stdout)
            self.assertIn("Exit codes", done.stdout)
        for key in KEYS:
            self.assertIn(key, pantin("run", "--help").stdout)
        self.assertRegex(pantin("--version").stdout, r"^pantin \d+\.\d+")

    def test_record_holds_every_step(self):
        path = self.folder / "deep" / "chain.csv"
        path.parent.mkdir()
        told = run_json(CHAIN, "--duration", 0.5, "--record", path)
        header, *rows = csv.reader(path.open())
        self.assertEqual(len(rows), told["steps"] + 1)  # the start is a row too
        self.assertEqual({len(row) for row in rows}, {len(header)})
        self.assertEqual(len(header), len(set(header)))
        self.assertTrue(header[0].startswith("time"))
        times = [float(row[0]) for row in rows]
        self.assertEqual(times[0], 0)
        for earlier, later in zip(times, times[1:]):
            self.assertAlmostEqual(later - earlier, 1 / 60, places=12)
        column = {name: [float(row[i]) for row in rows] for i, name in enumerate(header)}
        self.assertEqual(sum(name.startswith("top.") for name in header), 13)
        gaps = [name for name in header if ".gap" in name]
        self.assertEqual(len(gaps), told["joints"])
        self.assertEqual(max(max(column[name]) for name in gaps), told["worst_gap_m"])
        energy = next(values for name, values in column.items() if name.startswith("energy"))
        self.assertEqual((energy[0], energy[-1]), (told["energy_start_j"], told["energy_end_j"]))
        self.assertEqual(os.listdir(path.parent), ["chain.csv"])

    def test_places_that_cannot_be_written_are_exit_4_before_the_run(self):
        start = time.monotonic()
        long_run = ("--duration", 100000)
        for option in ("--record", "--frames"):
            done = pantin("run", CHAIN, *long_run, option, "/proc/pantin/out.csv")
            self.assertEqual(done.returncode, 4 if option == "--record" or can_draw() else 1)
            self.assertIn("/proc/pantin", done.stderr)
        self.assertLess(time.monotonic() - start, 60)

    def test_standard_output_that_cannot_be_written_is_exit_4(self):
        with open("/dev/full", "w") as full:
            done = subprocess.run([PANTIN, "run", CHAIN, "--json"], stdout=full,
                                  stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 4)
        self.assertIn("standard output", done.stderr)

    def test_a_reader_that_goes_away_costs_no_file(self):
        record = self.folder / "chain.csv"
        reader, writer = os.pipe()
        os.close(reader)
        done = subprocess.run([PANTIN, "run", CHAIN, "--duration", "0.5", "--record", record],
                              stdout=writer, stderr=subprocess.PIPE, text=True)
        os.close(writer)
        self.assertEqual(done.returncode, 4)
        self.assertEqual(len(record.read_text().splitlines()), 32)

    def test_a_device_stays_a_device(self):
        done = pantin("run", CHAIN, "--duration", 0.5, "--record", "/dev/full")
        self.assertEqual(done.returncode, 4)
        self.assertIn("/dev/full", done.stderr)
        self.assertTrue(pathlib.Path("/dev/full").is_char_device())

    def test_a_disk_that_is_full_costs_no_older_record(self):
        """A limit on the size of files stands for the disk: writing beyond it fails alike."""
        record = self.folder / "chain.csv"
        record.write_text("whole\n")
        for room, most_bytes, duration in (("mid-run", 30000, 2), ("at the end", 100, 0.05)):
            def fill_the_disk():
                resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

            with self.subTest(room):
                done = pantin("run", CHAIN, "--duration", duration, "--record", record, "--json",
                              preexec_fn=fill_the_disk)
                self.assertEqual(done.returncode, 4, done.stderr)
                self.assertEqual(json.loads(done.stdout)["status"], "unwritable")
                self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
                self.assertIn(str(record), done.stderr)
                self.assertEqual(record.read_text(), "whole\n")
                self.assertEqual(os.listdir(self.folder), ["chain.csv"])

    def test_standard_output_takes_a_record_and_stays_what_it_is(self):
        lines = pantin("run", CHAIN, "--duration", 0.1, "--record", "/dev/stdout").stdout.splitlines()
        self.assertTrue(lines[0].startswith("time_s,"))
        path = self.folder / "out.csv"
        for name in ("/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"):
            with self.subTest(name), path.open("w") as out:
                out.write("head\n")
                out.flush()
                subprocess.run([PANTIN, "run", CHAIN, "--duration", "0.1", "--record", name],
                               stdout=out, check=True)
                head, *found = path.read_text().splitlines()
                self.assertEqual(head, "head")
                self.assertEqual(len(found), len(lines))
                rows = [line for line in lines if line.count(",") == lines[0].count(",")]
                self.assertEqual(len(rows), 8)
                self.assertEqual([line for line in found if line in rows], rows)
        self.assertTrue(pathlib.Path("/dev/stdout").is_symlink())

    def test_standard_output_takes_a_saved_world(self):
        path = self.folder / "out.world"
        with path.open("w") as out:
            subprocess.run([PANTIN, "run", CHAIN, "--duration", "0.1", "--save", "/dev/stdout"],
                           stdout=out, check=True)
        self.assertIn(b"PTNWORLD", path.read_bytes())

    def test_a_link_to_a_record_stays_a_link(self):
        record, link = self.folder / "there.csv", self.folder / "link.csv"
        record.write_text("old")
        link.symlink_to(record.name)
        self.assertEqual(pantin("run", CHAIN, "--duration", 0.1, "--record", link).returncode, 0)
        self.assertTrue(link.is_symlink())
        self.assertTrue(record.read_text().startswith("time_s,"))

    def test_interrupts_leave_whole_files(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            record = self.folder / f"{number}.csv"
            process = subprocess.Popen(
                [PANTIN, "run", CHAIN, "--duration", "2000", "--record", record, "--json"],
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            part = record.with_name(record.name + ".part")
            limit = time.monotonic() + 30
            while not (part.exists() and part.stat().st_size > 100000):
                self.assertLess(time.monotonic(), limit)
                time.sleep(0.01)
            process.send_signal(number)
            out, _ = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 130)
            told = json.loads(out)
            self.assertEqual(told["status"], "interrupted")
            rows = list(csv.reader(record.open()))
            self.assertEqual(len(rows), told["steps"] + 2)
            self.assertEqual({len(row) for row in rows}, {len(rows[0])})
            self.assertFalse(part.exists())

    def test_nothing_but_plain_text_away_from_a_terminal(self):
        done = pantin("run", CHAIN, "--duration", 0.5)
        self.assertEqual(done.stderr, "")
        self.assertNotIn("\x1b", done.stdout)


@unittest.skipUnless(can_draw(), "no way to draw here")
class Pictures(Run):
    def frames(self, *arguments):
        folder = self.folder / "frames"
        told = run_json(*arguments, "--frames", folder, "--size", "64x36")
        names = sorted(os.listdir(folder))
        self.assertEqual(names, [f"frame_{k:06}.png" for k in range(told["frames_written"])])
        return [(folder / name).read_bytes() for name in names]

    def test_frames_are_numbered_and_whole(self):
        pictures = self.frames(CHAIN, "--duration", 0.5, "--fps", 24)
        self.assertIn(len(pictures), (12, 13))  # with or without the very end
        for picture in pictures:
            self.assertTrue(picture.startswith(b"\x89PNG\r\n\x1a\n"))
            self.assertEqual(picture[16:24], (64).to_bytes(4, "big") + (36).to_bytes(4, "big"))
            self.assertTrue(picture.endswith(b"IEND\xaeB\x60\x82"))
        self.assertGreater(len(set(pictures)), 8)

    def test_drawing_does_not_change_the_motion(self):
        plain = run_json(CHAIN, "--duration", 0.2)
        drawn = run_json(CHAIN, "--duration", 0.2, "--frames", self.folder, "--size", "64x36",
                         "--fps", 100, "--overlay")
        self.assertEqual(plain["hash"], drawn["hash"])

    def test_ways_to_opengl_that_do_not_work_are_told(self):
        environment = {**os.environ, "PANTIN_GL": "nonsense"}
        done = pantin("run", CHAIN, "--frames", self.folder, env=environment)
        self.assertEqual(done.returncode, 1)
        self.assertIn("nonsense", done.stderr)
        self.assertEqual(pantin("run", CHAIN, "--duration", 0.1, env=environment).returncode, 0)

    def test_a_picture_is_written_into_a_device(self):
        for name, minor, exit_code in (("null", 3, 0), ("full", 7, 4)):
            device = own_device(self.folder, name, minor)
            done = pantin("run", CHAIN, "--duration", 0.2, "--size", "64x36", "--strip", device)
            self.assertEqual(done.returncode, exit_code, done.stderr)
            self.assertTrue(device.is_char_device())
        pipe = self.folder / "pipe"
        os.mkfifo(pipe)
        reader = subprocess.Popen(["cat", pipe], stdout=subprocess.PIPE)
        done = pantin("run", CHAIN, "--duration", 0.2, "--size", "64x36", "--strip", pipe)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(reader.communicate(timeout=60)[0].endswith(b"IEND\xaeB\x60\x82"))
        self.assertTrue(pipe.is_fifo())

    def test_an_interrupt_keeps_the_frames(self):
        folder = self.folder / "frames"
        process = subprocess.Popen([PANTIN, "run", CHAIN, "--duration", "2000", "--frames", folder,
                                    "--size", "64x36", "--json"], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        limit = time.monotonic() + 60
        while not (folder.exists() and len(os.listdir(folder)) > 5):
            self.assertLess(time.monotonic(), limit)
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        names = sorted(os.listdir(folder))
        self.assertEqual(names, [f"frame_{k:06}.png"
                                 for k in range(json.loads(out)["frames_written"])])
        for name in names:
            self.assertTrue((folder / name).read_bytes().endswith(b"IEND\xaeB\x60\x82"))


def main():
    loader = unittest.defaultTestLoader
    tests = unittest.TestSuite([loader.loadTestsFromTestCase(Run)])
    for name in Pictures.__dict__:
        if name.startswith("test_"):
            tests.addTest(Pictures(name))
    result = unittest.TextTestRunner(stream=sys.stdout).run(tests)
    failed = len({str(test).split(" (")[0] for test, _ in result.failures + result.errors})
    print(f"{result.testsRun - len(result.skipped) - failed} passed, {failed} failed")
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
