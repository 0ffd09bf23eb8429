// What the chosen solver does not know is refused when it is added, or told when that changes.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

#include "engine/solvers/solver.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

Entity ball_at(World& world, Vec3 at) {
  return world.add(RigidBody{.shape = SphereShape{.radius = 0.1}, .position = at}).value();
}

constexpr JointMotor kMotor{.kind = MotorKind::velocity, .target = 1, .gain = 1};

struct Pair {
  World world;
  Entity a, b;

  explicit Pair(Solver solver) {
    world.default_settings.solver = solver;
    a = world.add(RigidBody{.motion = Motion::fixed}).value(), b = ball_at(world, {1, 0, 0});
  }
  /// The errors of adding it; the World has to be as before.
  template <class T>
  std::string refused(const T& described) {
    const auto added = world.add(described);
    if (added) return "taken";
    CHECK((world.links.empty() && world.cables.empty() && world.pins.empty()));
    CHECK(world.joint_drives.empty());
    std::string all;
    for (const Error& e : added.errors()) all += (all.empty() ? "" : "\n") + e.message;
    return all;
  }
};

}  // namespace

TEST_CASE("a motor, a spring, friction, restitution under a solver that lacks them are refused") {
  const Solver solver =
      GENERATE(Solver::articulated, Solver::sweep, Solver::shake2, Solver::procedural);
  CAPTURE(name_of(solver));
  Pair pair(solver);
  const Entity a = pair.a, b = pair.b;
  const auto text = [&](const char* type, const char* what, const char* known = "\"lagrangian\"") {
    return std::string(type) + " 'it': solver: found \"" + name_of(solver) +
           "\", which does not support " + what + ", expected " + known;
  };
  const Vec3 z(0, 0, 1);
  const HingeJoint driven{.a = a, .b = b, .axis = z, .motor = kMotor, .name = "it"},
      sprung{.a = a, .b = b, .axis = z, .spring = {.stiffness = 1}, .name = "it"},
      rubbing{.a = a, .b = b, .axis = z, .friction = {.viscous = 1}, .name = "it"};
  if (solver == Solver::articulated) {
    for (const HingeJoint& known : {driven, sprung, rubbing}) CHECK(Pair(solver).world.add(known));
  } else {
    const char* both = "\"auto\" or \"lagrangian\"";
    CHECK(pair.refused(driven) == text("HingeJoint", "a motor", both));
    CHECK(pair.refused(sprung) == text("HingeJoint", "a spring", both));
    CHECK(pair.refused(rubbing) == text("HingeJoint", "friction", both));
  }
  // "auto" leaves what only "lagrangian" knows to that.
  const auto answer = [&](const auto& joint) { return Pair(solver).refused(joint); };
  const auto refusal = [&](const char* type, const char* what) {
    return solver == Solver::articulated ? std::string("taken") : text(type, what);
  };
  CHECK(answer(HingeJoint{.a = a,
                          .b = b,
                          .axis = z,
                          .limits = Interval{-1, 1},
                          .restitution = 0.5,
                          .name = "it"}) == refusal("HingeJoint", "limits with restitution"));
  const char* kind = "a kind of joint whose bodies share no point";
  CHECK(answer(PrismaticJoint{.a = a, .b = b, .axis = z, .name = "it"}) ==
        refusal("PrismaticJoint", kind));
  CHECK(answer(CylindricalJoint{.a = a, .b = b, .axis = z, .name = "it"}) ==
        refusal("CylindricalJoint", kind));
  CHECK(answer(ScrewJoint{.a = a, .b = b, .axis = z, .pitch = 0.1, .name = "it"}) ==
        refusal("ScrewJoint", kind));
  CHECK(answer(PlanarJoint{.a = a, .b = b, .normal = z, .name = "it"}) ==
        refusal("PlanarJoint", kind));
  CHECK(answer(DistanceJoint{.a = a, .b = b, .anchor_b = {1, 0, 0}, .name = "it"}) ==
        refusal("DistanceJoint", kind));
  CHECK(answer(SpringJoint{.a = a, .b = b, .anchor_b = {1, 0, 0}, .stiffness = 1, .name = "it"})
            .find(refusal("SpringJoint", kind)) == 0);
}

