#!/usr/bin/env python3
"""A call can be read where it stands: no function of the engine, the tools or the demos has more
than four parameters, and none is a bare bool, whose value says nothing at the call."""
import pathlib
import re
import tempfile
import unittest

from sizes_test import blanked

ROOT = pathlib.Path(__file__).parents[2]
ROOMS = ("engine", "tools", "demos")
MOST = 4

# (file, function, parameter): why it is a value rather than a choice of what the function does.
ALLOWED = {
    ("engine/base/hash.hpp", "add", "bool yes"): "the value that is hashed",
    ("engine/scene/read/reader.hpp", "flag", "bool otherwise"): "the value where the key is absent",
    ("engine/scene/read/reader.cpp", "Reader::flag", "bool otherwise"): "the value where it is absent",
}

DIRECTIVE = re.compile(r"(?m)^[ \t]*#(?:[^\n]*\\\n)*[^\n]*")
ATTRIBUTE = re.compile(r"\[\[.*?\]\]", re.S)
ACCESS = re.compile(r"\b(public|private|protected)\s*:(?!:)")
# What comes before the name of a scope that holds functions; a function may return a `struct tm`.
SCOPE = re.compile(r"\s*(?:template\s*<.*>\s*)?(?:inline\s+|typedef\s+)?"
                   r"(?:namespace\b|extern\s*$|(?:class|struct|union)\b(?![^:]*\w\s*\())", re.S)
LOCAL_SCOPE = re.compile(r"\b(?:struct|class)\s+\w+(?:\s+final)?\s*(?::[^;{}()]*)?\{")
LAMBDA = re.compile(r"\]\s*(?=[<(])")
# Words that brackets follow, but no parameters; and statements that declare no function.
BRACKETED = {"alignas", "decltype", "explicit", "noexcept", "requires", "__attribute__", "sizeof"}
NO_FUNCTION = re.compile(r"\s*(using|typedef|static_assert|enum|return|goto|case|throw|delete|new)\b")
NAME = re.compile(r"(?:[\w~]+\s*(?:<[^<>()]*>)?\s*::\s*)*"
                  r"(?:operator\s*(?:\(\s*\)|\[\s*\]|[^\s\w(]+|\"\"\s*\w+|[\w:&*<> ]+?)|~?\w+)\s*$")
BUILTIN = r"(?:void|bool|char|short|int|long|unsigned|signed|float|double|auto)\b"
PARAMETER = re.compile(  # a type and perhaps a name; of a type alone, one that looks like a type
    rf"(?:const\s+|volatile\s+|struct\s+|typename\s+)*(?:{BUILTIN}|(?:\w+::)*[A-Za-z_]\w*\s*[^\w\s]?.*"
    r"[\w>&*\]]\s*[&*\s.]+\s*\w+\s*(?:\[.*\])?\s*$|(?:\w+::)*[A-Z]\w*\b|(?:\w+::)+\w+\b|\w+\s*<)", re.S)
BARE_BOOL = re.compile(r"(?:const\s+)?bool(?:\s+const)?(?:\s*\.\.\.)?(?:\s+\w+)?$")
OPENING, CLOSING = "([{", ")]}"


def end_of(text, at, open_, close):
    """Just behind the bracket that closes the one at `at`; `at` + 1 if none does."""
    depth = 0
    for i in range(at, len(text)):
        if text[i] == open_:
            depth += 1
        elif text[i] == close and not (close == ">" and text[i - 1] == "-"):
            depth -= 1
            if depth == 0:
                return i + 1
        elif close == ">" and text[i] in ";{":
            break
    return at + 1


def split(parameters):
    """At commas outside of any brackets, those of templates too; without the defaults."""
    parts, depth, begins = [], 0, 0
    for i, c in enumerate(parameters + ","):
        if c in OPENING + "<":
            depth += 1
        elif c in CLOSING or (c == ">" and parameters[i - 1] != "-"):
            depth -= 1
        elif c == "," and depth <= 0:
            parts.append(" ".join(parameters[begins:i].split("=")[0].split()))
            begins = i + 1
    return [] if parts in ([""], ["void"]) else parts


