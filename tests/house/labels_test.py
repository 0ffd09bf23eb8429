"""The labels that the help of tools/test names are those that the tests bear."""
import json
import os
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).parents[2]
BUILD = os.environ.get("PANTIN_BUILD")


def tests():
    """Names and properties of all tests."""
    shown = subprocess.run(["ctest", "--test-dir", BUILD, "--show-only=json-v1"],
                           capture_output=True, text=True, check=True).stdout
    return {test["name"]: {p["name"]: p["value"] for p in test.get("properties", [])}
            for test in json.loads(shown)["tests"]}


def labels():
    shown = subprocess.run(["ctest", "--test-dir", BUILD, "--print-labels"], capture_output=True,
                           text=True, check=True).stdout
    return set(re.findall(r"^  (\w+)$", shown, re.M))


class Labels(unittest.TestCase):
    def test_labels_in_help_and_readme_exist(self):
        text = subprocess.run([ROOT / "tools/test", "--help"], capture_output=True, text=True,
                              check=True).stdout
        listed = re.search(r"bear the labels (.*?);", text, re.S)[1]
        named = set(re.findall(r"\w+", listed)) - {"and", "if", "they", "measure", "time"}
        self.assertGreater(len(named), 8)
        for place in (text, (ROOT / "README.md").read_text()):
            named |= set(re.findall(r"(?<!\w)-LE? +(\w+)", place))
        self.assertEqual(sorted(named - labels()), [])

    def test_every_test_has_a_label(self):
        bare = [name for name, has in tests().items() if "LABELS" not in has]
        self.assertEqual(bare, [])

    def test_what_measures_time_is_alone(self):
        timed = {name: has for name, has in tests().items() if "timed" in has.get("LABELS", [])}
        self.assertGreater(len(timed), 0)
        for name, has in timed.items():
            self.assertTrue(has.get("RUN_SERIAL"), name)


def is_whole():
    """Whether every part is built and every folder of tests: others lack some labels."""
    cache = pathlib.Path(BUILD, "CMakeCache.txt").read_text() if BUILD else ""
    return (re.search(r"^PANTIN_RENDER:\w+=ON$", cache, re.M)
            and "PANTIN_TEST_ROOMS:STRING=\n" in cache)


if __name__ == "__main__":
    if not is_whole():
        sys.exit(77)
    unittest.main()
