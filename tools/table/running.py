"""One run of the program, and what it left."""
import csv
import json
import pathlib
import subprocess
import tempfile

from expressions import Vector


class Run:
    """What a run said of itself, and its record."""

    def __init__(self, report, refusal, crash, header, lines):
        self.report, self.refusal, self.crash = report, refusal, crash
        self.columns = {name: i for i, name in enumerate(header)}
        self.lines = lines
        self.origin = Vector((0, 0, 0))  # of the positions that formulas see
        self.read = {}                   # rows that were asked for

    @property
    def told(self):
        """What names that the result is doubtful: findings, a status other than ok, a refusal."""
        if self.refusal:
            return [f"refused: {self.refusal}"]
        status = self.report.get("status", "ok")
        found = [f"{f['kind']} at {f['where']}, {f['amount']:.3g} {f['unit']}" for f in self.report.get("findings", [])]
        return found + ([status] if status not in ("ok", "doubtful") else [])

    @property
    def warned(self):
        """What the program said as it read the scene."""
        return [f"warning: {text}" for text in self.report.get("warnings", [])]

    def row(self, step):
        if step not in self.read:
            self.read[step] = [float(v) if v else float("nan") for v in self.lines[step].split(",")]
        return self.read[step]

    def __len__(self):
        return len(self.lines)

    def names_at(self, step, prefix=""):
        """Functions of a body's name for formulas, and energies and momenta, after a step."""
        row, columns = self.row(step), self.columns

        def read(ends, origin=None):
            def of(body):
                if f"{body}.{ends[0]}" not in columns:
                    raise KeyError(f"no body {body!r} in the record")
                value = Vector(row[columns[f"{body}.{end}"]] for end in ends)
                return value if origin is None else value - origin
            return of
        found = {"pos": read(("x", "y", "z"), self.origin), "vel": read(("vx", "vy", "vz")), "spin": read(("wx", "wy", "wz")),
                 "quat": read(("qx", "qy", "qz", "qw")), "energy": row[columns["energy_j"]],
                 "kinetic": row[columns["kinetic_j"]], "potential": row[columns["potential_j"]],
                 "bodies": self.bodies(),
                 "momentum": Vector(row[columns[c]] for c in ("px", "py", "pz")),
                 "angular_momentum": Vector(row[columns[c]] for c in ("lx", "ly", "lz"))}
        return {prefix + name: value for name, value in found.items()}

    def bodies(self):
        return [name[:-3] for name in self.columns if name.endswith(".qw")]


def run(program, scene, timeout=300):
    """A scene as the program runs it. Its exit codes: 2 refuses the scene, 3 ended early by name."""
    with tempfile.TemporaryDirectory(prefix="truth") as folder:
        file, record = pathlib.Path(folder) / "scene.json", pathlib.Path(folder) / "record.csv"
        file.write_text(json.dumps(scene))
        try:
            done = subprocess.run([program, "run", file, "--json", "--record", record], capture_output=True,
                                  text=True, timeout=timeout, check=False)
        except subprocess.TimeoutExpired:
            return Run({}, None, f"took more than {timeout} s", [], [])
        if done.returncode == 2:
            return Run({}, done.stderr.strip().replace(str(file), "scene"), None, [], [])
        if done.returncode not in (0, 3):
            return Run({}, None, f"exit code {done.returncode}: {done.stderr.strip()[-300:]}", [], [])
        lines = record.read_text().splitlines()
        report = json.loads(done.stdout.replace(str(file), "scene"))
        return Run(report, None, None, next(csv.reader(lines[:1])), lines[1:])
