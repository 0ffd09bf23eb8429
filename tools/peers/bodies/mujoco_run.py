"""A scene in MuJoCo, as its manual advises: trees of joints, its own default solver, integrator and
contacts, on one thread, steps near its default of 2 ms.

usage: mujoco_run.py SPELT OUT STEPS     steps of a frame; 0: eight of 1/480 s

What it has no equal for is told in the file under `without`.
"""
import array
import math
import sys
import time
import xml.etree.ElementTree as xml

import mujoco
import numpy

FRAME = 1 / 60


def turned(q, v):
    """The vector v turned by the rotation q = (w, x, y, z)."""
    w, u = q[0], numpy.array(q[1:])
    return v + 2 * numpy.cross(u, numpy.cross(u, v) + w * v)


def times(p, q):
    (a, b, c, d), (e, f, g, h) = p, q
    return numpy.array([a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g,
                        a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e])


def inverse(q):
    return numpy.array([q[0], -q[1], -q[2], -q[3]])


class Words:
    """The numbers of a line, one after the other."""

    def __init__(self, words):
        self.words, self.at = words, 0

    def text(self):
        self.at += 1
        return self.words[self.at - 1]

    def some(self, count):
        self.at += count
        return numpy.array([float(w) for w in self.words[self.at - count:self.at]])

    def one(self):
        return float(self.text())

    def rotation(self):
        x, y, z, w = self.some(4)
        return numpy.array([w, x, y, z])

    def pose(self):
        return self.some(3), self.rotation()

    def rest(self):
        return len(self.words) - self.at


class Thing:
    pass


class Scene:
    """What write_plain() of plain.hpp writes."""

    def __init__(self, path):
        self.bodies, self.joints, self.cables, self.without = [], [], [], []
        with open(path) as lines:
            rows = iter(lines.read().splitlines())
        for row in rows:
            words = Words(row.split())
            kind = words.text()
            if kind == "layers":
                self.touch = [[int(w) for w in next(rows).split()] for _ in range(int(words.one()))]
            elif kind == "unknown":
                self.without.append(row[8:])
            else:
                getattr(self, "read_" + kind)(words)

    def read_gravity(self, words):
        self.gravity = words.some(3)

    def read_frames(self, words):
        self.frames = int(words.one())

    def read_body(self, words):
        b = Thing()
        b.name, b.motion, b.layer = words.text(), words.text(), int(words.one())
        b.mass, b.inertia, b.at = words.one(), words.some(3), words.pose()
        b.velocity, b.spin = words.some(3), words.some(3)
        b.drag, b.weight, b.friction, b.restitution = words.some(4)
        b.shapes, b.path = [], []
        self.bodies.append(b)

    def read_shape(self, words):
        s = Thing()
        s.kind, s.size, s.at = words.text(), words.some(3), words.pose()
        s.points = words.some(words.rest())
        self.bodies[-1].shapes.append(s)

    def read_joint(self, words):
        j = Thing()
        j.kind, j.a, j.b = words.text(), int(words.one()), int(words.one())
        j.anchors, j.axes = [words.some(3), words.some(3)], [words.rotation(), words.rotation()]
        j.first, j.second, j.swing = words.some(3), words.some(3), words.some(3)
        j.drive = None
        self.joints.append(j)

    def read_drive(self, words):
        drive, joint = Thing(), int(words.one())
        drive.stiffness, drive.damping, drive.most = words.some(3)
        drive.targets = [words.rotation() for _ in range(int(words.one()))]
        self.joints[joint].drive = drive

    def read_cable(self, words):
        c = Thing()
        c.ends, c.anchors = [int(words.one()), int(words.one())], [words.some(3), words.some(3)]
        c.length, c.compliance = words.one(), words.one()
        self.cables.append(c)

    def read_path(self, words):
        body = self.bodies[int(words.one())]
        while words.rest():
            body.path.append(words.pose())


def numbers(values):
    return " ".join(repr(float(v)) for v in values)


