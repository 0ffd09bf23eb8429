"""Cells of the table: a family under a solver at a rate, right, told or wrong."""
import dataclasses
import fnmatch
import json
import math
import threading

from expressions import Bad, Scope, median
from running import run

MOST_PLACES = 200  # of a run, where a check is asked all along
GREEN, TOLD, RED = "green", "told", "red"


@dataclasses.dataclass
class Cell:
    family: str
    solver: str
    rate: int
    verdict: str = GREEN
    said: str = ""        # the worst check, or what happened
    ratio: float = 0.0    # error over bound of the worst check
    found: tuple = ()     # what the runs told
    known: str = ""       # why it is known to be wrong
    errors: dict = dataclasses.field(default_factory=dict)  # of each check
    values: dict = dataclasses.field(default_factory=dict)  # of the worst variant


class Limits:
    """Runs at short steps that others are held against: {"limit": {"solver": ..., "rate": ...}}; without
    a solver each is held against itself."""

    def __init__(self, program):
        self.program, self.kept, self.lock = program, {}, threading.Lock()

    def of(self, case):
        told = case.family.told.get("limit")
        if told is None:
            return None
        solver = told.get("solver", case.solver)
        key = (case.family.name, solver, json.dumps(case.values))
        with self.lock:
            waiting = self.kept.setdefault(key, threading.Lock())
        if isinstance(waiting, Limit):
            return waiting
        with waiting:
            if not isinstance(self.kept[key], Limit):
                fine = case.family.case(case.values, solver, told["rate"])
                self.kept[key] = Limit(run(self.program, fine.scene()), told["rate"])
        found = self.kept[key]
        if found.run.refusal or found.run.crash:
            raise Bad(f"the limit cannot be run: {found.run.refusal or found.run.crash}")
        return found


@dataclasses.dataclass
class Limit:
    run: object
    rate: int


