"""tools/setup against a make-believe apt: what it names, installs and says."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

SETUP = pathlib.Path(__file__).parents[2] / "tools" / "setup"
TOOLS = ("bash", "dirname", "mktemp", "rm", "cat", "env", "sed", "tail", "sh")


class Setup(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.bin = pathlib.Path(self.folder.name)
        for tool in TOOLS:
            (self.bin / tool).symlink_to(shutil.which(tool))
        self.installed = self.bin / "installed"
        self.calls = self.bin / "calls"
        self.lacking = self.bin / "lacking"
        self.installed.write_text("")
        self.lacking.write_text("")

    def tearDown(self):
        self.folder.cleanup()

    def program(self, name, text):
        path = self.bin / name
        path.write_text("#!/bin/bash\n" + text)
        path.chmod(0o755)

    def debian(self, apt='for p in "$@"; do echo "$p" >>"$INSTALLED"; done'):
        """A system where `installed` lists the packages and every apt-get call is written down."""
        self.program("dpkg-query", 'while read -r p; do\n'
                                   '  [[ $p == "${@: -1}" ]] && echo -n installed\n'
                                   'done <"$INSTALLED"')
        self.program("apt-cache", '(($# > 1)) || { echo 500 a-mirror Packages; exit; }\n'
                                  'while read -r p; do [[ $p != "$2" ]] || exit 0; '
                                  f'done <"{self.lacking}"\n'
                                  "echo '  Candidate: 1.0'")
        self.program("apt-get", f'echo "$*" >>"{self.calls}"\n{apt}')
        self.program("sudo", 'exec "$@"')

    def run_setup(self, *arguments):
        environment = {"PATH": str(self.bin), "INSTALLED": str(self.installed)}
        done = subprocess.run([SETUP, *arguments], env=environment, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL)
        return done.returncode, done.stdout, done.stderr

    def test_check_names_what_is_missing_and_installs_nothing(self):
        self.debian()
        self.installed.write_text("g++\ncmake\n")
        code, out, _ = self.run_setup("--check", "--core")
        self.assertEqual((code, out), (1, "Would install: make libglm-dev\n"))
        self.assertFalse(self.calls.exists())

    def test_check_is_content_with_a_whole_system(self):
        self.debian()
        self.installed.write_text("g++\ncmake\nmake\nlibglm-dev\n")
        code, out, _ = self.run_setup("--check", "--core")
        self.assertEqual((code, out), (0, "Nothing is missing.\n"))

    def test_a_second_run_does_nothing(self):
        self.debian()
        code, out, err = self.run_setup()
        self.assertEqual(code, 0, err)
        self.assertIn("libosmesa6", self.installed.read_text())
        calls = self.calls.read_text()
        code, out, _ = self.run_setup()
        self.assertEqual((code, out), (0, ""))
        self.assertEqual(self.calls.read_text(), calls)
        self.assertEqual(self.run_setup("--check")[0], 0)

    def test_the_program_needs_nothing_of_the_tests(self):
        self.debian()
        code, out, _ = self.run_setup("--check", "--program")
        self.assertEqual(code, 1)
        self.assertIn("libcli11-dev", out)
        for package in ("catch2", "python3", "clang-14", "xvfb"):
            self.assertNotIn(package, out.split())

    def test_what_a_release_lacks_is_done_without(self):
        self.debian()
        self.lacking.write_text("libosmesa6\nclang-14\nlibclang-rt-14-dev\n")
        code, _, err = self.run_setup()
        self.assertEqual(code, 0, err)
        installed = self.installed.read_text().split()
        self.assertNotIn("libosmesa6", installed)
        self.assertNotIn("clang-14", installed)
        self.assertIn("clang", installed)
        self.assertIn("libclang-rt-dev", installed)
        self.assertEqual(self.run_setup("--check")[0], 0)

    def test_without_lists_they_are_fetched_before_anything_is_chosen(self):
        self.debian('[[ $* == *update* ]] && echo >"$INSTALLED.fresh"\n'
                    '[[ $* != *clang-14* ]] || { echo E: no clang-14; exit 100; }\n'
                    'for p in "$@"; do echo "$p" >>"$INSTALLED"; done')
        self.program("apt-cache", '[[ -e $INSTALLED.fresh ]] || exit 0\n'
                                  '(($# > 1)) || { echo 500 a-mirror Packages; exit; }\n'
                                  "[[ $2 == *-14* ]] || echo '  Candidate: 1.0'")
        code, out, err = self.run_setup()
        self.assertEqual(code, 0, err)
        self.assertNotIn("Going on without", out)
        self.assertIn("clang", self.installed.read_text().split())

    def test_stale_lists_are_brought_up_to_date(self):
        self.debian('[[ $* == *update* ]] && : >"$INSTALLED.fresh"\n'
                    '[[ -e $INSTALLED.fresh ]] || exit 100')
        code, _, err = self.run_setup("--core")
        self.assertEqual(code, 0, err)
        self.assertIn("update", self.calls.read_text())

    def test_a_failed_install_says_what_apt_said(self):
        self.debian("echo E: no such mirror; exit 100")
        code, _, err = self.run_setup("--core")
        self.assertEqual(code, 1)
        self.assertIn("E: no such mirror", err)
        self.assertIn("libglm-dev", err.splitlines()[-1])

    def test_another_system_gets_the_list_and_goes_on_if_cmake_is_content(self):
        self.program("cmake", "echo '--   PANTIN_SCENE     yes  scene files'")
        code, out, err = self.run_setup()
        self.assertEqual(code, 0, err)
        self.assertIn("libglm-dev", out)
        self.assertIn("PANTIN_SCENE     yes", out)
        self.program("cmake", "echo 'glm was not found'; exit 1")
        code, _, err = self.run_setup()
        self.assertEqual(code, 1)
        self.assertIn("glm was not found", err)

    def test_an_unknown_option_is_refused(self):
        code, _, err = self.run_setup("--chekc")
        self.assertEqual(code, 2)
        self.assertIn("'--chekc'", err)
        self.assertIn("--check", err)

    def test_scripts_have_help(self):
        for script in ("setup", "build", "demo", "test", "format", "docs"):
            done = subprocess.run([SETUP.parent / script, "--help"], capture_output=True, text=True,
                                  env={"PATH": os.environ["PATH"]})
            self.assertEqual(done.returncode, 0)
            self.assertTrue(done.stdout.startswith(f"usage: tools/{script}"))


if __name__ == "__main__":
    unittest.main()
