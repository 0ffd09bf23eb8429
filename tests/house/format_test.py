"""The C++ is laid out as .clang-format says."""
import pathlib
import subprocess
import sys

done = subprocess.run([pathlib.Path(__file__).parents[2] / "tools/format", "--check"])
sys.exit(done.returncode)
