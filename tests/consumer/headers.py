#!/usr/bin/env python3
"""Installed headers: exactly the public ones and what they include, none of them internal, each of
the public ones complete by itself, and none compiled with settings of glm that would silently change
what numbers mean. What users are shown includes <pantin/...> only.

usage: headers.py INCLUDE COMPILER FLAGS...     INCLUDE: the installed include directory
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).parents[2]
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]((?:pantin|engine)/[^>"]+)[>"]', re.M)


def closure(public):
    """Files of the repository that these headers include, themselves included."""
    todo, found = list(public), set()
    while todo:
        file = todo.pop()
        if file in found:
            continue
        found.add(file)
        for name in INCLUDE.findall((ROOT / file).read_text(encoding="utf-8")):
            todo.append("engine/" + name if name.startswith("pantin/") else name)
    return found


def installed_as(file):
    return file[len("engine/"):] if file.startswith("engine/pantin/") and file.count("/") == 2 \
        else "pantin/detail/" + file


# Of glm's settings those that would turn axes or move numbers about must not compile; that each is
# told by name. The others are the user's own.
REFUSED = [["GLM_FORCE_QUAT_DATA_WXYZ"], ["GLM_FORCE_QUAT_CTOR_XYZW"],
           ["GLM_FORCE_DEFAULT_ALIGNED_GENTYPES", "GLM_FORCE_INTRINSICS"]]
ACCEPTED = """GLM_FORCE_SWIZZLE GLM_FORCE_CTOR_INIT GLM_FORCE_EXPLICIT_CTOR GLM_FORCE_SIZE_T_LENGTH
GLM_FORCE_LEFT_HANDED GLM_FORCE_DEPTH_ZERO_TO_ONE GLM_FORCE_UNRESTRICTED_GENTYPE
GLM_ENABLE_EXPERIMENTAL=1""".split()


def compiled(include, command, settings, unit):
    """(whether it compiles, what the compiler said) of a unit with glm set up so."""
    done = subprocess.run([*command, *(f"-D{name}" for name in settings), "-std=c++20",
                           "-fsyntax-only", "-Werror", f"-I{include}",
                           f"-I{include}/pantin/detail", "-x", "c++", "-"],
                          input=unit, text=True, check=False, stderr=subprocess.PIPE)
    return done.returncode == 0, done.stderr


def complaints_of_glm(include, command):
    for settings in REFUSED:
        fits, said = compiled(include, command, settings,
                              "#include <pantin/detail/engine/base/math.hpp>\n")
        if fits or f"without {settings[0]}" not in said:
            yield f"{settings[0]}: expected to be refused by name, found {said or 'no word'}"
    fits, said = compiled(include, command, ACCEPTED, "#include <pantin/pantin.hpp>\n")
    if not fits:
        yield f"{' '.join(ACCEPTED)}: refused: {said}"


def complaints(include, compiler, flags):
    found = {p.relative_to(include).as_posix() for p in include.rglob("*.hpp")}
    public = sorted(p for p in found if p.count("/") == 1)
    if "pantin/pantin.hpp" not in public:
        yield "pantin/pantin.hpp is not installed"
        return
    expected = {installed_as(f) for f in closure("engine/" + p for p in public)}
    for file in sorted(expected - found):
        yield f"{file}: not installed, but included by a public header"
    for file in sorted(found - expected):
        yield f"{file}: installed, but no public header includes it"
    for file in sorted(found):
        if re.search(r"internal|engine/solvers/|pantin/detail/engine/pantin/", file):
            yield f"{file}: is internal, but a public header includes it"
    for file in public:
        fits, said = compiled(include, [compiler, *flags], [], f"#include <{file}>\n")
        if not fits:
            yield f"{file}: cannot be included alone: {said}"
    yield from complaints_of_glm(include, [compiler, *flags])
    shown = [*(ROOT / "demos").rglob("*.?pp"), *(ROOT / "tests/consumer").glob("*.cpp"),
             ROOT / "README.md"]
    for file in shown:
        for name in INCLUDE.findall(file.read_text(encoding="utf-8")):
            if name.startswith("engine/"):
                yield f"{file.relative_to(ROOT)}: includes {name}, expected <pantin/...>"


def main():
    found = list(complaints(pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3:]))
    print("\n".join(found) if found else "headers: what is installed is what the public ones need")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
