// What a file says of joints, ratios and settings for the Lagrangian solver is what the World
// holds.
#include <cmath>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// Two balls 1 m apart and these members, all for the Lagrangian solver.
Scene exact(const std::string& members) {
  return good(with_two("\"solver\": {\"type\": \"lagrangian\"},\n" + members));
}
/// A joint "j" of these members between them.
Scene joined(const std::string& members) {
  return exact("\"joints\": [{\"name\": \"j\", \"a\": \"a\", \"b\": \"b\", " + members + "}]");
}
const Joint& joint_of(const Scene& s) { return s.world.links[s.world.find("j")].joint; }

SolverSettings settings(const std::string& members) {
  return good("{\"version\": 1, \"solver\": {" + members + "}}").world.default_settings;
}

constexpr Real kDegree = kPi / 180;

}  // namespace

TEST_CASE("Every kind of joint that a file can tell is read, by its other name too") {
  const std::string at = R"("anchor": [0, 0, 0], )";
  CHECK(joint_of(joined(at + R"("kind": "spherical")")).kind == JointKind::ball);
  CHECK(joint_of(joined(at + R"("kind": "revolute")")).kind == JointKind::hinge);
  CHECK(joint_of(joined(at + R"("kind": "cylindrical")")).kind == JointKind::cylindrical);
  CHECK(joint_of(joined(at + R"("kind": "prismatic")")).kind == JointKind::prismatic);
  CHECK(joint_of(joined(at + R"("kind": "planar")")).kind == JointKind::planar);
  const Scene screw = joined(at + R"("kind": "screw", "pitch": -0.25, "axis": [0, 3, 0])");
  CHECK(joint_of(screw).kind == JointKind::screw);
  CHECK(joint_of(screw).parameters->pitch == -0.25);
  CHECK(glm::length(joint_of(screw).frames.a() * Vec3(1, 0, 0) - Vec3(0, 1, 0)) < 1e-15);
  CHECK(screw.warnings.empty());
  CHECK_FALSE(joint_of(joined(at + R"("kind": "hinge")")).parameters.any());
}

TEST_CASE("Distances and springs run from point to point, as long as placed or as told") {
  const Scene plain = joined(R"("kind": "distance")");
  CHECK(joint_of(plain).parameters->length == 1);
  CHECK(plain.warnings.empty());
  const Joint tied = joint_of(joined(
      R"("kind": "spring", "point_a": [0, 0.1, 0], "anchor_b": [0, 0.1, 0], "stiffness": 40, "damping": 2)"));
  CHECK((tied.anchor_a == Vec3(0, 0.1, 0) && tied.anchor_b == Vec3(0, 0.1, 0)));
  CHECK(tied.parameters->translation.spring.stiffness == 40);
  CHECK(tied.parameters->translation.spring.damping == 2);
  CHECK(tied.parameters->translation.spring.rest == 1);
  const Joint loose = joint_of(joined(R"("kind": "spring", "stiffness": 1, "length": 0)"));
  CHECK((loose.parameters->length == 0 && loose.parameters->translation.spring.rest == 0));
  CHECK(joined(R"("kind": "distance", "length": 0.75)").warnings ==
        Lines{"t.json:5:12: /joints/0: joint \"j\" starts 0.25 m open; the first step closes it"});
}

