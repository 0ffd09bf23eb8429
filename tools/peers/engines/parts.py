"""Bodies, joints and whatever else a scene file has of what tools/peers/motion gives to all engines."""
import json
import math
import pathlib
import sys

from spelt import product, rotated

RATE = 15  # frames of a second, at which errors are measured and no step is longer
SHORT, FRAMES = 0.5, 30  # s; shorter scenes have so many frames in all
OF_BODY = {"name", "position", "rotation_deg", "mass", "inertia", "drag", "shape", "shapes", "motion"}
OF_JOINT = {"name", "kind", "a", "b", "anchor", "axis"}
OF_SPRING = {"name", "kind", "a", "b", "point_a", "point_b", "length", "stiffness"}
OF_PUSH = {"type", "body", "torque"}
OF_INSTANCE, OF_PREFAB = {"name", "prefab", "position"}, {"name", "bodies", "joints"}
OF_CHAIN = {"name", "links", "length", "shape", "materials", "mass", "inertia", "mass_ratio", "drag",
            "start", "direction", "attach"}


def refuse(scene, what):
    sys.exit(f"tools/peers/motion: {scene}: found {what}, expected bodies at rest without drag and contacts, "
             "held by hinges and ball joints, on springs and under constant torques")


def placed(part, instance):
    """A body or joint of a prefab as it is in an instance."""
    place = instance.get("position", [0, 0, 0])
    moved = {key: [a + b for a, b in zip(part[key], place)]
             for key in ("position", "anchor", "point_a", "point_b") if key in part}
    named = {key: f"{instance['name']}/{part[key]}" for key in ("name", "a", "b")
             if part.get(key, "world") != "world"}
    return {**part, **moved, **named}


def add_instances(text, path):
    """Writes out what a scene has as instances of prefabs."""
    prefabs = {p["name"]: p for p in text.get("prefabs", [])}
    for instance in text.get("instances", []):
        prefab = prefabs[instance["prefab"]]
        if unknown := set(instance) - OF_INSTANCE or set(prefab) - OF_PREFAB:
            refuse(path, f'"{min(unknown)}" of {instance["name"]}')
        for key in ("bodies", "joints"):
            text[key] = text.get(key, []) + [placed(part, instance) for part in prefab.get(key, [])]


