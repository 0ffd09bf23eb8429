// What a file says of kinds, axes, limits, muscles and pins is what the World holds.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

Real distance(Vec3 a, Vec3 b) { return glm::length(a - b); }
Real apart(Quat a, Quat b) { return glm::length(rotation_vector(a * glm::conjugate(b))); }

const Link& link_of(const Scene& s, const char* name) { return s.world.links[s.world.find(name)]; }

/// How the joint axes of b stand in those of a at the start.
Quat start_of(const Scene& s, const Link& l) {
  return relative_rotation(l.joint, s.world.bodies[l.a].pose.rotation,
                           s.world.bodies[l.b].pose.rotation);
}

/// The joint axes of a in the world.
Quat axes_of(const Scene& s, const Link& l) {
  return s.world.bodies[l.a].pose.rotation * l.joint.frames.a();
}

/// Two hammers, each with its mass centre and principal axes away from its own frame, the first one
/// turned 90 degrees about z, the second about y, and a joint "j" of these members.
Scene hammers(const std::string& joint) {
  return good(R"({"version": 1, "gravity": [0, 0, 0], "bodies": [
{"name": "a", "rotation_deg": [0, 0, 90], "shapes": [{"type": "sphere", "radius": 0.1},
 {"type": "capsule", "radius": 0.05, "length": 0.5, "position": [0.3, 0.2, 0.1], "rotation_deg": [20, 0, 50]}]},
{"name": "b", "rotation_deg": [0, 90, 0], "position": [1, 0, 0], "shapes": [{"type": "sphere", "radius": 0.1},
 {"type": "capsule", "radius": 0.05, "length": 0.5, "position": [0.1, 0.2, 0.3], "rotation_deg": [50, 0, 20]}]}],
"joints": [{"name": "j", "a": "a", "b": "b", "anchor": [0.5, 0, 0], )" +
              joint + "}]}");
}

}  // namespace

TEST_CASE("A plain ball joint keeps its axes at rest in the bodies, whatever they are") {
  const Scene s = hammers(R"("axis": [0, 1, 0])");
  const Joint& j = link_of(s, "j").joint;
  CHECK(j.kind == JointKind::ball);
  CHECK((j.frames.a() == kIdentity && j.frames.b() == kIdentity && !j.limits.any()));
  CHECK(hammers(R"("type": "ball")").world.links.values()[0].joint.kind == JointKind::ball);
}

TEST_CASE("Joint axes are given in the scene at the start, where Q is 1") {
  const Scene s = hammers(R"("kind": "hinge", "axis": [0, 2, 0])");
  const Link& l = link_of(s, "j");
  CHECK(l.joint.kind == JointKind::hinge);
  CHECK(distance(axes_of(s, l) * Vec3(1, 0, 0), {0, 1, 0}) < 1e-12);
  CHECK(apart(start_of(s, l), kIdentity) < 1e-12);
  CHECK(s.warnings.empty());
  // Without an axis they are those of the scene.
  const Scene plain = hammers(R"("kind": "universal")");
  CHECK(apart(axes_of(plain, link_of(plain, "j")), kIdentity) < 1e-12);
  const Scene back = hammers(R"("kind": "hinge", "axis": [-1, 0, 0])");
  CHECK(distance(axes_of(back, link_of(back, "j")) * Vec3(1, 0, 0), {-1, 0, 0}) < 1e-12);
}

TEST_CASE("The direction across is the y axis, made square to the axis") {
  const Scene s = hammers(R"("kind": "universal", "axis": [0, 0, 3], "across": [1, 0, 5])");
  const Quat axes = axes_of(s, link_of(s, "j"));
  CHECK(distance(axes * Vec3(1, 0, 0), {0, 0, 1}) < 1e-12);
  CHECK(distance(axes * Vec3(0, 1, 0), {1, 0, 0}) < 1e-12);
}

TEST_CASE("Joint axes may be given in a body's own frame, the other's follow") {
  const Scene a = hammers(R"("kind": "hinge", "axis_a": [1, 0, 0], "across_a": [0, 0, 1])");
  CHECK(distance(axes_of(a, link_of(a, "j")) * Vec3(1, 0, 0), {0, 1, 0}) < 1e-12);
  CHECK(distance(axes_of(a, link_of(a, "j")) * Vec3(0, 1, 0), {0, 0, 1}) < 1e-12);
  CHECK(apart(start_of(a, link_of(a, "j")), kIdentity) < 1e-12);
  const Scene b = hammers(R"("kind": "hinge", "axis_b": [1, 0, 0], "rest_deg": 30)");
  const Quat rest = start_of(b, link_of(b, "j"));
  CHECK(distance(axes_of(b, link_of(b, "j")) * (rest * Vec3(1, 0, 0)), {0, 0, -1}) < 1e-12);
  CHECK(distance(rotation_vector(rest), {kPi / 6, 0, 0}) < 1e-12);
}

