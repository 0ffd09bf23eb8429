"""Scenes turned, shifted, mirrored, with other masses, in another order: they have to end alike."""
import copy

from expressions import Vector, after, euler_turn, turned

CHAIN_POINTS, CHAIN_WAYS = ("start", "end", "sag"), ("direction", "velocity", "axis")
POINTS = {"bodies": ("position",), "joints": ("anchor", "point_a", "point_b"), "pins": ("point", "target"),
          "cables": ("point_a", "point_b"), "strings": ("point_a", "point_b"), "events": ("point", "target")}
WAYS = {"bodies": ("velocity",), "events": ("force", "impulse", "gravity")}
TURNS = {"bodies": ("angular_velocity",), "joints": ("axis", "across"),
         "events": ("torque", "angular_impulse")}
KNOWN = {"version", "title", "gravity", "step", "substeps", "duration", "collision", "solver", "bodies", "joints", "cables",
         "strings", "pins", "surface_joints", "surfaces", "generators", "ground", "drift_bound", "defaults", "events",
         "paths", "plane", "curves"}


class NotMeant(ValueError):
    """A scene has something that a transformation does not know."""


class Motion:
    """What becomes of points, directions, axes of turns and attitudes."""

    def point(self, v):
        return v

    def way(self, v):
        return v

    def turn(self, v):
        return self.way(v)

    def attitude(self, q):
        return q

    def own(self, v):
        """A point in a body's own frame."""
        return v


class Rigid(Motion):
    def __init__(self, rotation=(0, 0, 0, 1), shift=(0, 0, 0)):
        self.rotation, self.shift = Vector(rotation), Vector(shift)

    def point(self, v):
        return turned(self.rotation, v) + self.shift

    def way(self, v):
        return turned(self.rotation, v)

    def attitude(self, q):
        return after(self.rotation, q)


class Mirror(Motion):
    """Across the plane z = 0; all that turns is a pseudovector."""

    def point(self, v):
        return Vector((v[0], v[1], -v[2]))

    way = own = point

    def turn(self, v):
        return Vector((-v[0], -v[1], v[2]))

    def attitude(self, q):
        return Vector((-q[0], -q[1], q[2], q[3]))


def _change(item, keys, how):
    for key in keys:
        if key in item:
            item[key] = how(item[key])


def _pose(item, motion):
    """Position and rotation of a body, or of a surface on the world."""
    q = item.pop("rotation", None)
    if "rotation_deg" in item:
        q = euler_turn(item.pop("rotation_deg"))
    item["rotation"] = motion.attitude(q or (0, 0, 0, 1))
    item["position"] = motion.point(item.get("position", (0, 0, 0)))


def _ties(item, motion):
    """Anchors and axes in the frames of two bodies; those of the world are places in it."""
    for side in ("a", "b"):
        world = item.get(side) == "world"
        _change(item, (f"anchor_{side}",), motion.point if world else motion.own)
        if world or isinstance(motion, Mirror):
            _change(item, (f"axis_{side}", f"across_{side}"), motion.turn)


def _chain(chain, motion):
    if isinstance(motion, Mirror) and ("limits" in chain or "drive" in chain):
        raise NotMeant("mirrored chains with limits")
    _change(chain, CHAIN_POINTS, motion.point)
    _change(chain, CHAIN_WAYS, motion.way)
    _change(chain, ("angular_velocity",), motion.turn)
    if "path" in chain:
        chain["path"] = [motion.point(p) for p in chain["path"]]


def _surface_joint(joint, motion):
    for side in ("a", "b"):
        if isinstance(motion, Mirror):
            raise NotMeant("mirrored surfaces")
        if joint[side].get("body") == "world":
            _pose(joint[side], motion)


def _path(path, motion):
    if set(path) - {"body", "keyframes", "loop"}:
        raise NotMeant("paths other than keyframes")
    for key in path["keyframes"]:
        _change(key, ("position",), motion.point)
        if "rotation" in key or "rotation_deg" in key:
            raise NotMeant("keyframes that turn")


def moved(scene, motion):
    """A scene as a motion of space leaves it."""
    scene = copy.deepcopy(scene)
    unknown = set(scene) - KNOWN
    if unknown or set(scene.get("generators", {})) - {"chains"}:
        raise NotMeant(f"{sorted(unknown) or 'generators'}")
    scene["gravity"] = motion.way(scene.get("gravity", (0, -9.81, 0)))
    for body in scene.get("bodies", []):
        if "parent" not in body:
            _pose(body, motion)
        _change(body, ("centre_of_mass",), motion.own)
    for joint in scene.get("joints", []):
        if isinstance(motion, Mirror) and joint.get("kind") in ("prismatic", "screw", "cylindrical", "planar"):
            raise NotMeant("mirrored slides")
    for name, how in ((POINTS, motion.point), (WAYS, motion.way), (TURNS, motion.turn)):
        for room, keys in name.items():
            for item in scene.get(room, []):
                if room != "bodies" or name is not POINTS:
                    _change(item, keys, how)
    for room in ("joints", "cables", "strings"):
        for item in scene.get(room, []):
            _ties(item, motion)
    for pin in scene.get("pins", []):
        _change(pin, ("anchor",), motion.own)
    for joint in scene.get("surface_joints", []):
        _surface_joint(joint, motion)
    for chain in scene.get("generators", {}).get("chains", []):
        _chain(chain, motion)
    for path in scene.get("paths", []):
        _path(path, motion)
    return scene


def shifted(scene, by):
    return moved(scene, Rigid(shift=by))


def heavier(scene, factor=8):
    """Masses, and all forces that do not follow from them, times a factor: a power of 2 rounds nothing."""
    scene = copy.deepcopy(scene)
    times = {"mass", "inertia", "density", "stiffness", "damping", "gain", "cap", "dry", "viscous", "max_torque",
             "force", "torque", "impulse", "angular_impulse", "pretension"}

    def scaled(value):
        return [scaled(v) for v in value] if isinstance(value, (list, tuple)) else value * factor

    def visit(node):
        if isinstance(node, dict):
            for key, value in node.items():
                if key in times and not isinstance(value, (str, dict)):
                    node[key] = scaled(value)
                elif key == "compliance":
                    node[key] = value / factor
                else:
                    visit(value)
        elif isinstance(node, list):
            for item in node:
                visit(item)
    visit(scene)
    for body in scene.get("bodies", []) + scene.get("generators", {}).get("chains", []):
        if body.get("motion", "dynamic") == "dynamic" and "mass" not in body and "density" not in body:
            body["density"] = 1000 * factor
    if scene.get("defaults") or scene.get("classes"):
        raise NotMeant("defaults and classes")
    return scene


def reordered(scene):
    """Bodies, joints, cables and pins in another order."""
    scene = copy.deepcopy(scene)
    for room in ("bodies", "joints", "cables", "strings", "pins", "surface_joints"):
        if room in scene:
            count = len(scene[room])
            scene[room] = [scene[room][i] for i in sorted(range(count), key=lambda i: (i * 7919 + 3) % (count + 1.5))]
    return scene