def is_list_of_parameters(parts):
    return all(part == "..." or PARAMETER.match(part) and not re.search(r"^[\d.\"'{]|[^&]&&\s*!", part)
               for part in parts)


def parameters_in(head):
    """(name, parameters) of the function that `head` declares, or None."""
    if NO_FUNCTION.match(head):
        return None
    at, name_begins = 0, 0
    while at < len(head):
        c = head[at]
        operator = re.compile(r"operator\s*(\(\s*\)|[^\s\w(]+)\s*(?=\()").match(head, at)
        if operator:
            at = operator.end()
        elif c == "<":
            at = end_of(head, at, "<", ">")
        elif c == "=":
            return None
        elif c == "(":
            end, name = end_of(head, at, "(", ")"), NAME.search(head[name_begins:at])
            called = "".join(name.group().split()) if name else ""
            if called in BRACKETED:
                at = name_begins = end
                continue
            inside = head[at + 1:end - 1]
            is_macro = re.fullmatch(r"[A-Z][A-Z0-9_]{2,}", called)
            if not called or is_macro or inside.lstrip()[:1] in ("*", "&"):
                return None
            return called, split(inside)
        else:
            at += 1
    return None


def lambdas_in(body):
    """(offset, name, parameters) of every lambda."""
    for m in LAMBDA.finditer(body):
        at = end_of(body, m.end(), "<", ">") if body[m.end()] == "<" else m.end()
        at += len(body[at:]) - len(body[at:].lstrip())
        if body[at:at + 1] != "(":
            continue
        end = end_of(body, at, "(", ")")
        if re.match(r"\s*(mutable|noexcept|->|\{)", body[end:end + 40]):
            yield m.start(), "a lambda", split(body[at + 1:end - 1])


def functions(text, offset=0):
    """(offset, name, parameters) of every function that is declared or defined, in namespaces,
    types and functions. Strings, comments and preprocessor lines are blank already."""
    begins = at = 0
    while at < len(text):
        c = text[at]
        if c in "([":
            at = end_of(text, at, c, CLOSING[OPENING.index(c)])
        elif c == "}":
            begins = at = at + 1
        elif c == ";" or c == "{":
            head = text[begins:at]
            if c == "{" and SCOPE.match(head):
                begins = at = at + 1
                continue
            found = parameters_in(head)
            if found and is_list_of_parameters(found[1]):
                yield offset + begins + len(head) - len(head.lstrip()), *found
            if c == "{":
                at = end_of_body(text, at, ":" in head[head.rfind(")"):] if found else False)
            else:
                at += 1
            body = text[begins:at]
            for place, name, parameters in lambdas_in(body):
                yield offset + begins + place, name, parameters
            for local in LOCAL_SCOPE.finditer(body, len(head)):
                inner = body[local.end():end_of(body, local.end() - 1, "{", "}") - 1]
                for found in functions(inner, offset + begins + local.end()):
                    if found[1] != "a lambda":  # they have been seen in the body
                        yield found
            begins = at
        else:
            at += 1


def end_of_body(text, at, has_initialisers):
    """Behind the braces at `at`, and behind the body where they initialise a member before it."""
    end = end_of(text, at, "{", "}")
    while has_initialisers:
        follows = re.compile(r"\s*(?:,[^{;]*)?\{").match(text, end)
        if not follows:
            break
        end = end_of(text, follows.end() - 1, "{", "}")
    return end


def readable(text):
    for pattern in (DIRECTIVE, ATTRIBUTE, ACCESS):
        text = pattern.sub(lambda m: re.sub(r"[^\n]", " ", m.group()), text)
    return text


def findings(root, allowed=None, used=None):
    """A line for each function that breaks the rule; `used` collects the exceptions that apply."""
    for room in ROOMS:
        for path in sorted((root / room).rglob("*.[ch]pp")):
            file = path.relative_to(root).as_posix()
            text = readable(blanked(path.read_text(encoding="utf-8")))
            for offset, name, parameters in functions(text):
                place = f"{file}:{text.count(chr(10), 0, offset) + 1}: {name}"
                if len(parameters) > MOST:
                    yield f"{place} has {len(parameters)} parameters, expected at most {MOST}"
                for parameter in filter(BARE_BOOL.match, parameters):
                    if (file, name, parameter) not in (allowed or {}):
                        yield f"{place} takes \"{parameter}\", expected a value that tells what it is"
                    elif used is not None:
                        used.add((file, name, parameter))


