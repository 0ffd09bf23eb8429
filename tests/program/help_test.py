"""The manual page and the completions say what the program takes: every option of every command."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PANTIN = os.environ["PANTIN"]
COMPLETE = r"""
source <("$PANTIN" completion bash)
COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
_pantin
((${#COMPREPLY[@]} == 0)) || printf '%s\n' "${COMPREPLY[@]}"
"""


def pantin(*arguments):
    done = subprocess.run([PANTIN, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, timeout=60)
    return done


def told(*arguments):
    done = pantin(*arguments)
    assert done.returncode == 0, done.stderr
    return done.stdout


def commands():
    return re.findall(r"^  (\w+) ", told("--help").split("Subcommands:")[1].split("\n\n")[0], re.M)


def options(command):
    """Of --help: each option's names, and its choices where it has some."""
    shown = told(*command, "--help")
    lines = re.findall(r"^  (-\S+)(?: (\S+))?", shown.split("Options:")[1].split("\n\n")[0], re.M)
    return [(names.split(","), re.findall(r"[^{},]+", re.search(r"{.*}|$", kind)[0]))
            for names, kind in lines]


class Help(unittest.TestCase):
    def setUp(self):
        self.kept = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.kept.name)

    def tearDown(self):
        self.kept.cleanup()

    def completed(self, *words):
        """What bash offers for the last word."""
        done = subprocess.run(["bash", "--norc", "-c", COMPLETE, "bash", "pantin", *words],
                              cwd=self.folder, env={**os.environ, "PANTIN": PANTIN}, text=True,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return sorted(done.stdout.split("\n")[:-1])

    def test_help_of_a_command_is_what_its_option_prints(self):
        self.assertEqual(told("help"), told("--help"))
        self.assertGreater(len(commands()), 8)
        for command in commands():
            self.assertEqual(told("help", command), told(command, "--help"))
        refused = pantin("help", "runn")
        self.assertEqual((refused.returncode, refused.stdout), (2, ""))

    def test_the_manual_holds_every_option_of_every_command(self):
        page = told("help", "--man")
        sections = {"": page.split(".SH COMMANDS")[0]}
        for part in page.split("\n.SS pantin ")[1:]:
            sections[re.match(r"\w+", part)[0]] = part
        self.assertEqual(sorted(sections), sorted(["", *commands()]))
        for command, text in sections.items():
            for names, _ in options([command] if command else []):
                for name in names:
                    self.assertIn("\\fB" + name.replace("-", "\\-") + "\\fR", text, command)
        for word in ("PANTIN_GL", "NO_COLOR", "Exit codes"):
            self.assertIn(word, page)

    @unittest.skipUnless(shutil.which("groff"), "groff is not installed")
    def test_the_manual_is_clean_roff(self):
        page = told("help", "--man")
        done = subprocess.run(["groff", "-man", "-ww", "-Tascii", "-P-cbou"], input=page, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for command in commands():
            self.assertIn(f"pantin {command}", done.stdout)
        # Examples stand as they are typed.
        for line in re.findall(r"^  (pantin .{1,60})$", told("run", "--help"), re.M):
            self.assertIn(line, done.stdout)

    def test_bash_offers_every_option_of_every_command(self):
        self.assertEqual(self.completed(""), sorted(commands()))
        self.assertEqual(self.completed("sch"), ["schema"])
        self.assertEqual(self.completed("-"), sorted(n for names, _ in options([]) for n in names))
        for command in commands():
            expected = sorted(name for names, _ in options([command]) for name in names)
            self.assertEqual(self.completed(command, "-"), expected)

    def test_bash_offers_the_values_that_an_option_takes(self):
        seen = 0
        for command in commands():
            for names, choices in options([command]):
                if choices:
                    self.assertEqual(self.completed(command, names[-1], ""), sorted(choices))
                    seen += 1
        self.assertGreater(seen, 10)
        self.assertEqual(self.completed("run", "--solver", "la"), ["lagrangian"])
        self.assertEqual(self.completed("run", "--solver", "=", "la"), ["lagrangian"])
        self.assertEqual(self.completed("run", "x.json", "--step", ""), [])
        self.assertEqual(self.completed("completion", ""), ["bash", "fish", "zsh"])
        self.assertEqual(self.completed("help", ""), sorted(commands()))

    def test_bash_offers_the_files_that_fit(self):
        for name in ("a scene.json", "b.json5", "c.gif", "d.mp4", "e.txt"):
            (self.folder / name).touch()
        (self.folder / "sub").mkdir()
        (self.folder / "sub" / "f.json").touch()
        for words, found in (
                (["run", ""], ["a scene.json", "b.json5", "sub"]),
                (["run", "a"], ["a scene.json"]),
                (["view", "--beside", "sweep", "sub/"], ["sub/f.json"]),
                (["check", "b.json5", ""], ["a scene.json", "b.json5", "sub"]),
                (["run", "--gif", ""], ["c.gif", "sub"]),
                (["run", "--video", ""], ["d.mp4", "sub"]),
                (["run", "--frames", ""], ["sub"]),
                (["run", "--record", "e"], ["e.txt"])):
            with self.subTest(words):
                self.assertEqual(self.completed(*words), found)

    def test_zsh_and_fish_know_every_option(self):
        scripts = {shell: told("completion", shell) for shell in ("zsh", "fish")}
        for command in commands():
            own = {"zsh": re.search(rf"^        {command}\)\n(.*?);;", scripts["zsh"], re.M | re.S)[1],
                   "fish": "\n".join(line for line in scripts["fish"].splitlines()
                                     if f"'__fish_seen_subcommand_from {command}'" in line)}
            for names, choices in options([command]):
                for name in names:
                    self.assertRegex(own["zsh"], rf"'{name}=?\[", command)
                    flag = f" -l {name[2:]} " if name.startswith("--") else f" -s {name[1:]} "
                    self.assertIn(flag, own["fish"], command)
                for shell in own:
                    self.assertIn(" ".join(choices), own[shell])

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not installed")
    def test_zsh_reads_its_script(self):
        done = subprocess.run(["zsh", "-n"], input=told("completion", "zsh"), text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    @unittest.skipUnless(shutil.which("fish"), "fish is not installed")
    def test_fish_offers_values(self):
        (self.folder / "a.json").touch()
        script = self.folder / "pantin.fish"
        script.write_text(told("completion", "fish"))
        for line, words in (("pantin run --solver la", ["lagrangian"]),
                            ("pantin sch", ["schema"]), ("pantin run --gi", ["--gif"]),
                            ("pantin view a", ["a.json"])):
            done = subprocess.run(["fish", "-c", f"source {script}; complete -C '{line}'"],
                                  cwd=self.folder, text=True, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, timeout=60)
            self.assertEqual([w.split("\t")[0] for w in done.stdout.splitlines()], words, line)


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
