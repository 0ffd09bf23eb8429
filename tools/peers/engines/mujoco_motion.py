"""The motion of a scene in MuJoCo, as its manual advises: a tree of hinges and balls, loops closed by
`connect` constraints as stiff as the step allows, no contacts, no damping.

usage: mujoco_motion.py SPELT OUT INTEGRATOR 0     Euler, implicitfast, RK4
"""
import math
import sys
import time

import mujoco

import spelt

LED = 1e12  # kg of a body that is led: it swings on a spring, and what hangs on it does not matter


def text_of(numbers):
    return " ".join(repr(float(x)) for x in numbers)


class Model:
    def __init__(self, scene):
        self.scene, self.loops = scene, []
        self.inside = {-1: []}  # by body: what hangs on it
        if scene.sway:
            self.inside[scene.sway.body] = []
        left = list(scene.joints)
        while left:
            joint = next((j for j in left if j.a in self.inside or j.b in self.inside), None)
            if joint is None:
                sys.exit("mujoco_motion.py: found a body that hangs on nothing")
            left.remove(joint)
            if joint.a in self.inside and joint.b in self.inside:
                self.loops.append(joint)
                continue
            parent, child = (joint.a, joint.b) if joint.a in self.inside else (joint.b, joint.a)
            self.inside[child] = []
            self.inside[parent].append((child, joint))

    def pose(self, body):
        if body < 0:
            return [0, 0, 0], [0, 0, 0, 1]
        return self.scene.bodies[body].position, self.scene.bodies[body].rotation

    def local(self, body, point):
        position, rotation = self.pose(body)
        return spelt.rotated(rotation, [p - x for p, x in zip(point, position)], -1)

    def written(self, number, parent, joint):
        body, (_, before) = self.scene.bodies[number], self.pose(parent)
        q = spelt.product([-x for x in before[:3]] + [before[3]], body.rotation)
        lines = [f'<body name="b{number}" pos="{text_of(self.local(parent, body.position))}" '
                 f'quat="{text_of([q[3], *q[:3]])}">',
                 f'<inertial pos="0 0 0" mass="{body.mass!r}" diaginertia="{text_of(body.inertia)}"/>']
        anchor = f'pos="{text_of(self.local(number, joint.anchor))}"'
        if joint.is_hinge:
            axis = spelt.rotated(body.rotation, joint.axis, -1)
            lines.append(f'<joint type="hinge" {anchor} axis="{text_of(axis)}"/>')
        else:
            lines.append(f'<joint type="ball" {anchor}/>')
        lines.append(self.sites(number))
        lines += [self.written(child, number, by) for child, by in self.inside[number]]
        return "\n".join([*lines, "</body>"])

    def led(self):
        """A body on a path along x: as heavy as it takes, on the spring that makes it swing so."""
        sway = self.scene.sway
        number, rate = sway.body, sway.rate[0]
        if any(sway.amplitude[1:]) or abs(math.cos(sway.phase[0])) > 1e-12:
            sys.exit("mujoco_motion.py: found a path that does not start at rest along x")
        place = self.scene.bodies[number].position
        stiffness, rest = LED * rate * rate, sway.centre[0] - place[0]
        return (f'<body name="b{number}" pos="{text_of(place)}">'
                f'<inertial pos="0 0 0" mass="{LED!r}" diaginertia="1 1 1"/>'
                f'<joint type="slide" axis="1 0 0" stiffness="{stiffness!r}" springref="{rest!r}"/>'
                + "\n".join(self.written(c, number, by) for c, by in self.inside[number]) + "</body>")

    def sites(self, body):
        """The ends of springs on a body."""
        return "".join(f'<site name="{end}{i}" pos="{text_of(anchor)}"/>'
                       for i, s in enumerate(self.scene.springs)
                       for end, at, anchor in (("a", s.a, s.anchor_a), ("b", s.b, s.anchor_b)) if at == body)

    def tendons(self):
        return "".join(f'<spatial stiffness="{s.stiffness!r}" springlength="{s.length!r}">'
                       f'<site site="a{i}"/><site site="b{i}"/></spatial>'
                       for i, s in enumerate(self.scene.springs))

    def text(self, integrator):
        step = 1 / (self.scene.rate * self.scene.parts)
        bodies = self.sites(-1) + "\n".join(self.written(c, -1, by) for c, by in self.inside[-1])
        if self.scene.sway:
            bodies += self.led()
        points = []
        for j in self.loops:
            offsets = (-0.1, 0.1) if j.is_hinge and not self.scene.is_planar else (0,)
            points += [(j, [p + o * x for p, x in zip(j.anchor, j.axis)]) for o in offsets]
        equalities = ""
        for j, point in points:
            first, second = (j.a, j.b) if j.a >= 0 else (j.b, j.a)
            other = f'body2="b{second}"' if second >= 0 else ""
            equalities += (f'<connect body1="b{first}" {other} anchor="{text_of(self.local(first, point))}" '
                           f'solref="{2 * step!r} 1" solimp="0.9999 0.9999 0.001"/>')
        return (f'<mujoco><compiler angle="radian"/><option timestep="{step!r}" '
                f'integrator="{integrator}" gravity="{text_of(self.scene.gravity)}">'
                f'<flag contact="disable"/></option><worldbody>{bodies}</worldbody>'
                f'<equality>{equalities}</equality><tendon>{self.tendons()}</tendon></mujoco>')


def frames_of(scene, model):
    data = mujoco.MjData(model)
    at = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, f"b{i}") for i in range(len(scene.bodies))]
    for body, torque in scene.torques:
        data.xfrc_applied[at[body], 3:] = torque
    for _ in range(scene.frames):
        begin = time.process_time()
        mujoco.mj_step(model, data, scene.parts)
        spent = time.process_time() - begin
        mujoco.mj_kinematics(model, data)
        places = [[float(x) for x in data.xpos[b]] for b in at]
        if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number or \
                not all(math.isfinite(x) for place in places for x in place):
            return
        yield 1e3 * spent, places


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    scene = spelt.Scene(sys.argv[1])
    sys.setrecursionlimit(10 * len(scene.bodies) + 1000)
    model = mujoco.MjModel.from_xml_string(Model(scene).text(sys.argv[3]))
    told = [("version", mujoco.__version__), ("settings", "double, connect as stiff as the step allows")]
    spelt.write_motion(sys.argv[2], told, frames_of(scene, model))


if __name__ == "__main__":
    main()
