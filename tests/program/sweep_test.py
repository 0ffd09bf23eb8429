"""pantin sweep, seen from outside: the same bytes however it runs, and nothing lost that is killed."""
import csv
import json
import os
import pathlib
import shlex
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PANTIN = os.environ["PANTIN"]
FARM = pathlib.Path(__file__).parents[2] / "tools/farm"
ROD = {"name": "rod", "position": [0.5, 0, 0], "mass": 1, "inertia": [0.02, 0.1, 0.1], "drag": 0}
PENDULUM = {"version": 1, "step": 0.01, "duration": 1, "bodies": [ROD],
            "joints": [{"name": "pivot", "kind": "hinge", "a": "world", "b": "rod",
                        "anchor": [0, 0, 0], "axis": [0, 0, 1]}]}
# About a tenth of a second of CPU time for each job.
LONG = {**PENDULUM, "step": 0.001, "duration": 60}


def words_of(pid):
    """The command line of a process, or nothing."""
    try:
        return pathlib.Path(f"/proc/{pid}/cmdline").read_text()
    except OSError:
        return ""


def children(process):
    try:
        return [int(p) for p in pathlib.Path(f"/proc/{process}/task/{process}/children").read_text().split()]
    except FileNotFoundError:
        return []


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while not (found := condition()):
        if time.monotonic() > end:
            raise AssertionError("waited too long")
        time.sleep(0.005)
    return found


