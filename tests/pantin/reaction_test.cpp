// What joints bear under the default solver, against closed forms and the Lagrangian solver.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

using namespace pantin;
using namespace pantin::detail;

namespace {

constexpr Real kG = 9.81;
const Vec3 kDown(0, -kG, 0);

Entity fixed_at(World& world, Vec3 at) {
  return world.add(RigidBody{.motion = Motion::fixed, .position = at}).value();
}

/// A beam of 1 m along x from `from`, 4 kg.
Entity beam_from(World& world, Vec3 from) {
  return world
      .add(RigidBody{.shape = BoxShape{.half_extents = {0.5, 0.05, 0.05}},
                     .mass = 4.0,
                     .position = from + Vec3(0.5, 0, 0),
                     .drag = 0})
      .value();
}

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) REQUIRE(simulation.step().status == Status::ok);
}

JointReaction reaction_of(const Simulation& simulation, Entity joint) {
  const auto reaction = joint_reaction(simulation.world, joint);
  REQUIRE(reaction);
  return *reaction;
}

/// A bob beside its hinge: it turns about z at 1 m and is carried 0.4 m along the axis.
struct SidePendulum {
  World world;
  Entity bob, hinge;

  explicit SidePendulum(Solver solver) {
    world.default_settings.solver = solver;
    const Entity wall = fixed_at(world, {0, 0, 0});
    bob = world
              .add(RigidBody{.shape = SphereShape{.radius = 0.3},
                             .mass = 2.0,
                             .position = {1, 0, 0.4},
                             .drag = 0})
              .value();
    hinge = world.add(HingeJoint{.a = wall, .b = bob, .axis = {0, 0, 1}}).value();
  }

  /// What the bob's motion asks for.
  JointReaction asked(const Simulation& simulation) const {
    const Body& b = simulation.world.bodies[bob];
    const Vec3 arm = b.pose.position, across(arm.x, arm.y, 0), z(0, 0, 1);
    const Real inertia = b.inertia.x, spin = b.angular_velocity.z;
    const Real rate = glm::dot(z, glm::cross(arm, 2.0 * kDown)) / (inertia + 2 * 1.0);
    const Vec3 force = 2.0 * (rate * glm::cross(z, across) - spin * spin * across - kDown);
    return {force, inertia * rate * z + glm::cross(arm, force)};
  }
  /// Takes a step; how far the reaction is off the mean of that, part of the largest.
  Real step(Simulation& simulation) const {
    const JointReaction before = asked(simulation);
    run(simulation, 1);
    const JointReaction after = asked(simulation), told = reaction_of(simulation, hinge);
    return (glm::length(told.force - 0.5 * (before.force + after.force)) +
            glm::length(told.torque - 0.5 * (before.torque + after.torque))) /
           (3 * 2 * kG);
  }
};

/// Hinge, universal, fixed and ball joints that fall from a crooked pose.
struct CrookedArm {
  World world;
  std::vector<Entity> joints;

  explicit CrookedArm(Solver solver) {
    world.default_settings.solver = solver;
    const auto box = [&](Vec3 at) {
      return world
          .add(RigidBody{.shape = BoxShape{.half_extents = {0.25, 0.06, 0.1}},
                         .mass = 1.0,
                         .position = at,
                         .drag = 0})
          .value();
    };
    const Entity wall = fixed_at(world, {0, 0, 0});
    const Entity first = box({0.25, 0, 0.05}), second = box({0.75, 0.1, 0}),
                 third = box({1.25, 0, 0.1}), fourth = box({1.75, 0.05, 0});
    const Vec3 skew = glm::normalize(Vec3(0.2, 0.1, 1));
    joints.push_back(world.add(HingeJoint{.a = wall, .b = first, .axis = skew}).value());
    joints.push_back(world
                         .add(UniversalJoint{.a = second,
                                             .b = first,
                                             .anchor = {0.5, 0, 0},
                                             .axis_a = {0, 1, 0},
                                             .axis_b = {0, 0, 1}})
                         .value());
    joints.push_back(world.add(FixedJoint{.a = second, .b = third, .anchor = {1, 0, 0}}).value());
    joints.push_back(world.add(BallJoint{.a = third, .b = fourth, .anchor = {1.5, 0, 0}}).value());
  }