TEST_CASE("Joint axes in both bodies tell the turn between them") {
  const Scene s = hammers(R"("kind": "hinge", "axis_a": [0, 0, 1], "across_a": [0, -1, 0],
"axis_b": [-1, 0, 0], "across_b": [0, 1, 0])");
  // In the scene: x is z for both; y is x for a and y for b.
  CHECK(distance(rotation_vector(start_of(s, link_of(s, "j"))), {kPi / 2, 0, 0}) < 1e-12);
  CHECK(s.warnings.empty());
}

TEST_CASE("The turn at the start may be told: an angle, two, three or a quaternion") {
  const auto rest = [](const std::string& members) {
    const Scene s = hammers(members);
    CHECK(s.warnings.empty());
    return start_of(s, link_of(s, "j"));
  };
  CHECK(apart(rest(R"("kind": "hinge", "axis": [0, 1, 0], "rest": 0.5)"),
              from_rotation_vector({0.5, 0, 0})) < 1e-12);
  CHECK(apart(rest(R"("kind": "universal", "rest_deg": [30, -20])"),
              rotation_of(UniversalAngles{kPi / 6, -kPi / 9})) < 1e-12);
  CHECK(apart(rest(R"("limits": {"cone": 1}, "rest_deg": [0, 0, 40])"),
              from_rotation_vector({0, 0, kPi * 2 / 9})) < 1e-12);
  CHECK(apart(rest(R"("kind": "hinge", "rest": [0.6, 0, 0, 0.8])"), Quat(0.8, 0.6, 0, 0)) < 1e-12);
}

TEST_CASE("Limits are read in radians or degrees, for each kind its own") {
  const auto limits = [](const std::string& members) {
    return hammers(members).world.links.values()[0].joint.limits;
  };
  const JointLimits hinge = limits(R"("kind": "hinge", "limits": {"angle_deg": [-90, 45],
"soft": {"zone_deg": 9, "stiffness": 5, "damping": 0.25}})");
  CHECK((hinge.angle.on && !hinge.second.on && !hinge.swing.on));
  CHECK((hinge.angle.low == Approx(-kPi / 2) && hinge.angle.high == Approx(kPi / 4)));
  CHECK(hinge.soft_zone == Approx(kPi / 20));
  CHECK((hinge.soft_stiffness == 5 && hinge.soft_damping == 0.25));
  const JointLimits round = limits(R"("limits": {"twist": [-0.5, 0.25], "cone_deg": 180})");
  CHECK((round.angle.low == -0.5 && round.angle.high == 0.25));
  CHECK((round.swing.on && round.swing.y == kPi && round.swing.z == kPi));
  const JointLimits oval = limits(R"("limits": {"swing": [0.5, 0]})");
  CHECK((!oval.angle.on && oval.swing.on && oval.swing.y == 0.5 && oval.swing.z == 0));
  const JointLimits shaft =
      limits(R"("kind": "universal", "limits": {"first": [-1, 1], "second_deg": [0, 0]})");
  CHECK((shaft.angle.low == -1 && shaft.angle.high == 1 && shaft.second.on &&
         shaft.second.high == 0));
}

TEST_CASE("A drive of a joint is a muscle on its link") {
  const Scene s = hammers(R"("kind": "hinge", "drive": {"angle_deg": 90, "stiffness": 50,
"damping": 2, "max_torque": 10})");
  const JointDrive& d = s.world.joint_drives[s.world.find("j")];
  CHECK(apart(d.target, from_rotation_vector({kPi / 2, 0, 0})) < 1e-15);
  CHECK((d.stiffness == 50 && d.damping == 2 && d.max_torque == 10 && d.keys.empty()));
  const Scene free = hammers(R"("drive": {"target_deg": [0, 90, 0], "damping": 1})");
  const JointDrive& e = free.world.joint_drives[free.world.find("j")];
  CHECK(apart(e.target, from_rotation_vector({0, kPi / 2, 0})) < 1e-15);
  CHECK((e.stiffness == 0 && e.max_torque == JointDrive{}.max_torque));
}

TEST_CASE("A drive follows keys, and those of an instance run ahead by its time offset") {
  const std::string keys = R"("kind": "hinge", "drive": {"stiffness": 1, "loop": true,
"keys": [{"time": 0, "angle": 0}, {"time": 1, "target": 1}, {"time": 3, "angle_deg": 0}]})";
  const Scene s = hammers(keys);
  const JointDrive& d = s.world.joint_drives[s.world.find("j")];
  REQUIRE((d.keys.size() == 3 && d.loop));
  CHECK(apart(target_at(d, 0.5), from_rotation_vector({0.5, 0, 0})) < 1e-12);
  CHECK(apart(target_at(d, 3.5), from_rotation_vector({0.5, 0, 0})) < 1e-12);
  const Scene copies = good(R"({"version": 1, "prefabs": [{"name": "p", "bodies": [
{"name": "a", "shape": {"type": "sphere", "radius": 0.1}}],
"joints": [{"name": "j", "a": "world", "b": "a", "anchor": [0, 0, 0], "axis": [0, 0, 1], )" +
                            keys + R"(}]}],
"instances": [{"name": "i", "prefab": "p", "rotation_deg": [90, 0, 0], "time_offset": 0.5}]})");
  const Link& l = link_of(copies, "i/j");
  CHECK(distance(axes_of(copies, l) * Vec3(1, 0, 0), {0, -1, 0}) < 1e-12);
  CHECK(apart(start_of(copies, l), kIdentity) < 1e-12);
  const JointDrive& ahead = copies.world.joint_drives[copies.world.find("i/j")];
  CHECK(apart(target_at(ahead, 0), from_rotation_vector({0.5, 0, 0})) < 1e-12);
}

