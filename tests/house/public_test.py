#!/usr/bin/env python3
"""What is installed is what a user may name, or says that it is not: of the headers that <pantin/...>
takes in, those listed here declare types in namespace pantin, all others in pantin::detail only."""
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests/consumer"))
from headers import closure  # noqa: E402


# Those of engine/pantin are public all.
PUBLIC = """
base/job base/math base/result base/rotation base/fields contact/contact geometry/shape joints/parameters
render/capture render/renderer render/strip runtime/save runtime/simulation runtime/systems
scene/scene world/body world/collision world/entity world/faults world/integrators
world/findings world/joint_drive world/kinematic_path world/link world/look world/queries world/report
world/sensor world/settings world/store world/surface_contact world/timed_event world/world
""".split()
# Kinds of paths and events are public too, and no limit to how many there are.
KINDS = {"engine/world/kinematic_path.hpp": "engine/world/paths/",
         "engine/world/timed_event.hpp": "engine/world/events/"}
# What was reached; a new type is worth a thought whether users have to name it.
# A header of changes to a World that runs; the pose that a game draws a body at, and the turn of a
# body in a pose that a figure follows. What a filter of contacts is asked, and whose threads step.
# A joint of any kind, its parameters and what acts along its coordinates. Laminas and their contact
# modes; lines to look at.
# How surface joints are differentiated.
# Assembly: its result, a length that is free, three kinds of targets, their handle, errors, and the assembler that follows them.
# Sensors: what one measures, and at which points. The motion of an exact drive: its law, its knots,
# its value with derivatives.
MOST_HEADERS = 70
MOST_TYPES = {"core": 150, "with scenes and pictures": 164}

TOKEN = re.compile(r"""
    (?P<namespace>\bnamespace\b\s*(?P<name>[\w:]*)\s*\{)
  | (?P<type>\b(?:struct|class|enum(?:\s+class)?)\s+(?P<called>\w+)\s*(?:final\s*)?(?::(?!:)[^;{]*)?\{)
  | (?P<alias>\busing\s+(?P<alias_called>\w+)\s*=)
  | (?P<open>\{) | (?P<close>\})""", re.X)


def stripped(text):
    """Without comments, preprocessor lines and what stands in quotes."""
    text = re.sub(r'"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)\'', '""', text)
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.S)
    return re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", "", text, flags=re.M)


def types_of(text):
    """(namespace, name) of every type that is declared outside of types and functions."""
    scopes = []  # a namespace's name, or None for any other brace
    for at in TOKEN.finditer(stripped(text)):
        outside = None not in scopes
        namespace = "::".join(s for s in scopes if s)
        if at["namespace"]:
            scopes.append(at["name"] or "(unnamed)")
        elif at["type"]:
            if outside:
                yield namespace, at["called"]
            scopes.append(None)
        elif at["alias"]:
            if outside:
                yield namespace, at["alias_called"]
        elif at["open"]:
            scopes.append(None)
        else:
            scopes.pop()


def public_headers():
    return sorted(f"engine/pantin/{p.name}" for p in (ROOT / "engine/pantin").glob("*.hpp"))


def public_types(files):
    return sorted(name for file in files for namespace, name in types_of((ROOT / file).read_text())
                  if namespace == "pantin")


def files_of_kinds():
    """Files that the lists of kinds take them from."""
    return {file for list_of_kinds, folder in KINDS.items()
            for file in re.findall(rf'"({folder}\w+\.hpp)"', (ROOT / list_of_kinds).read_text())}


class Public(unittest.TestCase):
    def test_types_are_found(self):
        sample = """
            namespace pantin { // struct No {
            struct A; enum class B : char { x, y };
            template <class T> class C final : public A { struct Inner {}; enum { z }; };
            inline void f() { struct Local {}; }
            using D = std::vector<A>;
            namespace detail { struct Hidden {}; }
            } namespace pantin::detail { struct Hidden2 : A {}; }
            #define STRUCT struct No {
        """
        self.assertEqual(list(types_of(sample)), [
            ("pantin", "B"), ("pantin", "C"), ("pantin", "D"), ("pantin::detail", "Hidden"),
            ("pantin::detail", "Hidden2")])

    def test_internal_headers_declare_nothing_outside_detail(self):
        listed = {f"engine/{name}.hpp" for name in PUBLIC} | set(public_headers()) | files_of_kinds()
        files = closure(public_headers())
        for file in sorted(files - listed):
            text = (ROOT / file).read_text()
            for namespace, name in types_of(text):
                self.assertTrue(namespace.startswith("pantin::detail"),
                                f"{file}: found {namespace}::{name}, expected it in pantin::detail")
            self.assertRegex(text, r"(?m)^/// Internal", f"{file}: does not say why it is installed")
        self.assertEqual(sorted(listed - files), [], "listed, but not installed")

    def test_nothing_of_solvers_is_installed(self):
        for file in closure(public_headers()):
            self.assertNotRegex(file, r"internal|engine/solvers/|engine/pantin/detail/")

    def test_not_more_than_was_reached(self):
        kinds = files_of_kinds()
        core = closure(f for f in public_headers() if not f.endswith(("/scene.hpp", "/render.hpp")))
        everything = closure(public_headers())
        self.assertLessEqual(sum(not file.startswith(tuple(KINDS.values())) for file in everything), MOST_HEADERS)
        for files, what in [(core, "core"), (everything, "with scenes and pictures")]:
            found = public_types(files - kinds)
            self.assertLessEqual(len(found), MOST_TYPES[what], f"{what}: {' '.join(found)}")
            self.assertEqual(len(found), len(set(found)))

    def test_programs_of_users_do_without_the_rest(self):
        shown = [p for folder in ("demos", "tests/consumer") for p in (ROOT / folder).rglob("*.?pp")]
        for file in [*shown, ROOT / "README.md", ROOT / "demos/cookbook/README.md"]:
            code = file.read_text()
            if file.suffix == ".md":
                code = "\n".join(re.findall(r"^```(?:cpp|c\+\+).*?^```$", code, re.M | re.S))
                self.assertIn("using namespace pantin;", code)
            self.assertNotRegex(code, r"\bdetail::|namespace detail|pantin::detail", str(file))
            self.assertNotRegex(code, r'#\s*include\s*"engine/', str(file))


if __name__ == "__main__":
    unittest.main()
