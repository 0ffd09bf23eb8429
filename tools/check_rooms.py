#!/usr/bin/env python3
"""Checks who includes whom: base <- { nurbs, modes }, nurbs <- geometry <- joints <- world,
{ world, modes } <- scene, world <- contact <- { solvers, render }, modes <- solvers, solvers <- { assembly, runtime } <- pantin <- demos,
tests, tools. Names every offending line; exit code 1 if there is one.

usage: check_rooms.py [ROOT]     ROOT: the repository, by default the one this file lies in
"""
import pathlib
import re
import sys

BELOW = {"base": []}
for room, last in [("nurbs", ["base"]), ("modes", ["base"]), ("geometry", ["nurbs"]),
                   ("joints", ["geometry"]), ("world", ["joints"]),
                   ("contact", ["world"]), ("solvers", ["contact", "modes"]), ("scene", ["world", "modes"]),
                   ("render", ["contact"]), ("assembly", ["solvers"]), ("runtime", ["solvers"]),
                   ("pantin", ["assembly", "runtime", "scene", "render"])]:
    BELOW[room] = sorted({r for l in last for r in [l, *BELOW[l]]})

# Libraries that are one place's own business. The core rooms know glm, and that through one file.
OWNERS = {
    "glm/": ["engine/base/math.hpp"],
    "nlohmann/": ["engine/scene/", "tools/", "tests/"],
    "GL/": ["engine/render/"],
    "EGL/": ["engine/render/"],
    "ft2build.h": ["engine/render/"],
    "libdeflate.h": ["engine/render/", "tests/"],
    "SDL": ["tools/"],
    "box2d/": ["engine/solvers/planar/box2d_plane.cpp", "engine/solvers/planar/box2d_contacts.hpp", "tools/plane/",
               "tests/modes/box2d_rod_test.cpp", "tools/peers/engines/box2d.cpp"],
    "imgui": ["tools/"],
    "pantin/": ["engine/pantin/", "demos/", "tests/", "tools/"],
    "CLI/": ["tools/pantin/command_line.cpp"],
    "fmt/": ["tools/"],
}
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')


def complaint(path, kind, name):
    """Why the file at `path` may not include `name`, or None."""
    if kind == "<":
        for prefix, owners in OWNERS.items():
            if name.startswith(prefix) and not path.startswith(tuple(owners)):
                return f"<{name}> belongs to {', '.join(owners)}"
        return None
    top, _, rest = name.partition("/")
    here = path.split("/")
    if top not in ("engine", "demos", "tests", "tools"):
        return f'"{name}" is not spelled from the root of the repository'
    if here[0] != "engine":
        if here[0] == "demos" and top in ("tests", "tools"):
            return f'"{name}": demos do not include {top}'
        return None
    if top != "engine":
        return f'"{name}": the engine does not include {top}'
    room = rest.partition("/")[0]
    allowed = [here[1], *BELOW[here[1]]]
    if room not in allowed:
        return f'"{name}": {here[1]} may include {", ".join(allowed)}, not {room}'
    return None


def complaints(root):
    for room in sorted(p.name for p in (root / "engine").iterdir() if p.is_dir()):
        if room not in BELOW:
            yield f"engine/{room}: found a room that the plan does not name: {', '.join(BELOW)}"
    for top in ("engine", "demos", "tests", "tools"):
        for file in sorted((root / top).rglob("*.[ch]pp")):
            path = file.relative_to(root).as_posix()
            if path.startswith("engine/") and path.split("/")[1] not in BELOW:
                continue
            for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
                found = INCLUDE.match(line)
                why = complaint(path, *found.groups()) if found else None
                if why:
                    yield f"{path}:{number}: {why}"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[1])
    if not (root / "engine").is_dir():
        sys.exit(f"{root}: found no folder engine/, expected the repository")
    found = list(complaints(root))
    print("\n".join(found) if found else "rooms: every include goes the right way")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