TEST_CASE("Springs, friction and motors act on the turn of a hinge and on the slide of a slider") {
  const std::string parameters =
      R"("anchor": [0, 0, 0], "spring": {"stiffness": 3, "damping": 4, "rest_deg": 90},
"friction": {"viscous": 5, "dry": 6, "slip": 0.5}, "motor": {"velocity_deg": 360, "gain": 7, "cap": 8})";
  for (const char* kind : {"hinge", "cylindrical", "universal"}) {
    const Dof turn = joint_of(joined("\"kind\": \"" + std::string(kind) + "\", " + parameters))
                         .parameters->rotation;
    CHECK((turn.spring.stiffness == 3 && turn.spring.damping == 4));
    CHECK(turn.spring.rest == Approx(kPi / 2));
    CHECK((turn.friction.viscous == 5 && turn.friction.dry == 6 && turn.friction.slip == 0.5));
    CHECK((turn.motor.kind == MotorKind::velocity && turn.motor.gain == 7 && turn.motor.cap == 8));
    CHECK(turn.motor.target == Approx(2 * kPi));
  }
  // A rate is no angle, and has bounds of its own.
  const auto fast = joint_of(
      joined(R"("kind": "hinge", "anchor": [0, 0, 0], "motor": {"velocity": -2e5, "gain": 1})"));
  CHECK(fast.parameters->rotation.motor.target == -2e5);
  const JointParameters slider = *joint_of(joined(R"("kind": "prismatic", "anchor": [0, 0, 0],
"motor": {"position": 0.5, "gain": 7, "damping": 1}, "limits": {"travel": [-0.5, 1], "restitution": 0.25})"))
                                      .parameters;
  CHECK_FALSE(slider.rotation.any());
  CHECK((slider.translation.motor.kind == MotorKind::position &&
         slider.translation.motor.target == 0.5));
  CHECK(slider.translation.motor.damping == 1);
  CHECK((slider.travel.on && slider.travel.low == -0.5 && slider.travel.high == 1));
  CHECK(slider.restitution == 0.25);
}

TEST_CASE("A cylindrical joint tells what acts on its angle from what acts on its travel") {
  const JointParameters both = *joint_of(joined(R"("kind": "cylindrical", "anchor": [0, 0, 0],
"angle": {"friction": {"viscous": 1}}, "travel": {"spring": {"stiffness": 2, "rest": 0.5}})"))
                                    .parameters;
  CHECK(both.rotation.friction.viscous == 1);
  CHECK((both.translation.spring.stiffness == 2 && both.translation.spring.rest == 0.5));
}

TEST_CASE("Gears couple joints by name, by the coordinate that each has") {
  const Scene s = exact(R"("joints": [
{"name": "wheel", "kind": "hinge", "a": "world", "b": "a", "anchor": [0, 0, 0], "axis": [0, 0, 1]},
{"name": "rack", "kind": "prismatic", "a": "world", "b": "b", "anchor": [1, 0, 0]}],
"gears": [{"name": "pinion", "first": "wheel", "second": "rack", "ratio": -0.1},
{"first": "rack", "second": "wheel", "ratio": -10, "offset_deg": 90}])");
  const Gear& r = s.world.gears[s.world.find("pinion")];
  CHECK((r.first == s.world.find("wheel") && r.second == s.world.find("rack")));
  CHECK((!r.first_travels && r.second_travels && r.ratio == -0.1 && !r.has_offset));
  const Gear& back = s.world.gears[s.world.find("rack-wheel")];
  CHECK((back.first_travels && !back.second_travels && back.has_offset));
  CHECK(back.offset == Approx(90 * kDegree));
}

TEST_CASE("Gears of a prefab couple the joints of each copy") {
  const Scene s =
      good(R"({"version": 1, "solver": {"type": "lagrangian"}, "prefabs": [{"name": "p", "bodies": [
{"name": "a", "mass": 1, "inertia": [1, 1, 1]}, {"name": "b", "mass": 1, "inertia": [1, 1, 1], "position": [1, 0, 0]}],
"joints": [{"name": "i", "kind": "hinge", "a": "world", "b": "a", "anchor": [0, 0, 0]},
{"name": "j", "kind": "screw", "pitch": 0.1, "a": "world", "b": "b", "anchor": [1, 0, 0]}],
"gears": [{"name": "r", "first": "i", "second": "j", "second_coordinate": "travel", "ratio": 2}]}],
"instances": [{"name": "l", "prefab": "p"}, {"name": "r", "prefab": "p", "position": [0, 0, 5]}],
"gears": [{"first": "l/i", "second": "r/i", "ratio": 1}]})");
  for (const char* copy : {"l", "r"}) {
    const Gear& r = s.world.gears[s.world.find(std::string(copy) + "/r")];
    CHECK(s.world.name_of(r.first) == std::string(copy) + "/i");
    CHECK(s.world.name_of(r.second) == std::string(copy) + "/j");
    CHECK(r.second_travels);
  }
  CHECK(s.world.gears.size() == 3);
}