class Model:
    """The scene as MuJoCo's XML, and how its coordinates start."""

    def __init__(self, scene):
        self.scene = scene
        self.root = xml.Element("mujoco")
        xml.SubElement(self.root, "compiler", angle="radian", inertiafromgeom="false")
        xml.SubElement(self.root, "size", memory="1G")
        self.option = xml.SubElement(self.root, "option", gravity=numbers(scene.gravity),
                                      integrator="implicitfast")  # the manual's advice
        self.assets = xml.SubElement(self.root, "asset")
        self.world = xml.SubElement(self.root, "worldbody")
        self.contact = xml.SubElement(self.root, "contact")
        self.equality = xml.SubElement(self.root, "equality")
        self.tendon = xml.SubElement(self.root, "tendon")
        self.actuator = xml.SubElement(self.root, "actuator")
        self.starts = {}   # by name of a joint: its coordinates at the start
        self.free = []     # bodies with a joint of their own to the world
        self.drives = []   # actuator, joint of the scene
        self.without = list(scene.without)
        self.elements = {-1: self.world}
        if len(scene.touch) > 32:
            sys.exit("mujoco_run.py: more than the 32 layers that MuJoCo has bits for")
        self.grow()
        self.close_loops()

    def lack(self, what):
        if what not in self.without:
            self.without.append(what)

    # ---- Trees ------------------------------------------------------------------------------

    def grow(self):
        bodies, joints = self.scene.bodies, self.scene.joints
        of = [[] for _ in bodies]  # joints of each body
        on_world = []
        for j in joints:
            for end in (j.a, j.b):
                (of[end] if end >= 0 else on_world).append(j)
        self.used = set()
        queue = []

        def reach(j, parent):
            child = j.b if j.a == parent else j.a
            if child >= 0 and child not in self.elements and bodies[child].motion == "dynamic":
                self.used.add(id(j))
                self.hang(j, parent, child)
                queue.append(child)

        for j in on_world:
            reach(j, -1)
        for i, b in enumerate(bodies):
            if b.motion != "dynamic":
                self.add_body(i, self.world, b.at, "true" if b.motion == "kinematic" else None)
                for j in of[i]:
                    reach(j, i)
        # The middle of what is jointed makes the shallowest tree; the first body is near enough.
        for i, b in enumerate(bodies):
            while queue:
                at = queue.pop(0)
                for j in of[at]:
                    reach(j, at)
            if i not in self.elements:
                element = self.add_body(i, self.world, b.at)
                xml.SubElement(element, "freejoint", name=f"j{i}")
                self.free.append(i)
                queue.append(i)
        while queue:
            at = queue.pop(0)
            for j in of[at]:
                reach(j, at)

    def pose(self, body):
        return self.scene.bodies[body].at if body >= 0 else (numpy.zeros(3), [1, 0, 0, 0])

    def hang(self, j, parent, child):
        """`child` on `parent`, drawn with their joint axes in line; the start is told apart."""
        p, c = (0, 1) if j.a == parent else (1, 0)
        if p == 1 and j.kind not in ("ball", "fixed"):
            # The rotation of a in b's axes: angles of a hinge change their sign. Of a universal the
            # order of the axes would; none is hung so.
            if j.kind == "universal":
                self.lack("limits of a universal joint that is hung by its second body")
        relative = times(j.axes[p], inverse(j.axes[c]))
        place = j.anchors[p] - turned(relative, j.anchors[c])
        element = self.add_body(child, self.elements[parent], (place, relative))
        (_, a), (_, b) = self.pose(parent), self.pose(child)
        start = times(inverse(times(a, j.axes[p])), times(b, j.axes[c]))
        self.add_joint(element, j, c, start, f"j{child}")

    def add_joint(self, element, j, c, start, name):
        sign = 1 if c == 1 else -1
        if j.kind == "fixed":
            return
        if j.kind == "ball":
            # Three hinges could have the limits themselves, but lock near a right angle.
            limits = {}
            if j.first[0] or j.swing[0]:
                widest = max([*j.swing[1:]] if j.swing[0] else numpy.abs(j.first[1:]))
                limits = {"range": numbers((0, widest)), "limited": "true"}
                self.lack("limits of ball joints but a cone around all of their turn")
            xml.SubElement(element, "joint", type="ball", name=name, pos=numbers(j.anchors[c]),
                           **limits)
            self.starts[name] = times(times(j.axes[c], start), inverse(j.axes[c]))
            if j.drive:
                self.lack("drives of ball joints")
            return
        # Angles about y, then z.
        w, x, y, z = start
        out_x = numpy.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
        about_z = math.asin(min(1, max(-1, out_x[1])))
        about_y = math.atan2(-out_x[2], out_x[0])
        if j.kind == "hinge":
            rows = [("x", (1, 0, 0), 2 * math.atan2(x, w), j.first)]
        else:
            rows = [("y", (0, 1, 0), about_y, j.first), ("z", (0, 0, 1), about_z, j.second)]
        for word, axis, angle, (on, low, high) in rows:
            angle = math.remainder(angle, 2 * math.pi)
            limits = {}
            if on:
                low, high = (low, high) if sign > 0 else (-high, -low)
                limits = {"range": numbers((low, high)), "limited": "true"}
            xml.SubElement(element, "joint", type="hinge", name=name + word,
                           pos=numbers(j.anchors[c]),
                           axis=numbers(turned(j.axes[c], numpy.array(axis, float))), **limits)
            self.starts[name + word] = [angle]
        if j.drive and j.kind == "hinge":
            xml.SubElement(self.actuator, "position", joint=name + "x",
                           kp=numbers([j.drive.stiffness]), kv=numbers([j.drive.damping]),
                           forcelimited="true",
                           forcerange=numbers((-j.drive.most, j.drive.most)))
            self.drives.append((sign, j.drive))
        elif j.drive:
            self.lack("drives of joints that are no hinges")

    # ---- Bodies -----------------------------------------------------------------------------

    def add_body(self, number, parent, pose, mocap=None):
        b = self.scene.bodies[number]
        position, rotation = pose
        more = {"mocap": mocap} if mocap else {}
        element = xml.SubElement(parent, "body", name=f"b{number}", pos=numbers(position),
                                 quat=numbers(rotation), gravcomp=repr(float(1 - b.weight)), **more)
        xml.SubElement(element, "inertial", pos="0 0 0", mass=repr(b.mass),
                       diaginertia=numbers(b.inertia))
        for i, s in enumerate(b.shapes):
            self.add_shape(element, b, s, f"s{number}_{i}")
        self.elements[number] = element
        return element

    def add_shape(self, element, b, s, name):
        if b.layer < 0:
            return
        if b.restitution > 0:
            self.lack("restitution")
        position, rotation = s.at
        touch = self.scene.touch[b.layer]
        how = {"name": name, "contype": str(signed(1 << b.layer)),
               "conaffinity": str(signed(sum(1 << i for i, on in enumerate(touch) if on))),
               "friction": numbers((b.friction, 0.005, 0.0001))}
        quarter = [math.sqrt(0.5), -math.sqrt(0.5), 0, 0]  # z of MuJoCo's shapes is our y
        if s.kind in ("plane", "capsule", "cylinder"):
            rotation = times(rotation, quarter)
        if s.kind == "plane":
            size = (0, 0, 1)
        elif s.kind == "hull":
            xml.SubElement(self.assets, "mesh", name=name, vertex=numbers(s.points))
            how["mesh"] = name
        size = {"sphere": s.size[:1], "capsule": s.size[:2], "cylinder": s.size[:2],
                "box": s.size, "plane": (0, 0, 1), "hull": ()}[s.kind]
        if len(size):
            how["size"] = numbers(size)
        xml.SubElement(element, "geom", type="mesh" if s.kind == "hull" else s.kind,
                       pos=numbers(position), quat=numbers(rotation), **how)

    # ---- What is no tree --------------------------------------------------------------------

    def site(self, body, place, name):
        xml.SubElement(self.elements[body], "site", name=name, pos=numbers(place))
        return name

    def close_loops(self):
        for number, j in enumerate(self.scene.joints):
            if j.a >= 0 and j.b >= 0:
                xml.SubElement(self.contact, "exclude", body1=f"b{j.a}", body2=f"b{j.b}")
            if id(j) in self.used:
                continue
            ends = [self.site(body, place, f"l{number}{side}")
                    for body, place, side in zip((j.a, j.b), j.anchors, "ab")]
            xml.SubElement(self.equality, "connect", site1=ends[0], site2=ends[1])
            if j.drive:
                self.lack("drives of joints that close loops")
        for number, c in enumerate(self.scene.cables):
            line = xml.SubElement(self.tendon, "spatial", limited="true",
                                  range=numbers((0, c.length)))
            for body, place, side in zip(c.ends, c.anchors, "ab"):
                xml.SubElement(line, "site", site=self.site(body, place, f"c{number}{side}"))
            if c.compliance:
                self.lack("compliance of cables")


