#!/usr/bin/env python3
"""Installed headers: exactly the public ones and what they include, none of them internal, each of
the public ones complete by itself. What users are shown includes <pantin/...> only.

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
        command = [compiler, *flags, "-std=c++20", "-fsyntax-only", "-Werror", f"-I{include}",
                   f"-I{include}/pantin/detail", "-x", "c++", "-"]
        unit = f"#include <{file}>\n"
        if subprocess.run(command, input=unit, text=True, check=False).returncode != 0:
            yield f"{file}: cannot be included alone"
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
