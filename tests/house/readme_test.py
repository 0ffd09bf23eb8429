"""The pages tell of what is there: links, scenes, pictures, environment variables, code."""
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def pages():
    """Every page of the repository."""
    if (ROOT / ".git").exists():
        listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-co", "--exclude-standard", "*.md"],
                                capture_output=True, text=True)
        if listed.returncode == 0:
            return [ROOT / line for line in listed.stdout.splitlines() if (ROOT / line).exists()]
    return [page for page in ROOT.rglob("*.md") if "build" not in page.relative_to(ROOT).parts]


def prose(text):
    """Without code, where brackets mean something else."""
    text = re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S)
    return re.sub(r"`[^`\n]*`", "", re.sub(r"^    .*$", "", text, flags=re.M))


def anchors(text):
    """The names by which headings are linked to."""
    heads = re.findall(r"^#+ (.*)$", text, re.M)
    return {re.sub(r"[^\w -]", "", head.lower()).replace(" ", "-") for head in heads}


def broken_links(page, text):
    for target in re.findall(r"\]\(([^()\s]+)\)", prose(text)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path) if path else page
        if path and not file.exists():
            yield f"{page.relative_to(ROOT)}: {target} leads nowhere"
        elif anchor and anchor not in anchors(text if file == page else file.read_text("utf-8")):
            yield f"{page.relative_to(ROOT)}: {target}: no such heading"


class Pages(unittest.TestCase):
    def test_links_lead_somewhere(self):
        found, links = [], 0
        for page in pages():
            text = page.read_text(encoding="utf-8")
            found += broken_links(page, text)
            links += len(re.findall(r"\]\(", prose(text)))
        self.assertEqual(found, [])
        self.assertGreater(links, 60)

    def test_broken_links_are_found(self):
        text = "# A b\n[x](nowhere.md) [y](#a-b) [z](#c) [w](README.md#rooms) [v](README.md#none)"
        self.assertEqual([line.split(": ")[1] for line in broken_links(ROOT / "x.md", text)],
                         ["nowhere.md leads nowhere", "#c", "README.md#none"])
        self.assertEqual(list(broken_links(ROOT / "tests/x.md", "[a](../LICENSE) [b](house)")), [])

    def test_every_scene_is_in_the_table(self):
        table = (ROOT / "assets/README.md").read_text(encoding="utf-8")
        rows = [row.split("|")[1] for row in table.splitlines() if row.startswith("| `")]
        told = sorted(name for row in rows for name in re.findall(r"`(\w+\.json)`", row))
        self.assertEqual(told, sorted(p.name for p in (ROOT / "assets/scenes").glob("*.json")))

    def test_every_picture_is_shown(self):
        shown = set()
        for page in pages():
            for target in re.findall(r"!\[[^]]*\]\(([^()\s]+)\)", page.read_text(encoding="utf-8")):
                shown.add((page.parent / target).resolve())
        there = {p for p in (ROOT / "assets/pictures").iterdir() if p.suffix != ".md"}
        self.assertEqual(sorted(p.name for p in there - shown), [])
        self.assertLess((ROOT / "assets/pictures/marionette.gif").stat().st_size, 1.5e6)

    def test_environment_variables_are_listed(self):
        """What the code looks up stands in the README, and in the manual."""
        looked_up = set()
        for folder in ("engine", "tools/pantin"):
            for file in (ROOT / folder).rglob("*.cpp"):
                looked_up |= set(re.findall(r'(?:getenv|is_set)\("(\w+)"\)', file.read_text("utf-8")))
        self.assertGreater(len(looked_up), 4)
        for script in [*(ROOT / "tools").iterdir(), ROOT / ".ci/run"]:
            if script.is_file() and script.suffix == "":
                text = script.read_text(encoding="utf-8")
                looked_up |= set(re.findall(r"\$\{((?:PANTIN|CMAKE)_\w+):-", text))
        manual = (ROOT / "tools/pantin/help.cpp").read_text(encoding="utf-8")
        for name in sorted(looked_up):
            self.assertIn(f"`{name}`", README)
            if not name.startswith("CMAKE") and name != "PANTIN_JOBS":
                self.assertRegex(manual, rf'{{"[^"]*\b{name}\b')

    def test_the_program_shown_is_one_of_the_cookbook(self):
        (code,) = re.findall(r"^```cpp\n(.*?)^```$", README, re.M | re.S)
        program = (ROOT / "demos/cookbook/hinge_door.cpp").read_text(encoding="utf-8")
        self.assertIn(code, program)


if __name__ == "__main__":
    unittest.main()
