"""Every source that the code cites by a key is spelled out in README.md, under "Sources", once."""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).parents[2]
NAME = r"[A-Z][A-Za-z-]+"
KEY = re.compile(rf"{NAME}(?:, {NAME})*(?: & {NAME})? (?:1[89]|20)\d\d|Nelson & Cohen|"
                 rf"Hairer & Wanner II|RFC \d+|IEC [\d-]+")
CITED = ("engine", "demos", "tests", "tools", "assets")


def prose(path):
    """The comments of C++ and the whole of a README, each as one line."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        return " ".join(text.split())
    comments = re.findall(r"(?m)//+ ?(.*)$", text)
    return " ".join(" ".join(comments).split())


def citations():
    """Keys by the file that cites them first; a citation stands in square brackets."""
    found = {}
    for top in CITED:
        for path in sorted((ROOT / top).rglob("*")):
            if path.suffix not in (".cpp", ".hpp", ".md"):
                continue
            for inside in re.findall(r"\[([^][]{4,200})\]", prose(path)):
                for key in KEY.findall(inside):
                    found.setdefault(key, path.relative_to(ROOT))
    return found


def sources():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    _, _, after = readme.partition("\n## Sources\n")
    section = re.split(r"\n## ", after)[0]
    return re.findall(r"(?m)^- \[([^]]+)\] \S", section)


class Sources(unittest.TestCase):
    def test_every_cited_key_is_in_the_list(self):
        listed = sources()
        found = citations()
        self.assertGreater(len(found), 20, found)
        for key, path in sorted(found.items()):
            with self.subTest(key):
                self.assertIn(key, listed, f"{path} cites [{key}], README.md does not spell it out")

    def test_each_is_listed_once_in_order_and_cited(self):
        listed = sources()
        self.assertEqual(listed, sorted(set(listed), key=str.casefold))
        found = citations()
        readme = (ROOT / "README.md").read_text(encoding="utf-8")
        for key in listed:
            with self.subTest(key):
                self.assertTrue(key in found or readme.count(f"[{key}") > 1, "nobody cites it")


if __name__ == "__main__":
    unittest.main()