  /// Means over the last of the steps that end after a quarter of a second, each taken in parts.
  std::vector<JointReaction> reactions(int steps_per_second, int parts = 1) const {
    Simulation simulation = Simulation::copy_of(world, {.h = 1.0 / (steps_per_second * parts)});
    run(simulation, (steps_per_second / 4 - 1) * parts);
    std::vector<JointReaction> all(joints.size());
    for (int part = 0; part < parts; ++part) {
      run(simulation, 1);
      for (std::size_t i = 0; i < joints.size(); ++i) {
        const JointReaction told = reaction_of(simulation, joints[i]);
        all[i].force += told.force / Real(parts), all[i].torque += told.torque / Real(parts);
      }
    }
    return all;
  }
};

}  // namespace

TEST_CASE("two beams clamped end to end: each clamp bears the weight and the moment beyond it") {
  const Solver solver = GENERATE(Solver::articulated, Solver::lagrangian);
  CAPTURE(name_of(solver));
  World world;
  world.default_settings.solver = solver;
  const Entity wall = fixed_at(world, {0, 0, 0});
  const Entity inner = beam_from(world, {0, 0, 0}), outer = beam_from(world, {1, 0, 0});
  const Entity root = world.add(FixedJoint{.a = wall, .b = inner}).value();
  // The other way round: what is told is the opposite.
  const Entity middle = world.add(FixedJoint{.a = outer, .b = inner, .anchor = {1, 0, 0}}).value();
  Simulation simulation = Simulation::copy_of(world);
  run(simulation, 30);
  const JointReaction at_root = reaction_of(simulation, root);
  const JointReaction in_middle = reaction_of(simulation, middle);
  CHECK(glm::length(at_root.force + 8.0 * kDown) < 1e-6);
  CHECK(glm::length(at_root.torque - Vec3(0, 0, 8 * kG * 1)) < 1e-6);
  CHECK(glm::length(in_middle.force - 4.0 * kDown) < 1e-6);
  CHECK(glm::length(in_middle.torque + Vec3(0, 0, 4 * kG * 0.5)) < 1e-6);
}

TEST_CASE("a pendulum beside its hinge: force and torque follow its motion, to second order") {
  const SidePendulum pendulum(Solver::articulated);
  Real before = 0;
  for (const int rate : {120, 480, 1920}) {
    Simulation simulation = Simulation::copy_of(pendulum.world, {.h = 1.0 / rate});
    Real worst = 0;
    for (int i = 0; i < rate; ++i) {
      const Real error = pendulum.step(simulation);
      if (i > rate / 10) worst = std::max(worst, error);
    }
    CAPTURE(rate, worst, before);
    if (before > 0) CHECK(worst < before / 12);
    before = worst;
  }
  CHECK(before < 1e-5);
}

TEST_CASE("every joint of a falling arm bears what the Lagrangian solver says, as steps shrink") {
  const CrookedArm slow(Solver::lagrangian), arm(Solver::articulated);
  const auto worst = [&](int rate) {
    const std::vector<JointReaction> told = arm.reactions(rate);
    const std::vector<JointReaction> exact = slow.reactions(rate, 7680 / rate);
    Real most = 0;
    for (std::size_t i = 0; i < told.size(); ++i)
      most = std::max({most, glm::length(told[i].force - exact[i].force),
                       glm::length(told[i].torque - exact[i].torque)});
    return most;
  };
  const Real coarse = worst(240), fine = worst(960);
  CAPTURE(coarse, fine);
  CHECK(fine < coarse / 10);
  CHECK(fine < 2e-3);
}

