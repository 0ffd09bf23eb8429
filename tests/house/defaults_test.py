"""Without options, configuring switches nothing off: a machine that builds every part gets every part."""
import pathlib
import re
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]


class Defaults(unittest.TestCase):
    def test_every_part_is_on(self):
        with tempfile.TemporaryDirectory() as folder:
            shown = subprocess.run(["cmake", "-S", ROOT, "-B", folder], capture_output=True, text=True)
        self.assertEqual(shown.returncode, 0, shown.stderr)
        parts = dict(re.findall(r"^--   PANTIN_(\w+) +(yes|no) ", shown.stdout, re.M))
        self.assertNotIn("switched off", shown.stdout)
        for part in ("SCENE", "RENDER", "PROGRAM", "VIEW", "DEMOS", "TESTS"):
            self.assertEqual(parts.get(part), "yes", shown.stdout)


if __name__ == "__main__":
    unittest.main()
