"""Makes nurbs.json: values of the PyPI packages geomdl and splipy, and the sections `surfaces`,
`nurbs_eval` and `closest` of the method's vectors, which geomdl, SISL and 50-digit arithmetic checked.

usage: nurbs.py VECTORS > nurbs.json     VECTORS: the file that has these sections; needs
                                         pip install geomdl splipy
"""
import json
import random
import sys

import numpy
import splipy
from geomdl import NURBS

dice = random.Random(7)


def knots(degree, count):
    inner = sorted(dice.uniform(0.05, 0.95) for _ in range(count - degree - 1))
    return [0.0] * (degree + 1) + inner + [1.0] * (degree + 1)


def net(count):
    points = [[dice.uniform(-1, 1) for _ in range(3)] for _ in range(count)]
    return points, [dice.uniform(0.5, 2) for _ in range(count)]


def curve_case(degree, count):
    points, weights = net(count)
    U = knots(degree, count)
    curve = NURBS.Curve()
    curve.degree = degree
    curve.ctrlptsw = [[c * w for c in p] + [w] for p, w in zip(points, weights)]
    curve.knotvector = U
    twin = splipy.Curve(splipy.BSplineBasis(degree + 1, U),
                        numpy.array(curve.ctrlptsw), rational=True, raw=True)
    case = {"degree": degree, "knots": U, "points": points, "weights": weights, "at": [], "splipy": []}
    for _ in range(4):
        t = dice.random()
        case["at"].append({"t": t, "derivatives": curve.derivatives(t, 3)})
        case["splipy"].append([[float(x) for x in (twin(t) if k == 0 else twin.derivative(t, k))]
                               for k in range(3)])
    # Control points after a knot, and after a degree, by splipy; each times its weight.
    knot = dice.uniform(0.1, 0.9)
    finer = twin.clone()
    finer.insert_knot(knot)
    higher = twin.clone()
    higher.raise_order(1)
    case["with_knot"] = {"knot": knot, "points": finer.controlpoints.tolist()}
    case["elevated"] = {"knots": list(higher.bases[0].knots), "points": higher.controlpoints.tolist()}
    return case


def surface_case(p, q, rows, columns):
    points, weights = net(rows * columns)
    surface = NURBS.Surface()
    surface.degree_u, surface.degree_v = p, q
    surface.set_ctrlpts([[c * w for c in x] + [w] for x, w in zip(points, weights)], rows, columns)
    U, V = knots(p, rows), knots(q, columns)
    surface.knotvector_u, surface.knotvector_v = U, V
    case = {"p": p, "q": q, "U": U, "V": V, "points": points, "weights": weights, "at": []}
    for _ in range(4):
        u, v = dice.random(), dice.random()
        d = surface.derivatives(u, v, 3)
        case["at"].append({"u": u, "v": v, "derivatives": [[d[k][l] for l in range(4 - k)]
                                                           for k in range(4)]})
    return case


def main():
    given = json.load(open(sys.argv[1], encoding="utf-8"))
    made = {key: given[key] for key in ("surfaces", "nurbs_eval", "closest")}
    made["curves"] = [curve_case(p, n) for p, n in ((1, 5), (2, 6), (3, 7), (4, 9), (5, 8))]
    made["patches"] = [surface_case(*s) for s in ((1, 2, 4, 5), (2, 3, 5, 6), (3, 3, 7, 6), (5, 4, 7, 6))]
    print("{")
    print(",\n".join(f'"{k}": {json.dumps(v)}' for k, v in made.items()))
    print("}")


if __name__ == "__main__":
    main()
