"""Reads scenes as tools/peers/motion spells them out, and writes what came of them (motion.hpp)."""
import array
import math
import types


def rotated(q, v, sign=1):
    """v turned by the rotation q = (x, y, z, w), or back."""
    u, w = [sign * x for x in q[:3]], q[3]

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    inner = [c + w * x for c, x in zip(cross(u, v), v)]
    return [x + 2 * c for x, c in zip(v, cross(u, inner))]


def product(p, q):
    (a, b, c, d), (e, f, g, h) = p, q
    return [d * e + a * h + b * g - c * f, d * f - a * g + b * h + c * e, d * g + a * f - b * e + c * h,
            d * h - a * e - b * f - c * g]


class Scene:
    """Bodies with name, motion, mass, inertia, position, rotation (x, y, z, w); joints with a, b (bodies
    by number, -1: the world), is_hinge, and at the start, in world axes, anchor and axis; springs
    with a, b, anchors in the axes of a and b, length and stiffness; torques, pairs of a body and a
    constant torque in world axes."""

    def __init__(self, path):
        self.bodies, self.joints, self.sway, self.rate, self.parts = [], [], None, 60, 1
        self.springs, self.torques = [], []
        with open(path) as lines:
            for line in lines:
                kind, *words = line.split()
                getattr(self, "read_" + kind, lambda words: None)(words)
        axes = [j.axis for j in self.joints if j.is_hinge]
        self.is_planar = len(axes) == len(self.joints) and all(
            abs(abs(sum(x * y for x, y in zip(a, axes[0]))) - 1) < 1e-9 for a in axes)

    def read_gravity(self, words):
        self.gravity = [float(w) for w in words]

    def read_frames(self, words):
        self.frames = int(words[0])

    def read_rate(self, words):
        self.rate = int(words[0])

    def read_parts(self, words):
        self.parts = int(words[0])

    def read_body(self, words):
        n = [float(w) for w in words[3:]]
        self.bodies.append(types.SimpleNamespace(
            name=words[0], motion=words[1], mass=n[0], inertia=n[1:4], position=n[4:7], rotation=n[7:11]))

    def read_joint(self, words):
        a, b = int(words[1]), int(words[2])
        n = [float(w) for w in words[3:]]
        position, rotation = ([0, 0, 0], [0, 0, 0, 1]) if a < 0 else \
            (self.bodies[a].position, self.bodies[a].rotation)
        self.joints.append(types.SimpleNamespace(
            a=a, b=b, is_hinge=words[0] == "hinge",
            anchor=[p + r for p, r in zip(position, rotated(rotation, n[0:3]))],
            axis=rotated(rotation, rotated(n[6:10], [1, 0, 0]))))

    def read_spring(self, words):
        n = [float(w) for w in words[2:]]
        self.springs.append(types.SimpleNamespace(
            a=int(words[0]), b=int(words[1]), anchor_a=n[0:3], anchor_b=n[3:6], length=n[6], stiffness=n[7]))

    def read_torque(self, words):
        self.torques.append((int(words[0]), [float(w) for w in words[1:]]))

    def read_sway(self, words):
        n = [float(w) for w in words[1:]]
        self.sway = types.SimpleNamespace(body=int(words[0]), centre=n[0:3], amplitude=n[3:6],
                                          rate=[2 * math.pi * x for x in n[6:9]], phase=n[9:12])


def write_motion(path, told, frames):
    """`told`: pairs of words. `frames`: of each, CPU ms and the positions of all bodies."""
    with open(path, "wb") as out:
        for key, value in told:
            out.write(f"{key} {value}\n".encode())
        begun = False
        for ms, places in frames:
            if not begun:
                out.write(f"frames {len(places)}\n".encode())
                begun = True
            numbers = array.array("d", [ms, 0])
            for place in places:
                numbers.extend([*place, *[0.0] * 10])
            out.write(numbers.tobytes())
        if not begun:
            out.write(b"frames 0\n")