TEST_CASE("drives, cables, springs of pins and soft stops under a solver that lacks them") {
  Pair pair(Solver::sweep);
  const Entity a = pair.a, b = pair.b;
  const auto named = [](const std::string& text, const char* what) {
    return text.find("\"sweep\", which does not support") != std::string::npos &&
           text.find(what) != std::string::npos;
  };
  CHECK(named(pair.refused(BallJoint{.a = a, .b = b, .drive = JointDrive{}}),
              "a joint drive, expected \"auto\" or \"lagrangian\""));
  CHECK(named(pair.refused(CableJoint{.a = a, .b = b, .anchor_b = {1, 0, 0}}), "a cable"));
  CHECK(named(pair.refused(PinConstraint{.body = b, .stiffness = 10}), "a spring pin"));
  CHECK(named(pair.refused(HingeJoint{.a = a,
                                      .b = b,
                                      .axis = {0, 0, 1},
                                      .limits = Interval{-1, 1},
                                      .soft_stop = SoftStop{.zone = 0.1, .stiffness = 1}}),
              "a soft stop, expected \"auto\""));
  // What it knows is taken.
  CHECK(pair.refused(PinConstraint{.body = b, .point = {1, 0, 0}}) == "taken");
}

TEST_CASE("the solver that is asked is that of the island that the joint would make") {
  Pair pair(Solver::articulated);
  const Entity c = ball_at(pair.world, {2, 0, 0});
  SolverSettings exact;
  exact.solver = Solver::lagrangian;
  pair.world.settings.add(c, exact);
  const HingeJoint driven{
      .a = pair.b, .b = c, .anchor = {1.5, 0, 0}, .axis = {0, 0, 1}, .motor = kMotor};
  CHECK(pair.refused(driven) == "taken");  // b's island is c's from here on
  CHECK(check(pair.world).empty());
  const HingeJoint held{.a = pair.a, .b = pair.b, .axis = {0, 0, 1}, .motor = kMotor};
  CHECK(pair.world.add(held));
  CHECK(check(pair.world).empty());
}

TEST_CASE("a joint that gives its island another solver: the fault of the other is told") {
  Pair pair(Solver::articulated);
  World& world = pair.world;
  const Entity c = ball_at(world, {2, 0, 0});
  SolverSettings exact, quick;
  exact.solver = Solver::lagrangian, quick.solver = Solver::sweep;
  world.settings.add(c, exact);
  const Entity hinge =
      world
          .add(
              HingeJoint{.a = pair.a, .b = c, .axis = {0, 0, 1}, .motor = kMotor, .name = "driven"})
          .value();
  const Entity slide = ball_at(world, {3, 0, 0});
  const Entity rail =
      world.add(PrismaticJoint{.a = c, .b = slide, .axis = {0, 1, 0}, .name = "rail"}).value();
  CHECK(check(world).empty());
  world.settings.add(pair.b, quick);  // a body before c: its settings count
  world.add(BallJoint{.a = pair.b, .b = c, .anchor = {1.5, 0, 0}}).value();
  const std::vector<StructureFault> faults = check(world);
  bool told_hinge = false, told_rail = false;
  for (const StructureFault& f : faults) {
    told_hinge |= f.link == hinge && f.reason.find("a motor") != std::string::npos &&
                  f.reason.find("\"sweep\"") != std::string::npos;
    told_rail |= f.link == rail;
  }
  CHECK(told_hinge);
  CHECK(told_rail);
  Simulation simulation = Simulation::copy_of(world);
  const StepReport report = simulation.step();
  CHECK(report.faults == static_cast<int>(faults.size()));
  CHECK((report.fault == hinge || report.fault == rail));
}
