"""Draws from the ranges of the families: sizes, masses, speeds, steps, places."""
import concurrent.futures
import json
import math

from expressions import Scope, Vector
from judging import Limits, RED, outcome
from transforms import NotMeant


def drawn_case(family, seed):
    """A case of a family at random, the same for the same seed."""
    scope = Scope(family.told.get("parameters", {})).drawing(seed)
    values = dict(scope.value("pick")(family.variants))
    scope.update(values)
    for name, formula in family.told["random"].items():
        if name != "rate":
            values[name] = scope[name] = scope.value(formula)
    rate = round(scope.value(family.told["random"].get("rate", "log_uniform(30, 1000)")))
    case = family.case(values, scope.value("pick")(family.solvers), rate)
    angle, far = scope.value("uniform(0, 2 * pi)"), scope.value("pick([0, log_uniform(1, 1e4)])")
    case.origin = Vector((far * math.cos(angle), 0.0, far * math.sin(angle)))
    return case


def drawn(program, found, args):
    """N cells; those that are red say how to repeat them."""
    willing = [f for f in found if "random" in f.told]
    limits = Limits(program)

    def one(i):
        family = willing[i % len(willing)]
        case = drawn_case(family, f"{args.seed} {i} {family.name}")
        try:
            cell = outcome(program, case, limits)
        except NotMeant:
            case.origin = Vector((0, 0, 0))
            cell = outcome(program, case, limits)
        cell.values = case.values
        if cell.verdict == RED:
            cell.known = family.known_of(case.solver) or ""
            sets = " ".join(f"--set '{name}={json.dumps(value)}'" for name, value in case.values.items())
            place = ",".join(str(x) for x in case.origin)
            cell.said += (f"; tools/truth --only {family.name} --solver {case.solver} --rates {case.rate} "
                          f"--place={place} {sets}")
        return cell
    if not willing:
        return []
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        return list(pool.map(one, range(args.random)))
