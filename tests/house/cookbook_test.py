"""The cookbook's page shows its programs as they are; `cookbook_test.py --write` writes it anew."""
import pathlib
import re
import sys
import unittest

FOLDER = pathlib.Path(__file__).parents[2] / "demos" / "cookbook"
PAGE = FOLDER / "README.md"
HEAD = """# Cookbook

Short programs over `<pantin/...>`, each built and run by the tests; `ctest -L cookbook` runs them all.
Link `pantin::core`, `pantin::render` where `<pantin/render.hpp>` is included, `pantin::scene` where
`<pantin/scene.hpp>` is.
"""


def page():
    parts = [HEAD, "\n| program | what it shows |\n|---|---|\n"]
    for file in sorted(FOLDER.glob("*.cpp")):
        what = file.read_text(encoding="utf-8").splitlines()[0][3:].rstrip(".")
        parts.append(f"| [{file.name}]({file.name}) | {what} |\n")
    for file in sorted(FOLDER.glob("*.cpp")):
        first, *rest = file.read_text(encoding="utf-8").splitlines()
        code = "\n".join(line for line in rest if not line.startswith("// prints: ")).strip()
        parts.append(f"\n## {first[3:].rstrip('.')}\n\n[{file.name}]({file.name})\n\n```cpp\n{code}\n```\n")
    return "".join(parts)


class Cookbook(unittest.TestCase):
    def test_page_shows_the_programs(self):
        self.assertEqual(PAGE.read_text(encoding="utf-8"), page())

    def test_programs_are_short_and_say_what_they_print(self):
        for file in FOLDER.glob("*.cpp"):
            lines = file.read_text(encoding="utf-8").splitlines()
            self.assertLess(len(lines), 50, file.name)
            self.assertRegex(lines[0], r"^// .*\.$", file.name)
            self.assertRegex(lines[-1], "^// prints: .", file.name)

    def test_the_hinge_takes_fifteen_lines(self):
        lines = (FOLDER / "hinge_door.cpp").read_text(encoding="utf-8").splitlines()
        self.assertLessEqual(sum(not re.match(r"\s*//|\s*$", line) for line in lines), 15)


if __name__ == "__main__":
    if "--write" in sys.argv:
        PAGE.write_text(page(), encoding="utf-8")
    else:
        unittest.main()