TEST_CASE("a beam on a hinge: what holds it level decides what the hinge bears") {
  enum Holder { stop, drive, cable, ground };
  const Holder holder = GENERATE(stop, drive, cable, ground);
  CAPTURE(holder);
  World world;
  const Entity wall = fixed_at(world, {0, 0, 0}), beam = beam_from(world, {0, 0, 0});
  world.bodies[beam].drag = 5;
  HingeJoint described{.a = wall, .b = beam, .axis = {0, 0, 1}};
  if (holder == stop) described.limits = Interval{0, 1};
  if (holder == drive) {
    described.drive.emplace();
    described.drive->stiffness = 1e5, described.drive->damping = 1e3;
  }
  const Entity hinge = world.add(described).value();
  Entity string;
  if (holder == cable)
    string =
        world.add(CableJoint{.a = wall, .b = beam, .anchor_a = {1, 1, 0}, .anchor_b = {1, 0, 0}})
            .value();
  if (holder == ground) {
    world.collisions.add(beam, Collision{.friction = 0});
    world
        .add(RigidBody{.motion = Motion::fixed,
                       .shape = BoxShape{.half_extents = {0.1, 0.1, 0.1}},
                       .position = {0.9, -0.15, 0},
                       .collision = Collision{}})
        .value();
  }
  Simulation simulation = Simulation::copy_of(world);
  run(simulation, 240);
  const JointReaction told = reaction_of(simulation, hinge);
  const Vec3 weight = 4.0 * kDown, centre = simulation.world.bodies[beam].pose.position;
  Vec3 force = told.force + weight, torque = told.torque + glm::cross(centre, weight);
  if (holder == stop) CHECK(told.torque.z == Approx(4 * kG * 0.5).epsilon(1e-6));
  if (holder == drive) {
    CHECK(std::abs(told.torque.z) < 1e-3);
    const Real given = simulation.world.joint_drives[hinge].torque;
    CHECK(given == Approx(4 * kG * 0.5).epsilon(1e-3));
    torque += given * Vec3(0, 0, 1);
  }
  if (holder == cable) {
    const Real tension = cable_tension(simulation.world, string);
    CHECK(tension == Approx(4 * kG / 2).epsilon(1e-3));
    const Vec3 pull(0, tension, 0);
    force += pull, torque += glm::cross(Vec3(1, 0, 0), pull);
  }
  if (holder == ground)
    each_contact(simulation.world, [&](const Contact& c) {
      const Vec3 at = to_world(simulation.world.bodies[beam].pose, c.point_a);
      force += c.force, torque += glm::cross(at, c.force);
    });
  // Balance, whoever holds it.
  CHECK(glm::length(force) < 1e-3 * 4 * kG);
  CHECK(glm::length(torque) < 2e-3 * 4 * kG);
}

TEST_CASE("reactions keep to their joint while others come and go") {
  World world;
  const Entity wall = fixed_at(world, {0, 0, 0});
  const Entity doomed = beam_from(world, {0, 5, 0}), beam = beam_from(world, {0, 0, 0});
  const Entity first = world.add(FixedJoint{.a = wall, .b = doomed, .anchor = {0, 5, 0}}).value();
  const Entity second = world.add(FixedJoint{.a = wall, .b = beam}).value();
  Simulation simulation = Simulation::copy_of(world);
  run(simulation, 5);
  simulation.world.destroy(doomed);
  CHECK_FALSE(joint_reaction(simulation.world, first));
  CHECK(glm::length(reaction_of(simulation, second).torque - Vec3(0, 0, 4 * kG * 0.5)) < 1e-6);
  run(simulation, 1);
  CHECK(glm::length(reaction_of(simulation, second).torque - Vec3(0, 0, 4 * kG * 0.5)) < 1e-6);
}

TEST_CASE("solvers that know no forces tell none") {
  const Solver solver = GENERATE(Solver::sweep, Solver::shake2, Solver::procedural);
  CAPTURE(name_of(solver));
  World world;
  world.default_settings.solver = solver;
  const Entity wall = fixed_at(world, {0, 0, 0}), beam = beam_from(world, {0, 0, 0});
  const Entity hinge = world.add(HingeJoint{.a = wall, .b = beam, .axis = {0, 0, 1}}).value();
  Simulation simulation = Simulation::copy_of(world);
  run(simulation, 5);
  CHECK_FALSE(joint_reaction(simulation.world, hinge));
}
