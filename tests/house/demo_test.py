"""tools/demo with a make-believe CMake and program: what it builds, in which order it draws, what it
tells meanwhile."""
import pathlib
import shutil
import subprocess
import tempfile
import unittest

TOOLS = pathlib.Path(__file__).parents[2] / "tools"
NEEDED = ("bash", "dirname", "mkdir", "tail", "tee", "cat", "env", "chmod", "nproc",
          "basename")

CMAKE = """#!/bin/bash
echo "cmake $*" >>"$CALLS"
[[ $* == *--build* ]] || exit 0
for ((i = 1; i <= 40; ++i)); do echo "[$i/40] Building CXX object $i"; done
[[ -z $BROKEN ]] || { echo "error: no such header"; exit 1; }
mkdir -p build/release/bin
for name in pantin cookbook_frame; do
  [[ $* == *"--target $name "* ]] || continue
  echo "#!/bin/bash
echo $name "'"$(basename "$PWD") $*" >>"$CALLS"' >"build/release/bin/$name"
  chmod +x "build/release/bin/$name"
done
"""


class Demo(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.calls = self.root / "calls"
        (self.root / "bin").mkdir()
        (self.root / "tools").mkdir()
        for script in ("demo", "build"):
            shutil.copy(TOOLS / script, self.root / "tools")
        for tool in NEEDED:
            (self.root / "bin" / tool).symlink_to(shutil.which(tool))
        self.program("tools/setup", '#!/bin/bash\necho "setup $*" >>"$CALLS"\n')
        self.program("bin/cmake", CMAKE)

    def program(self, name, text):
        (self.root / name).write_text(text)
        (self.root / name).chmod(0o755)

    def demo(self, *arguments, broken=""):
        return subprocess.run([self.root / "tools/demo", *arguments], capture_output=True, text=True,
                              stdin=subprocess.DEVNULL,
                              env={"PATH": str(self.root / "bin"), "CALLS": str(self.calls),
                                   "BROKEN": broken})

    def test_builds_the_program_alone_and_draws_a_picture_before_the_runs(self):
        done = self.demo("--duration", "1")
        self.assertEqual(done.returncode, 0, done.stderr)
        setup, configure, library, first, _, _, program, *runs = self.calls.read_text().splitlines()
        self.assertEqual(setup, "setup --program")
        self.assertIn("--preset release", configure)
        self.assertIn("--target cookbook_frame --parallel", library)
        self.assertEqual(first.split(), ["cookbook_frame", "out"])
        self.assertIn("--target pantin --parallel", program)
        self.assertEqual([run.split()[3] for run in runs],
                         ["assets/scenes/chain.json", "assets/scenes/marionette.json"])
        for run in runs:
            self.assertIn("--video", run)
            self.assertTrue(run.endswith("--duration 1"))
        told = done.stdout
        self.assertEqual(told.count("% built"), 20, told)
        self.assertLess(told.index("100 % built"), told.index("out/ragdoll.png"))
        self.assertLess(told.index("out/ragdoll.png"), told.rindex(" 10 % built"))
        self.assertLess(told.rindex("100 % built"), told.index("Running chain"))

    def test_a_build_that_fails_says_why_and_ends_it(self):
        done = self.demo(broken="yes")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("error: no such header", done.stderr)
        self.assertNotIn("cookbook_frame out", self.calls.read_text())


if __name__ == "__main__":
    unittest.main()