def signed(bits):
    return bits - (1 << 32) if bits >= 1 << 31 else bits


class Run:
    def __init__(self, scene, steps):
        self.scene, self.steps, made = scene, steps, Model(scene)
        self.without, self.drives = made.without, made.drives
        made.option.set("timestep", repr(FRAME / steps))
        self.model = m = mujoco.MjModel.from_xml_string(xml.tostring(made.root, encoding="unicode"))
        self.data = mujoco.MjData(m)
        for name, values in made.starts.items():
            at = m.joint(name).qposadr[0]
            self.data.qpos[at:at + len(values)] = values
        jointed = {end for j in scene.joints for end in (j.a, j.b)}
        for i in made.free:
            b, at = scene.bodies[i], m.joint(f"j{i}").dofadr[0]
            self.data.qvel[at:at + 3] = b.velocity
            self.data.qvel[at + 3:at + 6] = turned(inverse(b.at[1]), b.spin)
            if i not in jointed:
                m.dof_damping[at:at + 3] = b.drag * b.mass
                m.dof_damping[at + 3:at + 6] = b.drag * b.inertia
        if any(b.drag for i, b in enumerate(scene.bodies) if i in jointed):
            self.without.append("drag of jointed bodies")
        self.ids = numpy.array([m.body(f"b{i}").id for i in range(len(scene.bodies))])
        self.moving = [(i, m.body(f"b{i}").mocapid[0])
                       for i, b in enumerate(scene.bodies) if b.path]

    def step(self, frame):
        for i, mocap in self.moving:
            at = self.scene.bodies[i].path[frame]
            self.data.mocap_pos[mocap], self.data.mocap_quat[mocap] = at
        for i, (sign, drive) in enumerate(self.drives):
            q = drive.targets[min(frame, len(drive.targets) - 1)]
            now = self.data.actuator_length[i]  # the shortest way from there
            self.data.ctrl[i] = now + math.remainder(sign * 2 * math.atan2(q[1], q[0]) - now,
                                                     2 * math.pi)
        mujoco.mj_step(self.model, self.data, nstep=self.steps)

    def read(self):
        """Of each body: place, rotation, velocity, spin. A step leaves places that lag behind."""
        m, d = self.model, self.data
        mujoco.mj_kinematics(m, d)
        mujoco.mj_comPos(m, d)
        mujoco.mj_comVel(m, d)
        at = d.xpos[self.ids]
        arm = at - d.subtree_com[m.body_rootid[self.ids]]
        spin = d.cvel[self.ids, :3]
        q = d.xquat[self.ids]
        velocity = d.cvel[self.ids, 3:] + numpy.cross(spin, arm)
        return numpy.hstack([at, q[:, 1:], q[:, :1], velocity, spin])

    def has_failed(self):
        """Whether it gave up and started anew, as it does where numbers grow without bound."""
        warning = self.data.warning
        return any(warning[w].number for w in (mujoco.mjtWarning.mjWARN_BADQPOS,
                                               mujoco.mjtWarning.mjWARN_BADQVEL,
                                               mujoco.mjtWarning.mjWARN_BADQACC))

    def awake(self):
        return self.data.ntree_awake  # sleep is not among its defaults


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    scene = Scene(sys.argv[1])
    steps = int(sys.argv[3]) or 8
    run = Run(scene, steps)
    told = {"engine": "mujoco", "version": mujoco.__version__, "built": "wheel",
            "settings": f"defaults (Newton, pyramids), implicitfast, {steps} steps of "
                        f"{1000 * FRAME / steps:.2f} ms a frame, 1 thread"}
    with open(sys.argv[2], "wb") as out:
        for key, value in [*told.items(), *(("without", w) for w in run.without)]:
            out.write(f"{key} {value}\n".encode())
        out.write(f"frames {len(scene.bodies)}\n".encode())
        for frame in range(scene.frames):
            before = time.process_time_ns()
            run.step(frame)
            ms = (time.process_time_ns() - before) * 1e-6
            if run.has_failed():
                break
            out.write(array.array("d", [ms, run.awake()]).tobytes())
            out.write(run.read().astype("<f8").tobytes())


if __name__ == "__main__":
    main()