def findings_in(text):
    """Of a repository that has nothing but this file."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "engine/a.hpp")
        file.parent.mkdir()
        file.write_text(text, encoding="utf-8")
        return list(findings(pathlib.Path(folder)))


class Parameters(unittest.TestCase):
    def test_functions_have_few_parameters_and_no_bare_bool(self):
        used = set()
        self.assertEqual(list(findings(ROOT, ALLOWED, used)), [])
        self.assertEqual(sorted(set(ALLOWED) - used), [], "allowed, but not there")

    def test_heads_of_every_form_are_read(self):
        five, four = "int a, B<C, D> b, const E& c, F (*d)(int, int), {} e = {}", "int a, B b, C c, D d"
        for before, after in [
                ("void f(", ");"), ("void f(", ") const override {}"), ("A::B<C>::f(", ") : x{1}, y(2) {}"),
                ("template <class T, int N = (1 > 0)>\n  requires(N > 1)\nauto g(\n", ") -> int {}"),
                ("struct S {\n bool operator()(", ") const;\n};"), ("explicit S(", ") noexcept;"),
                ("namespace {\nclass C : B<int (*)()> {\n public:\n  C& operator<<(", ");\n};\n}"),
                ("std::function<void(int, bool)> f(", ");"), ("[[nodiscard]] int f(", ") = delete;"),
                ("int x() {\n struct Local { void f(", ") {} };\n}"), ("auto f = [](", ") { return 1; };"),
                ("S() : a{1}, b(2) {}\nvoid f(", ");"), ("decltype(auto) f(", ") requires(x) {}"),
                ("int x() {\n  return sum([&]<class T>(", ") mutable {}, 2);\n}")]:
            with self.subTest(before=before, after=after):
                for kind in ("int", "std::array<int, 3>"):
                    found = findings_in(before + five.replace("{}", kind, 1) + after)
                    self.assertEqual(len(found), 1, found)
                    self.assertIn(" has 5 parameters", found[0])
                self.assertEqual(findings_in(before + four + after), [])
                self.assertEqual(findings_in(before + after), [])
                for parameter in ("bool", "bool b = true", "const bool b"):
                    found = findings_in(f"{before}int a, {parameter}{after}")
                    self.assertEqual(len(found), 1, found)
                    self.assertIn(" takes \"", found[0])
                for parameter in ("bool& b", "std::optional<bool> b", "bool (*b)(bool, int)"):
                    self.assertEqual(findings_in(f"{before}int a, {parameter}{after}"), [])

    def test_what_is_no_function_is_passed_over(self):
        for text in [
                "const Vec3 kPlace(1, 2, 3, 4, 5);", "int x = f(a, b, c, d, e);", "LIST(A, B, C, D, E)",
                "constexpr int kAll[] = {f(a, b, c, d, e), 2};", "#define F(int a, int b, int c, int d, "
                "bool e)\n", "// void f(bool a);\n", "bool (*take)(int, int, int, int, bool) = nullptr;",
                "using F = void (*)(int, int, int, int, bool);", "enum class E { a = f(1, 2, 3, 4, 5) };",
                "void f() {\n  g(a, b, c, d, e);\n  if (table[i](a, b, c, d, e)) return;\n}",
                "S(int n) : a(n, n, n, n, n), b{n, n, n, n, n}, c(n, n, n, n, n) {}"]:
            with self.subTest(text=text):
                self.assertEqual(findings_in(text), [])

    def test_a_function_is_named_with_its_place(self):
        found = findings_in("namespace a {\n\nint f(\n    bool yes);\n}\n")
        self.assertEqual(found, ["engine/a.hpp:3: f takes \"bool yes\", expected a value that tells "
                                 "what it is"])


if __name__ == "__main__":
    unittest.main()