class Asked:
    """What a family's checks are asked of: a case that was run."""

    def __init__(self, program, case, limits):
        self.case = case
        self.run = run(program, case.scene())
        self.run.origin = case.origin
        self.limit = limits.of(case)

    def errors(self):
        """The error of each check, the worst of its times."""
        reference = self.case.reference()
        family = self.case.family
        checks = {n: c for n, c in family.told.get("checks", {}).items() if family.bound(c, self.case) is not None}
        scope = Scope(self.case.scope)
        scope["told"] = self.run.report.get
        scope.update(self.run.names_at(0, "start_"))
        due = {}
        for name, check in checks.items():
            for step in self.steps(check):
                due.setdefault(step, []).append((name, check))
        worst = dict.fromkeys(checks)
        for step in sorted(due):
            if not self.place(scope, step, reference):
                continue
            for name, check in due[step]:
                error = scope.value(check["error"])
                worst[name] = max(worst[name] or 0.0, error if math.isfinite(error) else math.inf)
        asked = {name: error for name, error in worst.items() if error is not None}
        if not asked and self.run.report.get("status", "ok") in ("ok", "doubtful"):
            raise Bad("no check was asked: no time of the table is that of a step")
        return asked

    def steps(self, check):
        """The steps after which a check is asked: at the end, at times, or all along."""
        last = len(self.run) - 1
        times = check.get("times", "end")
        if times == "end":
            return [last]
        if times == "all":
            return sorted({*range(0, last + 1, 1 + last // MOST_PLACES), last})
        return sorted({min(last, round(t * self.case.rate)) for t in self.case.scope.value(times)})

    def place(self, scope, step, reference):
        """Puts the names of a step into the scope; false where a table has no row."""
        t = step / self.case.rate
        scope["t"] = t
        scope.update(self.run.names_at(step))
        if self.limit is not None:
            last = len(self.limit.run) - 1
            scope.update(self.limit.run.names_at(min(last, round(t * self.limit.rate)), "limit_"))
        if reference is not None:
            names = reference.at(t)
            if names is None:
                return False
            scope.update(names)
        return True


def judged(program, family, solver, rate, limits):
    """A cell from all variants of a family."""
    cell = Cell(family.name, solver, rate, known=family.known(solver, rate) or "")
    asked = []
    for values in family.variants:
        case = family.case(values, solver, rate)
        asked.append((values, outcome(program, case, limits)))
    if family.pool == "median":
        pool(family, solver, rate, asked)
    for values, one in asked:
        if (severity(one), one.ratio) > (severity(cell), cell.ratio) or not cell.errors:
            cell.verdict, cell.said, cell.ratio, cell.errors, cell.values, cell.found = (
                one.verdict, one.said, one.ratio, one.errors, values, one.found)
    return cell


def severity(cell):
    return (GREEN, TOLD, RED).index(cell.verdict)


def pool(family, solver, rate, asked):
    """The median of all variants takes the place of each one's error."""
    whole = [one for _, one in asked if one.errors]
    if not whole:
        return
    for name in whole[0].errors:
        middle = median([one.errors[name] for one in whole if name in one.errors])
        for one in whole:
            one.errors[name] = middle
    case = family.case(asked[0][0], solver, rate)
    for one in whole:
        weigh(one, case)


def outcome(program, case, limits):
    """What one run came to."""
    cell = Cell(case.family.name, case.solver, case.rate)
    expected = case.family.told.get("expect")
    try:
        asked = Asked(program, case, limits)
        one = asked.run
        cell.found = tuple(one.told)
        if one.crash:
            cell.verdict, cell.said, cell.ratio = RED, one.crash, math.inf
        elif expected == "silent" and one.told:
            cell.verdict, cell.said, cell.ratio = RED, f"a false alarm: {one.told[0]}", math.inf
        elif expected == "told":
            cell.verdict, cell.said = (TOLD, one.told[0]) if one.told else (RED, "says ok")
        elif one.refusal:
            cell.verdict, cell.said = TOLD, one.refusal
        else:
            cell.errors = asked.errors()
            # A fall without end may be right: that warning says nothing about the result.
            cell.found += tuple(w for w in one.warned if "falls forever" not in w)
            weigh(cell, case)
    except Bad as fault:
        raise Bad(f"{case.family.name} {case.values} under {case.solver} at {case.rate} Hz: {fault}") from None
    return cell


def weigh(cell, case):
    """Errors against bounds."""
    cell.ratio, cell.said = 0.0, ""
    for name, check in case.family.told.get("checks", {}).items():
        if name not in cell.errors:
            continue
        bound = case.family.bound(check, case)
        ratio = cell.errors[name] / bound if bound > 0 else math.inf if cell.errors[name] > 0 else 0.0
        if ratio >= cell.ratio:
            cell.ratio, cell.said = ratio, f"{name} {cell.errors[name]:.3g}, bound {bound:.3g}"
    cell.verdict = GREEN if cell.ratio <= 1 else TOLD if cell.found else RED


def order_of(cells, name):
    """The order with which a check's error falls over a solver's rates, from the coarsest to the finest."""
    first, last = cells[0], cells[-1]
    e, f = first.errors[name], last.errors[name]
    return math.log(e / f) / math.log(last.rate / first.rate) if e > 0 and f > 0 else math.inf


def hold_order(family, solver, cells):
    """The finest cell is wrong where errors do not fall as a check asks."""
    if [c.rate for c in cells] != family.rates(solver, None):
        return
    for name, check in family.told.get("checks", {}).items():
        for pattern, least in check.get("order", {}).items():
            with_errors = [c for c in cells if name in c.errors]
            if not fnmatch.fnmatch(solver, pattern) or len(with_errors) < 2:
                continue
            order = order_of(with_errors, name)
            if order < least and with_errors[-1].errors[name] > check.get("floor", 1e-9):
                last = with_errors[-1]
                last.verdict = TOLD if last.found else RED
                last.said = f"{name} falls with order {order:.2f}, at least {least} expected"
                last.ratio = max(last.ratio, 1.01)
