"""The top level holds what the README's map names, and nothing else."""
import pathlib
import subprocess
import unittest

ROOT = pathlib.Path(__file__).parents[2]
ALLOWED = {"CMakeLists.txt", "CMakePresets.json", "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "README.md",
           "assets", "demos", "engine", "tests", "tools"}
HIDDEN = {".ci", ".clang-format", ".clang-tidy", ".gitignore"}
IGNORED = {".git", "build", "out", "compile_commands.json", ".cache"}  # as in .gitignore


def entries():
    """Tracked names in a checkout; all names in an unpacked archive."""
    if (ROOT / ".git").exists():
        listed = subprocess.run(["git", "-C", ROOT, "ls-files"], capture_output=True, text=True)
        if listed.returncode == 0:
            return {line.split("/")[0] for line in listed.stdout.splitlines()}
    return {p.name for p in ROOT.iterdir()} - IGNORED


class TopLevel(unittest.TestCase):
    def test_nothing_else_lies_around(self):
        self.assertEqual(sorted(entries() - ALLOWED - HIDDEN), [])

    def test_nothing_is_missing(self):
        self.assertEqual(sorted(n for n in ALLOWED | HIDDEN if not (ROOT / n).exists()), [])

    def test_scripts_can_be_run(self):
        for name in (".ci/run", "tools/setup", "tools/build", "tools/demo", "tools/test", "tools/format",
                     "tools/docs", "tools/nightly", "tools/truth"):
            self.assertTrue((ROOT / name).stat().st_mode & 0o111, f"{name} is not executable")


if __name__ == "__main__":
    unittest.main()