class Sweep(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)

    def scene(self, scene, name="scene.json"):
        (self.folder / name).write_text(json.dumps(scene))
        return name

    def words(self, *arguments, out):
        return [PANTIN, "sweep", *map(str, arguments[:arguments.index("--")] if "--" in arguments
                                      else arguments), "--out", out,
                *(arguments[arguments.index("--"):] if "--" in arguments else [])]

    def sweep(self, *arguments, out="out", code=0):
        done = subprocess.run(self.words(*arguments, out=out), cwd=self.folder, text=True, timeout=240,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def results(self, out="out"):
        return (self.folder / out / "results.jsonl").read_bytes()

    def lines(self, out="out"):
        return [json.loads(line) for line in self.results(out).splitlines()]

    def attempts(self, out="out"):
        text = (self.folder / out / "times.jsonl").read_text()
        return [json.loads(line)["machine"]["attempts"] for line in text.splitlines()]

    def files(self, out="out"):
        """When each result was written: a rename changes the inode."""
        return {path.name: path.stat().st_ino for path in (self.folder / out / "jobs").glob("*.json")}

    def test_a_grid_sets_what_it_says(self):
        self.scene(PENDULUM)
        self.sweep("scene.json", "--over", "/bodies/rod/mass=1..4:4", "--over", "step=0.01,0.005")
        lines = self.lines()
        self.assertEqual(len(lines), 8)
        self.assertEqual([line["id"] for line in lines], sorted(line["id"] for line in lines))
        self.assertEqual({(line["set"]["/bodies/rod/mass"], line["set"]["step"]) for line in lines},
                         {(m, s) for m in (1, 2, 3, 4) for s in (0.01, 0.005)})
        for line in lines:
            self.assertEqual(line["result"]["step_s"], line["set"]["step"])
            alone = subprocess.run([PANTIN, *line["command"]], cwd=self.folder, capture_output=True,
                                   text=True)
            self.assertEqual(json.loads(alone.stdout)["hash"], line["result"]["hash"])
            self.assertNotIn("frame_ms_median", line["result"])
        # The motion of a pendulum does not depend on its mass alone, if its inertia stays.
        self.assertEqual(len({line["result"]["hash"] for line in lines}), 8)
        with open(self.folder / "out/results.csv", newline="") as table:
            rows = list(csv.DictReader(table))
        self.assertEqual([row["hash"] for row in rows], [line["result"]["hash"] for line in lines])
        self.assertEqual([float(row["set:step"]) for row in rows],
                         [line["set"]["step"] for line in lines])

    def test_values(self):
        self.scene(PENDULUM)
        for over, wanted in (("/bodies/rod/mass=1..100:3", [1, 10, 100]),
                             ("/bodies/rod/mass=1..2:3", [1, 1.5, 2]),
                             ("/bodies/rod/mass=3..5", [3, 4, 5]),
                             ("/gravity=[0,-1,0],[0,-2,0]", [[0, -1, 0], [0, -2, 0]]),
                             ("/bodies/rod/mass,/bodies/rod/drag=1,2", [1, 2])):
            with self.subTest(over):
                emitted = self.sweep("scene.json", "--over", over, "--emit", "-").stdout
                given = [[json.loads(word.split("=", 1)[1]) for word in shlex.split(line)
                          if word.startswith("/") and "=" in word] for line in emitted.splitlines()]
                count = over.split("=")[0].count(",") + 1
                self.assertEqual([json.dumps([w] * count) for w in wanted],
                                 [json.dumps(g) for g in given])

    def test_the_same_bytes_in_any_order_by_any_number_and_by_a_farm(self):
        self.scene(PENDULUM), self.scene({**PENDULUM, "gravity": [0, -2, 0]}, "moon 'x'.json")
        words = ["scene.json", "moon 'x'.json", "--over", "/bodies/rod/mass=1..3"]
        self.sweep(*words, "--jobs", 1, out="one")
        self.sweep(*words, "--jobs", 5, out="many")
        turned = ["moon 'x'.json", "scene.json", "--over", "/bodies/rod/mass=3,2,1"]
        self.sweep(*turned, out="turned")
        self.sweep(*words, "--emit", "jobs.txt", out="farm")
        self.assertFalse((self.folder / "farm").exists())
        lines = (self.folder / "jobs.txt").read_text().splitlines()
        self.assertEqual(len(lines), 6)
        for line in [*reversed(lines), lines[2]]:  # any number of times
            subprocess.run(line, shell=True, cwd=self.folder, check=True)
        before = self.files("farm")
        self.sweep(*words, out="farm")
        self.assertEqual(self.files("farm"), before)
        for out in ("many", "turned", "farm"):
            self.assertEqual(self.results(out), self.results("one"), out)
            self.assertEqual((self.folder / out / "results.csv").read_bytes(),
                             (self.folder / "one/results.csv").read_bytes())

    def test_a_farm_of_threads(self):
        self.scene(PENDULUM)
        words = ["scene.json", "--over", "/bodies/rod/mass=1..4"]
        self.sweep(*words, "--emit", "jobs.txt", out="farm")
        subprocess.run([sys.executable, "-B", FARM, "jobs.txt", "--workers", "3"], cwd=self.folder,
                       check=True, stdout=subprocess.DEVNULL)
        before = self.files("farm")
        self.assertEqual(len(before), 4)
        self.sweep(*words, out="farm"), self.sweep(*words, out="local")
        self.assertEqual(self.files("farm"), before)
        self.assertEqual(self.results("farm"), self.results("local"))

    def start(self, *arguments, out):
        return subprocess.Popen(self.words(*arguments, out=out), cwd=self.folder,
                                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)

    def test_a_killed_job_is_run_again(self):
        self.scene(LONG)
        words = ["scene.json", "--over", "/bodies/rod/mass=1..4", "--jobs", 2]
        self.sweep(*words, out="whole")
        self.assertEqual(self.attempts("whole"), [1] * 4)
        run = self.start(*words, out="killed")
        victim = wait_for(lambda: children(run.pid))[0]
        os.kill(victim, signal.SIGKILL)
        self.assertEqual(run.wait(timeout=240), 0)
        self.assertEqual(sorted(self.attempts("killed")), [1, 1, 1, 2])
        self.assertEqual(self.results("killed"), self.results("whole"))

    def test_what_is_killed_again_and_again_is_told_and_run_by_the_next_sweep(self):
        self.scene(LONG)
        run = self.start("scene.json", "--retries", 1, out="out")
        killed = set()
        while run.poll() is None:
            for victim in children(run.pid):
                try:
                    os.kill(victim, signal.SIGKILL)
                    killed.add(victim)
                except ProcessLookupError:
                    pass
            time.sleep(0.005)
        self.assertEqual((run.returncode, len(killed)), (1, 2))
        self.assertEqual([line["status"] for line in self.lines()], ["killed"])
        self.assertEqual(self.files(), {})
        self.sweep("scene.json", "--retries", 1)
        self.assertEqual([line["status"] for line in self.lines()], ["ok"])

    def test_a_killed_sweep_goes_on_and_leaves_no_process(self):
        self.scene(LONG)
        words = ["scene.json", "--over", "/bodies/rod/mass=1..6"]
        self.sweep(*words, "--jobs", 3, out="whole")
        for how in (signal.SIGKILL, signal.SIGINT):
            out = how.name
            run = self.start(*words, "--jobs", 2, out=out)
            wait_for(lambda: (self.folder / out / "jobs").exists() and len(self.files(out)) >= 2)
            # Those that run their own command: before that they end with nobody.
            began = lambda: [w for w in children(run.pid) if words_of(w) not in ("", words_of(run.pid))]
            wait_for(began)
            workers = began()
            for worker in workers:  # one that is stopped does not end by itself
                try:
                    os.kill(worker, signal.SIGSTOP)
                except ProcessLookupError:
                    pass
            run.send_signal(how)
            code = run.wait(timeout=60)
            self.assertEqual(code, -signal.SIGKILL if how == signal.SIGKILL else 130)
            left = lambda: [w for w in workers if os.path.exists(f"/proc/{w}/exe")]
            try:
                wait_for(lambda: not left(), 20)
            finally:
                for worker in left():
                    os.kill(worker, signal.SIGKILL)
            before = self.files(out)
            self.assertLess(len(before), 6)
            self.sweep(*words, "--jobs", 1, out=out)
            after = self.files(out)
            self.assertEqual({name: after[name] for name in before}, before)
            self.assertEqual(self.results(out), self.results("whole"))
            self.assertEqual(list((self.folder / out / "jobs").glob("*.part")), [])

    def test_a_file_that_was_cut_off_counts_for_nothing(self):
        self.scene(PENDULUM)
        words = ["scene.json", "--over", "/bodies/rod/mass=1,2"]
        self.sweep(*words)
        before = self.results()
        path = next((self.folder / "out/jobs").glob("*.json"))
        path.write_text(path.read_text()[:50])
        self.sweep(*words)
        self.assertEqual(self.results(), before)

    def test_a_changed_scene_is_run_again_and_another_folder_is_not_asked(self):
        self.scene(PENDULUM)
        self.sweep("scene.json")
        first = self.lines()[0]["result"]["hash"], self.files()
        self.sweep("scene.json")
        self.assertEqual((self.lines()[0]["result"]["hash"], self.files()), first)
        self.scene({**PENDULUM, "gravity": [0, -1, 0]})
        self.sweep("scene.json")
        self.assertNotEqual(self.lines()[0]["result"]["hash"], first[0])

    def test_late_jobs_are_told_and_left_for_the_next_sweep(self):
        self.scene({**LONG, "duration": 9000})
        done = self.sweep("scene.json", "--limit", 0.2, "--json", code=1)
        self.assertEqual(json.loads(done.stdout)["counts"], {"late": 1})
        self.assertEqual(self.files(), {})
        self.scene(PENDULUM)
        self.sweep("scene.json", "--limit", 60)
        self.assertEqual([line["status"] for line in self.lines()], ["ok"])

    def test_a_divergence_is_a_result_and_folders_hold_files(self):
        self.scene(PENDULUM)
        # Without stabilisation the joint opens, and --strict ends with 3.
        self.sweep("scene.json", "--over", "/gravity=[0,-0.001,0],[0,-1,0]", "--", "run", "--json",
                   "--solver", "lagrangian", "--integrator", "euler", "--stabilisation", "none",
                   "--strict", "--record", "{folder}/motion.csv")
        self.assertEqual({line["set"]["/gravity"][1]: line["status"] for line in self.lines()},
                         {-0.001: "ok", -1: "diverged"})
        for line in self.lines():
            motion = self.folder / "out/jobs" / line["id"] / "motion.csv"
            self.assertGreater(len(motion.read_text().splitlines()), 2)
            self.assertIn("{folder}/motion.csv", line["command"])
        self.assertEqual(len(self.files()), 2)

    def test_a_list_of_commands(self):
        self.scene(PENDULUM)
        (self.folder / "list.txt").write_text(
            "# two, one of them twice\nrun --json scene.json\n\n"
            "pantin run scene.json --json --set 'gravity=[0, -1, 0]'\nrun --json scene.json\n")
        done = self.sweep("--list", "list.txt", "--json")
        self.assertEqual(json.loads(done.stdout)["jobs"], 2)
        self.assertEqual(len({line["result"]["hash"] for line in self.lines()}), 2)

    def test_a_sweep_of_failures_says_why(self):
        """Of choices that cannot be written: the body has a solver of its own."""
        own = [{**body, "solver": {"type": "lagrangian"}} for body in PENDULUM["bodies"]]
        self.scene({**PENDULUM, "bodies": own})
        done = self.sweep("scene.json", "--over", "error=0.1,0.2", "--", "tune", "--methods", "auto", "--within",
                          "5", "--out", "none.json", "--results", "{folder}", code=1)
        self.assertIn("2 failed", done.stdout)
        self.assertRegex(done.stderr, r"job [0-9a-f]+ failed: .*solver settings of single bodies")

    def test_bad_input(self):
        self.scene(PENDULUM)
        (self.folder / "bad.txt").write_text("run scene.json\nrun 'scene.json\n")
        for words, told in (([], "no scene"), (["scene.json", "--over", "mass"], "NAME=A..B"),
                            (["scene.json", "--over", "/a=1..0.5:3"], "NAME=A..B"),
                            (["scene.json", "--over", "/a=1..2:1"], "NAME=A..B"),
                            (["scene.json", "--over", "step=5..1"], "the range goes down from 5 to 1"),
                            (["scene.json", "--over", "/a=0.1..2"], "there is no :COUNT"),
                            (["scene.json", "--over", "/a=0.5..2"], "NAME=A..B"),
                            (["scene.json", "--over", "/a=1..1000000", "--over", "/b=1,2"], "jobs"),
                            (["--list", "bad.txt"], "bad.txt:2: found no closing '"),
                            (["--list", "none.txt"], "none.txt"),
                            (["scene.json", "--list", "bad.txt"], "expected the list alone"),
                            (["--one"], "no command after --"),
                            (["scene.json", "--", "sweep"], "expected another one"),
                            (["scene.json", "--over", "/bodies/rod/mas=1"], "found key \"mas\""),
                            (["scene.json", "--over", "nonsense=1"], "--nonsense"),
                            (["none.json"], "none.json")):
            with self.subTest(told):
                done = self.sweep(*words, code=2)
                self.assertIn(told, done.stderr)
                self.assertEqual(done.stderr.count("\n"), 1)


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