TEST_CASE("Joints may close a loop; one that claims more than its point is told by sweeps") {
  const auto second = [](const std::string& solver, const std::string& members) {
    return good(with_two(R"("solver": {"type": ")" + solver + R"("},
"joints": [{"a": "a", "b": "b", "anchor": [0.5, 0, 0], "kind": "hinge"},
{"name": "second", "a": "b", "b": "a", "anchor": [0.5, 1, 0])" +
                         members + "}]"))
        .warnings;
  };
  CHECK(second("sweep", "").empty());
  CHECK(second("sweep", R"(, "kind": "hinge")") ==
        Lines{"t.json:6:1: /joints/1: joint \"second\" closes a loop of dynamic bodies, so this "
              "solver constrains only its point, not its kind, limits or drive"});
  CHECK(second("auto", R"(, "kind": "hinge")").empty());
  const auto far = [](const std::string& solver) {
    return good(with_two(R"("solver": {"type": ")" + solver + R"("},
"joints": [{"a": "a", "b": "b", "anchor": [0.5, 0, 0]},
{"a": "world", "b": "a", "anchor": [0, 0, 0], "kind": "fixed"},
{"name": "far", "a": "b", "b": "world", "anchor": [1, 0, 0], "kind": "fixed"}])"))
        .warnings;
  };
  CHECK(far("sweep") ==
        Lines{"t.json:7:1: /joints/2: joint \"far\" fixes a body that another joint already fixes, "
              "so this solver constrains only its point, not its kind, limits or drive"});
  CHECK(far("auto").empty());
}

TEST_CASE("A joint that starts beyond its limits is told") {
  CHECK(hammers(R"("kind": "hinge", "rest_deg": 20, "limits": {"angle_deg": [30, 60]})").warnings ==
        Lines{"t.json:6:12: /joints/0: joint \"j\" starts 10 degrees beyond what its kind and "
              "limits allow; it will jump into that range"});
}

TEST_CASE("A pin may hold on to another body") {
  const Scene s = good(R"({"version": 1, "bodies": [
{"name": "a", "shape": {"type": "sphere", "radius": 0.1}},
{"name": "b", "shape": {"type": "sphere", "radius": 0.1, "position": [0, 0.5, 0]},
 "position": [1, 0, 0], "rotation_deg": [0, 0, 90]}],
"pins": [{"name": "start", "body": "a", "to": "b"},
{"name": "place", "body": "a", "to": "b", "target": [1, 2, 0], "kind": "spring"},
{"name": "own", "body": "a", "to": "b", "anchor_to": [0, 1, 0], "kind": "spring"}]})");
  const World& w = s.world;
  const Entity b = w.find("b");
  const auto target = [&](const char* name) {
    const Pin& pin = w.pins[w.find(name)];
    CHECK(pin.to == b);
    return to_world(w.bodies[b].pose, pin.target);
  };
  CHECK(distance(target("start"), {0, 0, 0}) < 1e-12);
  CHECK(distance(target("place"), {1, 2, 0}) < 1e-12);
  CHECK(distance(target("own"), {0, 0, 0}) < 1e-12);
  CHECK(w.pins[w.find("own")].target.y == Approx(0.5));  // its mass centre lies halfway
}

TEST_CASE("A pin of an instance goes on holding on to its own copy") {
  const Scene s = good(R"({"version": 1, "prefabs": [{"name": "p", "bodies": [
{"name": "a", "shape": {"type": "sphere", "radius": 0.1}},
{"name": "b", "shape": {"type": "sphere", "radius": 0.1}, "position": [1, 0, 0]}],
"pins": [{"name": "grip", "body": "a", "to": "b"}]}],
"generators": {"grids": [{"name": "g", "prefab": "p", "count": [2, 1, 1], "spacing": [5, 1, 1]}]}})");
  const Pin& pin = s.world.pins[s.world.find("g/1/grip")];
  CHECK(pin.to == s.world.find("g/1/b"));
  CHECK(pin.target == Vec3(-1, 0, 0));
}

TEST_CASE("The number of sweeps of a step and the speed of rest are read") {
  CHECK(good(R"({"version": 1, "solver": {"sweeps": 9}})").world.default_settings.sweeps == 9);
  const auto sleep_speed = [](const char* text) {
    return good(text).world.default_settings.sleep_speed;
  };
  CHECK(sleep_speed(R"({"version": 1})") == SolverSettings{}.sleep_speed);
  CHECK(sleep_speed(R"({"version": 1, "solver": {"sleep_speed": 0}})") == 0);
  CHECK(sleep_speed(R"({"version": 1, "solver": {"sleep_speed": 0.01}})") == 0.01);
}
