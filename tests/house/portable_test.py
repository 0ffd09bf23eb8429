"""What only some compilers or systems know stays where it is allowed."""
import pathlib
import re
import unittest

ENGINE = pathlib.Path(__file__).parents[2] / "engine"

COMPILERS = re.compile(r"\b__(builtin_\w+|attribute__|GNUC__|clang__|restrict|typeof__|int128)\b|"
                       r"#\s*pragma\s+(GCC|clang)|\[\[gnu::|\bvector_size\b")
SYSTEMS = re.compile(r"#\s*include\s*<(unistd|fcntl|dlfcn|pthread|spawn|sys/\w+|\w*mmintrin)\.h>")
# The pictures of today start ffmpeg and open OpenGL the way of POSIX.
POSIX = {"render/capture.cpp", "render/ffmpeg.cpp", "render/ffmpeg.hpp", "render/context_egl.cpp",
         "render/context_osmesa.cpp"}


def finds(pattern, allowed):
    for file in sorted(ENGINE.rglob("*.[ch]pp")):
        name = file.relative_to(ENGINE).as_posix()
        if name in allowed:
            continue
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            if pattern.search(line):
                yield f"engine/{name}:{number}: {line.strip()}"


class Portable(unittest.TestCase):
    def test_extensions_of_compilers_stand_in_one_place(self):
        allowed = {"base/compiler.hpp", "base/lanes.hpp", "base/hash.hpp"}
        self.assertEqual(list(finds(COMPILERS, allowed)), [])

    def test_calls_of_one_system_stand_where_pictures_are_made(self):
        self.assertEqual(list(finds(SYSTEMS, POSIX)), [])


if __name__ == "__main__":
    unittest.main()
