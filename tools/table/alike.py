"""Rows of the table that need no closed form: two scenes that have to end alike."""
import concurrent.futures
import fnmatch
import math

from expressions import norm, turn
from judging import GREEN, RED, TOLD, Cell
from running import run
from transforms import Mirror, NotMeant, Rigid, heavier, moved, reordered

MOTIONS = {"turned": Rigid(turn((0, 1, 0), math.radians(37))), "tilted": Rigid(turn((1, 2, 3), 1)),
           "shifted": Rigid(shift=(31.7, 12.9, -55.3)), "mirrored": Mirror()}
OTHERS = {"heavier": heavier, "reordered": reordered}
BOUND = 1e-8  # of the scene's size, m


def other(scene, how):
    return OTHERS[how](scene) if how in OTHERS else moved(scene, MOTIONS[how])


def apart(one, two, how):
    """The largest distance of a body from where the first run says it should be, and which body."""
    motion = MOTIONS.get(how, Rigid())
    a, b = (r.names_at(len(r) - 1)["pos"] for r in (one, two))
    return max(((norm(motion.point(a(body)) - b(body)), body) for body in one.bodies()), default=(0.0, ""))


def bound_of(family, solver, how):
    told = family.told.get("alike", {})
    for pattern, bounds in told.items():
        if fnmatch.fnmatch(solver, pattern):
            bound = bounds.get(how, bounds.get("else", BOUND)) if isinstance(bounds, dict) else bounds
            return bound
    return BOUND


def compare(program, family, solver, how):
    """The worst of a family's variants; none where the transformation does not know the scene."""
    cell = Cell(family.name, solver, how)
    bound = bound_of(family, solver, how)
    rate = family.rates(solver, [])[0]
    for values in family.variants[:4]:
        scene = family.case(values, solver, rate).scene()
        try:
            changed = other(scene, how)
        except NotMeant:
            return None
        one, two = run(program, scene), run(program, changed)
        cell.found = tuple(dict.fromkeys((*cell.found, *one.told, *two.told)))
        if (one.refusal is None) != (two.refusal is None) or one.crash or two.crash:
            cell.verdict, cell.said, cell.ratio = RED, f"ends otherwise: {two.refusal or two.crash}", math.inf
        elif not one.refusal:
            distance, body = apart(one, two, how)
            if not distance / bound <= cell.ratio:
                cell.ratio, cell.values = distance / bound, values
                cell.said = f"{body} is {distance:.2g} m elsewhere, bound {bound:.2g}"
    if cell.verdict == GREEN and not cell.ratio <= 1:
        cell.verdict = TOLD if cell.found else RED
    return cell


def compared(program, found, args):
    jobs = [(f, s, how) for f in found if f.told.get("alike") is not None for s in f.solvers
            for how in (*MOTIONS, *OTHERS)]
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        return [c for c in pool.map(lambda job: compare(program, *job), jobs) if c is not None]
