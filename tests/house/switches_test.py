#!/usr/bin/env python3
"""A new kind does not slip through: a switch of the engine either names all of them, so that the
compiler (-Wswitch) asks for the new one, or says beside its `default` what that stands for."""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).parents[2]
DEFAULT = re.compile(r"^\s*default:(.*)$")


def silent_defaults(text):
    """Numbers of lines with a default that says nothing."""
    return [number for number, line in enumerate(text.splitlines(), 1)
            if (m := DEFAULT.match(line)) and not re.match(r"\s*//\s*\S", m[1])]


class Switches(unittest.TestCase):
    def test_every_default_says_what_it_stands_for(self):
        found = [f"{path.relative_to(ROOT)}:{number}" for path in sorted((ROOT / "engine").rglob("*.[ch]pp"))
                 for number in silent_defaults(path.read_text())]
        self.assertEqual(found, [], "name all kinds, or say what the default stands for")

    def test_the_search_finds(self):
        self.assertEqual(silent_defaults("switch (a) {\n  default:\n    break;\n}\n"), [2])
        self.assertEqual(silent_defaults("  default:  // the others, which have none\n"), [])

    def test_the_compiler_asks_for_missing_kinds(self):
        self.assertRegex((ROOT / "CMakeLists.txt").read_text(), r"-Wall\b")


if __name__ == "__main__":
    unittest.main()
