"""Formulas of a family's file: Python's expressions, without attributes and statements, over the
names that are given."""
import ast
import functools
import math
import random

NODES = (ast.Expression, ast.Constant, ast.Name, ast.Load, ast.Store, ast.BinOp, ast.UnaryOp, ast.operator,
         ast.unaryop, ast.Compare, ast.cmpop, ast.BoolOp, ast.boolop, ast.IfExp, ast.Call, ast.List,
         ast.Tuple, ast.Dict, ast.Subscript, ast.Slice, ast.Starred, ast.keyword, ast.ListComp, ast.GeneratorExp,
         ast.comprehension, ast.JoinedStr, ast.FormattedValue)


class Vector(tuple):
    """Numbers that add and scale; JSON writes it as a list."""

    def __add__(self, other):
        return Vector(a + b for a, b in zip(self, other, strict=True))

    __radd__ = __add__

    def __sub__(self, other):
        return Vector(a - b for a, b in zip(self, other, strict=True))

    def __rsub__(self, other):
        return Vector(b - a for a, b in zip(self, other, strict=True))

    def __mul__(self, factor):
        return Vector(a * factor for a in self)

    __rmul__ = __mul__

    def __truediv__(self, factor):
        return Vector(a / factor for a in self)

    def __neg__(self):
        return Vector(-a for a in self)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a, b):
    return Vector((a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))


def norm(a):
    return math.hypot(*a)


def unit(a):
    return Vector(a) / norm(a)


def turn(axis, angle):
    """Quaternion [x, y, z, w] of a turn about an axis."""
    half = unit(axis) * math.sin(angle / 2)
    return Vector((*half, math.cos(angle / 2)))


def after(p, q):
    """The turn q, then p."""
    u, v = Vector(p[:3]), Vector(q[:3])
    return Vector((*(v * p[3] + u * q[3] + cross(u, v)), p[3] * q[3] - dot(u, v)))


def inverse(q):
    return Vector((-q[0], -q[1], -q[2], q[3]))


def turned(q, v):
    """A vector turned by a quaternion."""
    u, v = Vector(q[:3]), Vector(v)
    around = cross(u, v)
    return v + around * (2 * q[3]) + cross(u, around) * 2


def angle_between(p, q):
    """Of two attitudes, rad."""
    d = after(inverse(p), q)
    return 2 * math.atan2(norm(d[:3]), abs(d[3]))


def shortest_turn(a, b):
    """Quaternion that turns direction a to b."""
    a, b = unit(a), unit(b)
    c = cross(a, b)
    if norm(c) < 1e-12:
        return Vector((0, 0, 0, 1)) if dot(a, b) > 0 else turn((a[1], -a[0], 0) if a[2] ** 2 < 0.5
                                                               else (0, a[2], -a[1]), math.pi)
    return turn(c, math.atan2(norm(c), dot(a, b)))


def euler_turn(degrees):
    """As "rotation_deg" of a scene: about the fixed x axis first, then y, then z."""
    q = (0, 0, 0, 1)
    for axis, angle in zip(((1, 0, 0), (0, 1, 0), (0, 0, 1)), degrees, strict=True):
        q = after(turn(axis, math.radians(angle)), q)
    return q


def median(values):
    ordered = sorted(values)
    middle = len(ordered) // 2
    return ordered[middle] if len(ordered) % 2 else (ordered[middle - 1] + ordered[middle]) / 2


def elliptic_k(m):
    """Complete elliptic integral of the first kind, of the parameter m = k^2."""
    a, b = 1.0, math.sqrt(1 - m)
    while abs(a - b) > 1e-16 * a:
        a, b = (a + b) / 2, math.sqrt(a * b)
    return math.pi / (2 * a)




PLAIN = {name: getattr(math, name) for name in (
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh", "exp", "log",
    "sqrt", "hypot", "floor", "ceil", "pi", "degrees", "radians", "inf", "isfinite", "copysign")}
PLAIN |= {f.__name__: f for f in (dot, cross, norm, unit, turn, after, inverse, turned, angle_between, shortest_turn,
                                  euler_turn, median, elliptic_k, abs, min, max, sum, len, range, round, int, float,
                                  str, sorted, all, any, zip, enumerate)}
PLAIN |= {"true": True, "false": False, "vec": lambda *v: Vector(v)}


class Bad(ValueError):
    """A family's file says something that cannot be meant."""


@functools.lru_cache(maxsize=None)
def compiled(text):
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except SyntaxError as fault:
        raise Bad(f"not a formula: {text!r} ({fault.msg})") from None
    for node in ast.walk(tree):
        if not isinstance(node, NODES):
            raise Bad(f"{type(node).__name__} is not allowed in a formula: {text!r}")
        if isinstance(node, ast.Call) and not isinstance(node.func, ast.Name):
            raise Bad(f"only names are called in a formula: {text!r}")
        if isinstance(node, ast.Name) and node.id.startswith("_"):
            raise Bad(f"name {node.id!r} in a formula: {text!r}")
    return compile(tree, "<formula>", "eval")


class Scope(dict):
    """Names and what they are; formulas are evaluated in it."""

    def __init__(self, names=()):
        super().__init__(PLAIN)
        self["__builtins__"] = {}
        self["root"] = self.root
        self.update(names)

    def value(self, text):
        """Of a formula; what is no text is its own value."""
        if not isinstance(text, str):
            return text
        try:
            return eval(compiled(text), self)  # noqa: S307, names and nodes are those of above
        except Bad:
            raise
        except Exception as fault:
            raise Bad(f"{text!r}: {fault}") from fault

    def root(self, text, low, high):
        """Where a formula in x changes sign, by bisection."""
        at = Scope(self)

        def f(x):
            at["x"] = x
            return at.value(text)
        below = f(low)
        if below * f(high) > 0:
            raise Bad(f"root: {text!r} does not change sign from {low} to {high}")
        for _ in range(200):
            middle = (low + high) / 2
            if middle in (low, high):
                break
            if (f(middle) > 0) == (below > 0):
                low = middle
            else:
                high = middle
        return (low + high) / 2

    def drawing(self, seed):
        """Adds what draws at random, the same for the same seed."""
        source = random.Random(seed)

        def direction():
            while True:
                v = Vector(source.uniform(-1, 1) for _ in range(3))
                if 0.01 < norm(v) < 1:
                    return unit(v)

        self.update(uniform=source.uniform, pick=source.choice, whole=source.randint, direction=direction,
                    log_uniform=lambda a, b: math.exp(source.uniform(math.log(a), math.log(b))),
                    any_rotation=lambda: turn(direction(), source.uniform(0, math.pi)))
        return self