TEST_CASE("Settings of the Lagrangian solver are read") {
  const SolverSettings s = settings(R"("type": "lagrangian", "integrator": "implicit",
"stabilisation": "baumgarte", "jacobians": "squared_distance", "baumgarte": 8,
"damping_ratio": 0.5)");
  CHECK((s.solver == Solver::lagrangian && s.integrator == Integrator::implicit));
  CHECK(
      (s.stabilisation == Stabilisation::baumgarte && s.baumgarte == 8 && s.damping_ratio == 0.5));
  CHECK(s.jacobians == Jacobians::squared_distance);
  CHECK(settings(R"("step_tolerance": 1e-6)").step_tolerance == 1e-6);
  CHECK(settings("").integrator == Integrator::rk4);
}

TEST_CASE("Choices of whoever runs a scene replace its settings, for every island") {
  const std::string text =
      with_two(R"("solver": {"type": "sweep", "step_tolerance": 1e-3}, "joints": [
{"a": "a", "b": "b", "kind": "prismatic", "anchor": [0, 0, 0]}])");
  CHECK_FALSE(bool(parse_scene(text, "t.json")));
  SolverChoices choices;
  choices.solver = Solver::lagrangian, choices.integrator = Integrator::rattle;
  const Result<Scene> scene = parse_scene(text, "t.json", {}, choices);
  REQUIRE(bool(scene));
  CHECK(scene->world.default_settings.solver == Solver::lagrangian);
  CHECK(scene->world.default_settings.integrator == Integrator::rattle);
  CHECK(scene->world.default_settings.step_tolerance == 0);
}

TEST_CASE("The solver of a body holds for all that joints and gears connect to it") {
  const std::string joints = R"("joints": [
{"name": "i", "kind": "hinge", "a": "world", "b": "a", "anchor": [0, 0, 0]},
{"name": "j", "kind": "prismatic", "a": "world", "b": "b", "anchor": [1, 0, 0]}])";
  const auto scene = [&](const std::string& more) {
    return R"({"version": 1, "gravity": [0, 0, 0], "solver": {"type": "sweep"}, "bodies": [
{"name": "a", "shape": {"type": "sphere", "radius": 0.1}, "solver": {"type": "lagrangian"}},
{"name": "b", "shape": {"type": "sphere", "radius": 0.1}, "position": [1, 0, 0]}],
)" + joints +
           more + "}";
  };
  CHECK(diagnostics(scene("")) ==
        Lines{"t.json:6:23: /joints/1/kind: found a prismatic joint \"j\" solved by \"sweep\", "
              "expected the solver \"lagrangian\", or \"planar\" for motion in the xy plane"});
  CHECK(good(scene(R"(, "gears": [{"first": "i", "second": "j", "ratio": 1}])")).warnings.empty());
}

TEST_CASE("What a solver does not know is told where it is written") {
  const Scene s = good(with_two(R"("solver": {"type": "lagrangian"}, "collision": true)"));
  CHECK(s.warnings.empty());
  const std::string soft =
      R"("kind": "hinge", "axis": [0, 0, 1], "anchor": [0, 0, 0], "limits": {"angle": [0, 1], "soft": {"zone": 0.1}})";
  CHECK(joined(soft).warnings.empty());
  CHECK(good(with_two(R"("solver": {"type": "planar"}, "joints": [{"name": "j", )" + soft +
                      R"(, "a": "world", "b": "a"}])"))
            .warnings == Lines{"t.json:4:42: /joints/0: joint \"j\" has a soft stop, but the "
                               "solver \"planar\" does not support them yet; the stop is hard"});
}

TEST_CASE(
    "Loops of hinges and light bodies beside heavy ones are no worry to the Lagrangian solver, nor "
    "loops to the default") {
  const std::string loop =
      R"("joints": [{"kind": "hinge", "a": "world", "b": "a", "anchor": [0, 0, 0]},
{"kind": "hinge", "a": "a", "b": "b", "anchor": [0.5, 0, 0]},
{"kind": "hinge", "a": "world", "b": "b", "anchor": [1, 0, 0]}])";
  CHECK(exact(loop).warnings.empty());
  CHECK(good(with_two(loop)).warnings.empty());
}
