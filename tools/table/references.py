"""What a run is held against: an ordinary differential equation integrated to 1e-10, or a table."""
import bisect
import json
import threading

from expressions import Bad, Scope

# The pair of order 5 and 4 of Dormand and Prince (1980).
STAGES = ((), (1 / 5,), (3 / 40, 9 / 40), (44 / 45, -56 / 15, 32 / 9),
          (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
          (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
          (35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84))
NODES = (0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1)
ERRORS = (71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
TOLERANCE = 1e-10


class Equation:
    """{"state": {name: start}, "phases": [{"let": {}, "rate": {name: formula}, "until": formula, "then": {}}]}.

    A phase ends where the formula under "until" falls below 0; "then" changes the state there. With
    one phase, "let" and "rate" may stand beside "state"."""

    def __init__(self, told, names):
        self.scope = Scope(names)
        self.names = list(told["state"])
        self.start = [float(self.scope.value(told["state"][n])) for n in self.names]
        self.phases = told.get("phases") or [told]
        for phase in self.phases:
            if sorted(phase["rate"]) != sorted(self.names):
                raise Bad(f"an equation has rates of {sorted(phase['rate'])}, a state of {self.names}")
        self.t, self.y, self.phase, self.h = 0.0, self.start, 0, 1e-4

    def _set(self, t, y):
        self.scope["t"] = t
        self.scope.update(zip(self.names, y))
        for name, formula in self.phases[self.phase].get("let", {}).items():
            self.scope[name] = self.scope.value(formula)

    def _rate(self, t, y):
        self._set(t, y)
        rate = self.phases[self.phase]["rate"]
        return [self.scope.value(rate[n]) for n in self.names]

    def _step(self, h):
        """The state after h, and its error in units of the tolerance."""
        k = []
        for stage, node in zip(STAGES, NODES):
            y = [v + h * sum(a * s[i] for a, s in zip(stage, k)) for i, v in enumerate(self.y)]
            k.append(self._rate(self.t + node * h, y))
        error = max(abs(h * sum(e * s[i] for e, s in zip(ERRORS, k))) / (TOLERANCE * (1 + abs(v)))
                    for i, v in enumerate(y))
        return y, error

    def _ended(self, t, y):
        until = self.phases[self.phase].get("until")
        if until is None:
            return False
        self._set(t, y)
        return self.scope.value(until) < 0

    def _change(self):
        """Into the next phase, with what happens there."""
        self._set(self.t, self.y)
        changed = {n: self.scope.value(f) for n, f in self.phases[self.phase].get("then", {}).items()}
        self.y = [changed.get(n, v) for n, v in zip(self.names, self.y)]
        self.phase = min(self.phase + 1, len(self.phases) - 1) if not self.phases[self.phase].get("again") else 0

    def at(self, time):
        """The state at a time not before those asked for already, by name."""
        while self.t < time - 1e-15 * (1 + time):
            h = min(self.h, time - self.t)
            y, error = self._step(h)
            if error > 1 and h > 1e-12:
                self.h = h * max(0.2, 0.9 * error ** -0.2)
                continue
            if self._ended(self.t + h, y):
                low, high = 0.0, h
                for _ in range(60):
                    middle = (low + high) / 2
                    if self._ended(self.t + middle, self._step(middle)[0]):
                        high = middle
                    else:
                        low = middle
                self.y, self.t = self._step(high)[0], self.t + high
                self._change()
                continue
            self.t, self.y = self.t + h, y
            if h == self.h or error > 0.1:
                self.h = h * min(4, 0.9 * max(error, 1e-8) ** -0.2)
        self._set(self.t, self.y)
        return {n: self.scope[n] for n in (*self.names, *self.phases[self.phase].get("let", {}))}


class Table:
    """{"file": ..., "case": id} of tests/data/references, or {"columns": [names], "rows": [...]}. The
    first column is the time. A scalar of the file is a name as well."""

    def __init__(self, told, folder):
        self.scalars = {}
        if "file" in told:
            cases = json.loads((folder / told["file"]).read_text())["cases"]
            case = next((c for c in cases if c["id"] == told["case"]), None)
            if case is None:
                raise Bad(f"{told['file']} has no case {told['case']!r}, but {[c['id'] for c in cases]}")
            self.columns = [c["name"] for c in case["columns"]]
            self.rows = case["samples"]
        else:
            self.columns, self.rows = told["columns"], told["rows"]
        self.times = [row[0] for row in self.rows]

    def at(self, time):
        """The row of a time, by name; none if it has none."""
        i = bisect.bisect_left(self.times, time - 1e-9)
        if i == len(self.times) or abs(self.times[i] - time) > 1e-9:
            return None
        return dict(zip(self.columns, self.rows[i]))


class Kept:
    """A reference that remembers: solvers and rates of a family ask for the same times."""

    def __init__(self, make):
        self.make, self.reference, self.last, self.known, self.lock = make, None, 0.0, {}, threading.Lock()

    def at(self, time):
        key = round(time, 12)
        with self.lock:
            if key not in self.known:
                if self.reference is None or time < self.last:
                    self.reference = self.make()
                self.known[key], self.last = self.reference.at(time), time
            return self.known[key]
