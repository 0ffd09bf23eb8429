"""The reference is made without a doubtful comment, with a page for every room."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]


class Docs(unittest.TestCase):
    def test_the_reference_is_made(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([ROOT / "tools/docs", folder], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            html = pathlib.Path(folder, "html")
            pages = "\n".join(page.read_text(errors="replace") for page in html.glob("md_*.html"))
            for room in sorted(p for p in (ROOT / "engine").iterdir() if p.is_dir()):
                page = room / "README.md"
                self.assertTrue(page.exists(), f"{page} is missing")
                title = page.read_text().splitlines()[0].removeprefix("# ")
                self.assertIn(f'<div class="title">{title}', pages)


if __name__ == "__main__":
    if not shutil.which("doxygen"):
        sys.exit(77)
    unittest.main()
