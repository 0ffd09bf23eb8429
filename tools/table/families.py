"""Families: files of tests/truth, and the scenes that they describe."""
import fnmatch
import json
import pathlib
import re

from expressions import Bad, Scope, Vector, norm
from references import Equation, Kept, Table
from transforms import shifted

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT / "tests/data/references"
RATES = [60, 240, 960]
KEYS = {"about", "parameters", "variants", "let", "scene", "solvers", "rates", "duration", "data", "ode", "table",
        "limit",
        "checks", "known", "random", "alike", "nightly", "pool", "expect"}


def filled(node, scope):
    """A template with what its formulas give: texts that begin with "=", {"for", "in", "each"} and
    {"if", "then", "else"}, both in lists."""
    if isinstance(node, str) and node.startswith("="):
        return scope.value(node[1:])
    if isinstance(node, dict):
        return {filled(k, scope): filled(v, scope) for k, v in node.items()}
    if not isinstance(node, list):
        return node
    out = []
    for item in node:
        if isinstance(item, dict) and "for" in item:
            kept = {name: scope.get(name) for name in item["for"].split()}
            for value in scope.value(item["in"]):
                values = value if len(kept) > 1 else [value]
                scope.update(zip(kept, values))
                out.extend(filled(item["each"] if isinstance(item["each"], list) else [item["each"]], scope))
            scope.update(kept)
        elif isinstance(item, dict) and "if" in item:
            chosen = item.get("then") if scope.value(item["if"]) else item.get("else")
            out.extend(filled([chosen] if chosen is not None else [], scope))
        else:
            out.append(filled(item, scope))
    return out


def solver_settings(name):
    """Of a word as "auto" or "lagrangian/rk4"."""
    kind, _, integrator = name.partition("/")
    return {"type": kind} | ({"integrator": integrator} if integrator else {})


class Case:
    """One scene of a family, with the names that its formulas may use."""

    def __init__(self, family, values, solver, rate):
        self.family, self.solver, self.rate, self.values = family, solver, rate, values
        self.origin = family.place  # where the scene stands in the World
        given = family.told.get("parameters", {}) | values
        seed = f"{family.name} {given.get('seed', 0)}"
        scope = Scope({"rate": rate, "h": 1 / rate, "solver": solver.split("/")[0]}).drawing(seed)
        if "data" in family.told:
            scope["data"] = family.data()
        for name, value in given.items():
            scope[name] = value
        for name, value in family.told.get("let", {}).items():
            scope[name] = filled(value, scope) if not isinstance(value, str) else scope.value(value)
        self.scope = scope
        self.duration = float(scope.value(family.told["duration"]))

    def scene(self):
        """As the program reads it."""
        told = self.family.told["scene"]
        if isinstance(told, str):
            told = filled(told, self.scope)
        base = {}
        if "file" in told:
            base = json.loads((ROOT / filled(told["file"], self.scope)).read_text())
            told = {k: v for k, v in told.items() if k != "file"}
        made = {"version": 1, "ground": False, "gravity": [0, -9.81, 0]} | base | filled(told, self.scope)
        if self.solver != "scene":
            made.setdefault("solver", {})
            made["solver"] = made["solver"] | solver_settings(self.solver)
        made |= {"step": 1 / self.rate, "duration": self.duration}
        return shifted(made, self.origin) if norm(self.origin) else made

    def reference(self):
        """What gives further names at a time, or none."""
        told = self.family.told
        if "ode" not in told and "table" not in told:
            return None

        def make():
            if "ode" in told:
                return Equation(told["ode"], self.scope)
            return Table(filled(told["table"], self.scope), DATA)
        key = json.dumps(self.values)
        return self.family.kept.setdefault(key, Kept(make))


class Family:
    def __init__(self, path):
        self.name, self.path = path.stem, path
        self.told = json.loads(path.read_text())
        unknown = set(self.told) - KEYS
        if unknown:
            raise Bad(f"{path.name}: unknown keys {sorted(unknown)}")
        self.solvers = self.told.get("solvers", ["auto", "lagrangian/rattle", "lagrangian/rk4", "lagrangian/implicit"])
        self.variants = self.told.get("variants", [{}])
        self.pool = self.told.get("pool", "worst")
        self.place = Vector((0, 0, 0))
        self.kept = {}  # references

    def case(self, values, solver, rate):
        return Case(self, values, solver, rate)

    def data(self):
        """The file of numbers that formulas may look into, as `data`."""
        return json.loads((ROOT / self.told["data"]).read_text())

    def choose(self, pattern):
        """Leaves the solvers that a pattern names."""
        if pattern:
            self.solvers = [s for s in self.solvers if any(fnmatch.fnmatch(s, p) or p in s for p in pattern.split(","))]

    def write_known(self, entries):
        """Puts the list of what is known to be red at the end of the file."""
        text = self.path.read_text()
        head = re.sub(r',\s*"known": \[.*?\]\s*\}\s*$', "", text, flags=re.S) if '"known"' in text else (
            text.rstrip().removesuffix("}").rstrip())
        lines = ",\n".join(f"    {json.dumps(e)}" for e in entries)
        self.path.write_text(f'{head},\n  "known": [\n{lines}\n  ]\n}}\n' if entries else f"{head}\n}}\n")

    def rates(self, solver, wanted):
        """Steps a second at which a solver is tried."""
        own = self.told.get("rates", RATES)
        if isinstance(own, dict):
            own = next((r for pattern, r in own.items() if fnmatch.fnmatch(solver, pattern)), RATES)
        return [r for r in own if not wanted or r in wanted]

    def known(self, solver, rate):
        """Why it is known to be wrong there, or none."""
        for entry in self.told.get("known", []):
            if entry["solver"] == solver and rate in entry["rates"]:
                return entry["why"]
        return None

    def known_of(self, solver):
        """Why it is known to be wrong at some rate, or none."""
        return next((e["why"] for e in self.told.get("known", []) if e["solver"] == solver and
                     any(isinstance(r, int) for r in e["rates"])), None)

    def bound(self, check, case):
        """Most that the error of a check may be; none where it is not asked."""
        if "when" in check and not case.scope.value(check["when"]):
            return None
        told = check.get("bound")
        if isinstance(told, dict):
            told = next((b for pattern, b in told.items() if fnmatch.fnmatch(case.solver, pattern)), None)
        if isinstance(told, dict):
            told = told.get(str(case.rate), told.get("else"))
        return None if told is None else float(case.scope.value(told))


def families(pattern, folder=None):
    """Those whose name holds the pattern, or is matched by it."""
    found = []
    for path in sorted((folder or ROOT / "tests/truth").glob("*.json")):
        if not pattern or any(fnmatch.fnmatch(path.stem, p) or p in path.stem for p in pattern.split(",")):
            found.append(Family(path))
    return found