class Parts:
    """Bodies, joints and what is led of a scene file."""

    def __init__(self, path):
        text = json.loads(pathlib.Path(path).read_text())
        add_instances(text, path)
        self.gravity, self.duration = text.get("gravity", [0, -9.81, 0]), text.get("duration", 2)
        self.rate = RATE if self.duration >= SHORT else round(FRAMES / self.duration)
        self.bodies, self.joints, self.springs, self.sway, self.path = {}, [], [], None, path
        for key in ("cables", "pins", "gears", "belts", "surface_joints", "drives",
                    "defaults", "classes", "collision"):
            if text.get(key):
                refuse(path, f'"{key}"')
        led = {p["body"]: p for p in text.get("paths", [])}
        for body in text.get("bodies", []):
            name, motion = body["name"], body.get("motion", "dynamic")
            if motion == "kinematic" and name in led:
                self.lead(name, led[name], body.get("position", [0, 0, 0]))
            elif motion == "dynamic":
                self.check(body, OF_BODY, name)
                self.bodies[name] = "dynamic", body["mass"], body["inertia"]
        for joint in text.get("joints", []):
            kind, name = joint.get("kind", "ball"), joint.get("name", "a joint")
            if kind not in ("ball", "hinge", "spring"):
                refuse(path, f"a joint of kind {kind}")
            self.check(joint, OF_SPRING if kind == "spring" else OF_JOINT, name)
            (self.springs if kind == "spring" else self.joints).append(joint)
        for event in text.get("events", []):
            if event["type"] != "push":
                refuse(path, f"an event of type {event['type']}")
            self.check(event, OF_PUSH, f"the push of {event['body']}")
        if self.springs and self.sway:
            refuse(path, "springs beside a body on a path")
        self.torques = [(event["body"], event["torque"]) for event in text.get("events", [])]
        for chain in text.get("generators", {}).get("chains", []):
            self.check(chain, OF_CHAIN, chain["name"])
            self.add_chain(chain)

    def check(self, part, known, name):
        for key in part:
            if key not in known:
                refuse(self.path, f'"{key}" of {name}')
        if "drag" in known and part.get("drag") != 0:
            refuse(self.path, f"drag of {name}")

    def lead(self, name, path, place):
        if set(path) != {"body", "lissajous"} or self.sway or \
                set(path["lissajous"]) - {"amplitude", "frequency", "phase_deg"}:
            refuse(self.path, f"the path of {name}")
        curve = path["lissajous"]
        phase = [math.radians(x) for x in curve.get("phase_deg", [0, 0, 0])]
        centre = [p - a * math.sin(f) for p, a, f in zip(place, curve["amplitude"], phase)]
        self.bodies[name] = "kinematic", 1, [1, 1, 1]
        self.sway = name, centre, curve["amplitude"], curve["frequency"], phase

    def add_chain(self, chain):
        size = math.hypot(*chain["direction"])
        before = chain["attach"]
        for i in range(chain["links"]):
            name = f"{chain['name']}/{i}"
            factor = chain.get("mass_ratio", 1) ** i
            self.bodies[name] = "dynamic", chain["mass"] * factor, [x * factor for x in chain["inertia"]]
            anchor = [s + d / size * i * chain["length"]
                      for s, d in zip(chain["start"], chain["direction"])]
            self.joints.append({"name": name, "kind": "ball", "a": before, "b": name, "anchor": anchor})
            before = name

    def spelt(self, start, frames, parts):
        """The words of tools/peers/bodies/plain.hpp, and those that spelt.hpp adds."""
        names = list(self.bodies)
        at = {name: i for i, name in enumerate(names)}
        origin = [0, 0, 0, 0, 0, 0, 1]
        lines = [f"gravity {text_of(self.gravity)}", f"frames {frames}", f"rate {self.rate}",
                 f"parts {parts}", "layers 0"]

        def local(body, point):
            pose = start.get(body, origin)
            return rotated(pose[3:], [x - o for x, o in zip(point, pose)], -1)
        for name, (motion, mass, inertia) in self.bodies.items():
            lines.append(f"body {name} {motion} -1 {text_of([mass, *inertia, *start[name], *[0] * 6])} "
                         "0 1 0 0")
        for joint in self.joints:
            poses = [start.get(joint[end], origin) for end in "ab"]
            places = [*local(joint["a"], joint["anchor"]), *local(joint["b"], joint["anchor"])]
            axes = turn_of_x(joint.get("axis", [1, 0, 0]))
            turns = [product([-x for x in p[3:6]] + [p[6]], axes) for p in poses]
            lines.append(f"joint {joint.get('kind', 'ball')} {at.get(joint['a'], -1)} "
                         f"{at.get(joint['b'], -1)} {text_of([*places, *turns[0], *turns[1]])}"
                         " 0 0 0 0 0 0 0 0 0")
        for s in self.springs:
            ends = [*local(s["a"], s["point_a"]), *local(s["b"], s["point_b"])]
            lines.append(f"spring {at.get(s['a'], -1)} {at.get(s['b'], -1)} "
                         f"{text_of([*ends, s['length'], s['stiffness']])}")
        lines += [f"torque {at[body]} {text_of(torque)}" for body, torque in self.torques]
        if self.sway:
            name, centre, amplitude, frequency, phase = self.sway
            poses = []
            for i in range(1, frames * parts + 1):
                t = i / (self.rate * parts)
                poses += [c + a * math.sin(2 * math.pi * f * t + p)
                          for c, a, f, p in zip(centre, amplitude, frequency, phase)] + start[name][3:]
            lines.append(f"path {at[name]} {text_of(poses)}")
            lines.append(f"sway {at[name]} {text_of([*centre, *amplitude, *frequency, *phase])}")
        return "\n".join(lines) + "\n"


def text_of(numbers):
    return " ".join(repr(float(x)) for x in numbers)


def turn_of_x(axis):
    """A rotation that turns x to an axis."""
    size = math.hypot(*axis)
    x, y, z = (c / size for c in axis)
    q = [0, -z, y, 1 + x] if x > -1 + 1e-9 else [0, 0, 1, 0]
    size = math.hypot(*q)
    return [c / size for c in q]
