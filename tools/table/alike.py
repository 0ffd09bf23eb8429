"""Rows of the table that need no closed form: two scenes that have to end alike."""
import concurrent.futures
import fnmatch
import math

from expressions import norm, turn
from judging import RED, TOLD, Cell
from running import run
from transforms import Mirror, NotMeant, Rigid, heavier, moved, reordered

MOTIONS = {"turned": Rigid(turn((0, 1, 0), math.radians(37))), "tilted": Rigid(turn((1, 2, 3), 1)),
           "shifted": Rigid(shift=(31.7, 12.9, -55.3)), "mirrored": Mirror()}
OTHERS = {"heavier": heavier, "reordered": reordered}
BOUND = 1e-7  # m
VARIANTS = 2  # of a family that are compared


def other(scene, how):
    return OTHERS[how](scene) if how in OTHERS else moved(scene, MOTIONS[how])


def apart(one, two, how):
    """The largest distance of a body from where the first run says it should be, and which body."""
    motion = MOTIONS.get(how, Rigid())
    a, b = (r.names_at(len(r) - 1)["pos"] for r in (one, two))
    return max(((norm(motion.point(a(body)) - b(body)), body) for body in one.bodies() if body != "world"),
               default=(0.0, ""))


def bound_of(family, solver, how):
    told = family.told.get("alike", {})
    for pattern, bounds in told.items():
        if fnmatch.fnmatch(solver, pattern):
            bound = bounds.get(how, bounds.get("else", BOUND)) if isinstance(bounds, dict) else bounds
            return bound
    return BOUND


def compare(program, family, solver):
    """A cell for each transformation that knows the scene: the worst of a family's first variants."""
    cells = {how: Cell(family.name, solver, how, known=family.known(solver, how) or "") for how in (*MOTIONS, *OTHERS)}
    unknown = set()
    rate = family.rates(solver, None)[0]
    for values in family.variants[:VARIANTS]:
        scene = family.case(values, solver, rate).scene()
        one = run(program, scene)
        for how, cell in cells.items():
            try:
                if solver.startswith("planar") and how in ("turned", "tilted"):
                    raise NotMeant("leaves the plane")
                changed = other(scene, how)
            except NotMeant:
                unknown.add(how)
                continue
            judge(cell, one, run(program, changed), bound_of(family, solver, how))
            if cell.said and not cell.values:
                cell.values = values
    return [cell for how, cell in cells.items() if how not in unknown]


def judge(cell, one, two, bound):
    """Two runs that have to end alike."""
    if (one.refusal is None) != (two.refusal is None) or one.crash or two.crash:
        cell.verdict, cell.ratio = RED, math.inf
        cell.said = f"ends otherwise: {two.refusal or two.crash or one.refusal or one.crash}"
    elif not one.refusal:
        distance, body = apart(one, two, cell.rate)
        if not distance / bound <= cell.ratio:
            cell.ratio, cell.found = distance / bound, tuple(one.told + two.told)
            cell.said = f"{body} is {distance:.2g} m elsewhere, bound {bound:.2g}"
            if cell.ratio > 1:
                cell.verdict = TOLD if cell.found else RED


def compared(program, found, args):
    jobs = [(f, s) for f in found if f.told.get("alike") is not None for s in f.solvers]
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        return [c for cells in pool.map(lambda job: compare(program, *job), jobs) for c in cells]
