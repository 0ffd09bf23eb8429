"""Functions fit a screen or two, files hold one idea: no function of the engine is longer than 80
lines, no file of C++ or Python longer than 500."""
import pathlib
import re
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
LONGEST_FUNCTION, LONGEST_FILE = 80, 500
ROOMS = ("engine", "demos", "tests", "tools")
SUFFIXES = (".cpp", ".hpp", ".py")

# Strings, characters and comments, in which a brace is none.
QUIET = re.compile(r'R"(?P<mark>[^()\s\\]*)\((?:.|\n)*?\)(?P=mark)"|"(?:\\.|[^"\\\n])*"|'
                   r"(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])'|//[^\n]*|/\*(?:.|\n)*?\*/")
# What stands before the brace of a scope that holds functions, and of data.
ACCESS = re.compile(r"\b(public|private|protected)\s*:(?!:)")
SCOPE = re.compile(r"\b(namespace|class|struct|union|enum)\b|\bextern\s*$")


def blanked(text):
    return QUIET.sub(lambda m: re.sub(r"[^\n]", " ", m.group()), text)


def functions(text):
    """(first line, last line, head) of every function with a body, lambdas of a namespace too."""
    text = re.sub(r"(?m)^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", lambda m: re.sub(r"[^\n]", " ", m.group()),
                  ACCESS.sub(lambda m: " " * len(m.group()), blanked(text)))
    begins, depth, inside = 0, 0, None  # of the declaration, of braces within a function
    for m in re.finditer(r"[{};]", text):
        if inside is not None:
            depth += {"{": 1, "}": -1}.get(m.group(), 0)
            if depth == 0:
                first, head = inside
                yield text.count("\n", 0, first) + 1, text.count("\n", 0, m.end()) + 1, head
                inside, begins = None, m.end()
            continue
        head = text[begins:m.start()]
        if m.group() == "{" and ("(" in head or "[" in head) and not is_scope(head):
            inside, depth = (begins + len(head) - len(head.lstrip()), " ".join(head.split())), 1
        else:
            begins = m.end()


def is_scope(head):
    """A class may derive from a template with brackets; a function may return a `struct tm`."""
    words = SCOPE.search(head)
    if not words:
        return False
    before, after = head[:words.start()], head[words.end():]
    if re.fullmatch(r"\s*(template\s*<.*>\s*)?(typedef\s+|inline\s+)?", before, re.DOTALL) is None:
        return False
    return not re.match(r"[^:]*\w\s*\(", after) or words.group(1) == "namespace"


def findings(root):
    for room in ROOMS:
        for path in sorted((root / room).rglob("*")):
            if path.suffix not in SUFFIXES:
                continue
            text, name = path.read_text(encoding="utf-8"), path.relative_to(root)
            lines = text.count("\n")
            if lines > LONGEST_FILE:
                yield f"{name}: has {lines} lines, expected at most {LONGEST_FILE}"
            if room != "engine" or path.suffix == ".py":
                continue
            for first, last, head in functions(text):
                if last - first + 1 > LONGEST_FUNCTION:
                    yield (f"{name}:{first}: {head[:60]} has {last - first + 1} lines, expected at "
                           f"most {LONGEST_FUNCTION}")


def findings_in(place, text):
    """Of a repository that has nothing but this file."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, place)
        file.parent.mkdir()
        file.write_text(text, encoding="utf-8")
        return list(findings(pathlib.Path(folder)))


class Sizes(unittest.TestCase):
    def test_functions_and_files_are_short(self):
        self.assertEqual(list(findings(ROOT)), [])

    def test_the_order_of_a_step_fits_a_screen(self):
        text = ROOT.joinpath("engine/runtime/step.cpp").read_text(encoding="utf-8")
        step = [last - first + 1 for first, last, head in functions(text)
                if "StepReport step_world(" in head]
        self.assertEqual(len(step), 1, "engine/runtime/step.cpp: found no step_world")
        self.assertLess(step[0], 40)

    def test_what_is_too_long_is_named_with_its_place(self):
        fits = "  call();\n" * (LONGEST_FUNCTION - 2)
        samples = {
            "namespace a {\nstruct S : Base<int (*)()> {\n": 3,
            "namespace {\ntemplate <class T>\nclass C {\n public:\n": 5,
            "#define BRACE {\nconst char* s = \"{\"; // {\nchar c = '{';\n": 4,
            "constexpr int kOnes[] = {1, 1};\n": 2,
        }
        for before, line in samples.items():
            for head in ("int f(int n) {", "auto f = [](int n) {", "S() : a{1}, b(2) {",
                         "bool operator()(int) const noexcept {"):
                with self.subTest(before=before, head=head):
                    start = f"{before}{head}\n{fits}"
                    found = findings_in("engine/long.cpp", f"{start}  call();\n}}\n")
                    self.assertEqual(len(found), 1, found)
                    self.assertTrue(found[0].startswith(f"engine/long.cpp:{line}: "), found)
                    self.assertEqual(findings_in("engine/long.cpp", f"{start}}}\n"), [])

    def test_a_file_that_is_too_long_is_named(self):
        for place in ("engine/a.hpp", "demos/a.cpp", "tests/a.cpp", "tools/a.py"):
            self.assertEqual(findings_in(place, "\n" * LONGEST_FILE), [])
            self.assertEqual(len(findings_in(place, "\n" * (LONGEST_FILE + 1))), 1)


if __name__ == "__main__":
    unittest.main()
