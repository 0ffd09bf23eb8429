// What a program changes in a World that runs: laws of joints, cables, bodies.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <pantin/pantin.hpp>
#include <string>

using namespace pantin;

namespace {

/// What is changed, and what it is changed from and to.
struct Law {
  const char* name;
  bool planar;    // the planar solver knows it
  bool in_loops;  // the default solver knows it at any joint of a loop
  std::function<void(HingeJoint&)> before, after;
  std::function<Result<Done>(World&, Entity)> change;
};

const JointMotor kTurning{.kind = MotorKind::velocity, .target = 2, .gain = 3};
const JointMotor kHolding{.kind = MotorKind::position, .target = 0.4, .gain = 30, .damping = 1};
const SpringDamper kSpring{.stiffness = 20, .damping = 0.3, .rest = 0.2};
const JointFriction kFriction{.viscous = 0.2, .dry = 0.5};
const JointDrive kDrive{.target = Quat(std::cos(0.2), std::sin(0.2), 0, 0),
                        .stiffness = 25,
                        .damping = 0.4,
                        .max_torque = 1e300,
                        .keys = {}};

/// Each from another value, and from none.
std::vector<Law> laws() {
  const auto nothing = [](HingeJoint&) {};
  std::vector<Law> all;
  const auto add = [&](const char* name, bool planar, bool in_loops, auto before, auto after,
                       auto change) {
    all.push_back({name, planar, in_loops, before, after, change});
    all.push_back({name, planar, in_loops, nothing, after, change});
  };
  add(
      "velocity motor", true, false,
      [](HingeJoint& j) { j.motor = {.kind = MotorKind::velocity, .target = -1, .gain = 1}; },
      [](HingeJoint& j) { j.motor = kTurning; },
      [](World& w, Entity e) { return set_motor(w, e, kTurning); });
  add(
      "position motor", true, false, [](HingeJoint& j) { j.motor = kTurning; },
      [](HingeJoint& j) { j.motor = kHolding; },
      [](World& w, Entity e) { return set_motor(w, e, kHolding); });
  add(
      "spring", true, false, [](HingeJoint& j) { j.spring = {.stiffness = 3, .damping = 1}; },
      [](HingeJoint& j) { j.spring = kSpring; },
      [](World& w, Entity e) { return set_spring(w, e, kSpring); });
  add(
      "friction", true, false, [](HingeJoint& j) { j.friction = {.viscous = 1}; },
      [](HingeJoint& j) { j.friction = kFriction; },
      [](World& w, Entity e) { return set_friction(w, e, kFriction); });
  add(
      "limits", true, true,
      [](HingeJoint& j) {
        j.limits = Interval{-1, 1};
      },
      [](HingeJoint& j) {
        j.limits = Interval{-0.1, 0.15};
      },
      [](World& w, Entity e) {
        return set_limits(w, e, Interval{-0.1, 0.15});
      });
  add(
      "drive", false, false,
      [](HingeJoint& j) { j.drive = JointDrive{.stiffness = 2, .damping = 2, .keys = {}}; },
      [](HingeJoint& j) { j.drive = kDrive; },
      [](World& w, Entity e) { return set_drive(w, e, kDrive); });
  const auto none = [](HingeJoint&) {};
  all.push_back({"motor taken away", true, false, [](HingeJoint& j) { j.motor = kTurning; }, none,
                 [](World& w, Entity e) { return set_motor(w, e, {}); }});
  all.push_back({"spring taken away", true, false, [](HingeJoint& j) { j.spring = kSpring; }, none,
                 [](World& w, Entity e) { return set_spring(w, e, {}); }});
  all.push_back({"limits taken away", true, true,
                 [](HingeJoint& j) {
                   j.limits = Interval{-0.1, 0.15};
                 },
                 none, [](World& w, Entity e) { return set_limits(w, e, {}); }});
  all.push_back({"drive taken away", false, false, [](HingeJoint& j) { j.drive = kDrive; }, none,
                 [](World& w, Entity e) { return set_drive(w, e, {}); }});
  return all;
}

struct Rig {
  World world;
  Entity knee;
};

Entity rod(World& world, Vec3 from, Vec3 to) {
  const Vec3 way = to - from;
  const Quat turn(std::cos(0.5 * std::atan2(way.y, way.x)), 0, 0,
                  std::sin(0.5 * std::atan2(way.y, way.x)));
  return world
      .add(RigidBody{.shape = BoxShape{{0.5 * glm::length(way), 0.05, 0.05}},
                     .mass = 1,
                     .position = 0.5 * (from + to),
                     .rotation = turn,
                     .drag = 0})
      .value();
}

/// Two rods that hang from a wall by hinges; the law is the second one's.
Rig arm(Solver solver, const std::function<void(HingeJoint&)>& equip) {
  Rig r;
  r.world.default_settings.solver = solver;
  const Entity wall = r.world.add(RigidBody{.motion = Motion::fixed}).value();
  const Entity upper = rod(r.world, {0, 0, 0}, {0.5, 0, 0});
  const Entity lower = rod(r.world, {0.5, 0, 0}, {0.9, -0.2, 0});
  r.world.add(HingeJoint{.a = wall, .b = upper, .axis = {0, 0, 1}}).value();
  HingeJoint knee{.a = upper, .b = lower, .anchor = {0.5, 0, 0}, .axis = {0, 0, 1}};
  equip(knee);
  r.knee = r.world.add(knee).value();
  return r;
}

/// A four-bar linkage; the law is at the joint that closes it.
Rig four_bar(Solver solver, const std::function<void(HingeJoint&)>& equip) {
  Rig r;
  r.world.default_settings.solver = solver;
  const Vec3 axis{0, 0, 1}, b{0.1, 0.4, 0}, c{1.0, 0.6, 0}, d{0.9, 0, 0};
  const Entity wall = r.world.add(RigidBody{.motion = Motion::fixed}).value();
  const Entity crank = rod(r.world, {0, 0, 0}, b), coupler = rod(r.world, b, c),
               rocker = rod(r.world, c, d);
  r.world.add(HingeJoint{.a = wall, .b = crank, .axis = axis}).value();
  r.world.add(HingeJoint{.a = crank, .b = coupler, .anchor = b, .axis = axis}).value();
  r.world.add(HingeJoint{.a = coupler, .b = rocker, .anchor = c, .axis = axis}).value();
  HingeJoint last{.a = rocker, .b = wall, .anchor = d, .axis = axis};
  equip(last);
  r.knee = r.world.add(last).value();
  return r;
}

bool has_same_motion(const World& one, const World& two) {
  for (std::size_t i = 0; i < one.bodies.size(); ++i) {
    const Body &a = one.bodies.values()[i], &b = two.bodies.values()[i];
    if (a.pose.position != b.pose.position || a.pose.rotation != b.pose.rotation ||
        a.velocity != b.velocity || a.angular_velocity != b.angular_velocity)
      return false;
  }
  return true;
}

Real distance_of(const World& one, const World& two) {
  Real most = 0;
  for (std::size_t i = 0; i < one.bodies.size(); ++i)
    most = std::max(most, glm::length(one.bodies.values()[i].pose.position -
                                      two.bodies.values()[i].pose.position));
  return most;
}

void run(Simulation& sim, int steps) {
  for (int i = 0; i < steps; ++i) REQUIRE(sim.step().status == Status::ok);
}

constexpr Solver kSolvers[] = {Solver::articulated, Solver::lagrangian, Solver::planar};
constexpr Real kStep = 1.0 / 240;

}  // namespace

TEST_CASE("A law that is changed before the first step is as one that was there from the start") {
  for (const Solver solver : kSolvers)
    for (const Law& law : laws()) {
      if (solver == Solver::planar && !law.planar) continue;
      for (const auto& rig : {arm, four_bar}) {
        const bool is_loop = rig == four_bar;
        CAPTURE(name_of(solver), law.name, is_loop);
        Rig changed = rig(solver, law.before), built = rig(solver, law.after);
        Simulation one(std::move(changed.world), {kStep}), two(std::move(built.world), {kStep});
        const auto done = law.change(one.world, changed.knee);
        REQUIRE(done);
        run(one, 100), run(two, 100);
        CHECK(has_same_motion(one.world, two.world));
      }
    }
}

TEST_CASE("A law that is changed while it runs acts in the next step") {
  for (const Solver solver : kSolvers)
    for (const Law& law : laws()) {
      if (solver == Solver::planar && !law.planar) continue;
      CAPTURE(name_of(solver), law.name);
      Rig rig = arm(solver, law.before);
      Simulation sim(std::move(rig.world), {kStep});
      run(sim, 40);
      const Real angle = joint_angle(sim.world, rig.knee);
      // A World built anew in this pose with the law has no past, so it goes on a little otherwise.
      Rig fresh = arm(solver, law.after);
      for (std::size_t i = 0; i < fresh.world.bodies.size(); ++i) {
        const Body& from = sim.world.bodies.values()[i];
        Body& to = fresh.world.bodies.values()[i];
        to.pose = from.pose, to.velocity = from.velocity;
        to.angular_velocity = from.angular_velocity;
      }
      Simulation anew(std::move(fresh.world), {kStep});
      Simulation without = Simulation::copy_of(sim.world, {kStep});
      REQUIRE(law.change(sim.world, rig.knee));
      CHECK(joint_angle(sim.world, rig.knee) == angle);
      run(sim, 30), run(anew, 30), run(without, 30);
      CHECK(distance_of(sim.world, anew.world) < 1e-3);
      CHECK(distance_of(sim.world, without.world) > 20 * distance_of(sim.world, anew.world));
    }
}

TEST_CASE("What is set to what it is leaves every bit as it was") {
  for (const Solver solver : kSolvers)
    for (const auto& rig : {arm, four_bar}) {
      const bool is_loop = rig == four_bar;
      CAPTURE(name_of(solver), is_loop);
      const auto equip = [](HingeJoint& j) {
        j.motor = kTurning, j.spring = kSpring, j.friction = kFriction;
        j.limits = Interval{-2, 0.9};
      };
      Rig r = rig(solver, equip);
      Simulation still = Simulation::copy_of(r.world, {kStep}), busy(std::move(r.world), {kStep});
      const Entity body = busy.world.bodies.owners()[2];
      for (int i = 0; i < 120; ++i) {
        World& w = busy.world;
        REQUIRE(set_motor(w, r.knee, motor_of(w, r.knee)));
        REQUIRE(set_spring(w, r.knee, spring_of(w, r.knee)));
        REQUIRE(set_friction(w, r.knee, friction_of(w, r.knee)));
        REQUIRE(set_limits(w, r.knee, limits_of(w, r.knee)));
        REQUIRE(set_gravity_scale(w, body, 1));
        REQUIRE(set_drag(w, body, 0));
        REQUIRE(set_mass(w, body, 1));
        still.step(), busy.step();
        REQUIRE(has_same_motion(still.world, busy.world));
      }
    }
}

TEST_CASE("Masses, gravity and drag of a body that runs") {
  for (const Solver solver : kSolvers) {
    CAPTURE(name_of(solver));
    World world;
    world.default_settings.solver = solver;
    const auto ball = [&](Real x) {
      return world
          .add(RigidBody{.shape = SphereShape{0.1}, .mass = 2, .position = {x, 0, 0}, .drag = 0})
          .value();
    };
    const Entity light = ball(0), heavy = ball(1), floating = ball(2), slow = ball(3);
    Simulation sim(std::move(world), {kStep});
    run(sim, 24);
    World& w = sim.world;
    for (const Entity e : {light, heavy}) CHECK(w.bodies[e].velocity.y == Approx(-0.981));
    REQUIRE(set_mass(w, heavy, 8));
    CHECK(w.bodies[heavy].inertia.x == Approx(4 * w.bodies[light].inertia.x));
    REQUIRE(set_gravity_scale(w, floating, 0));
    REQUIRE(set_drag(w, slow, 10));
    for (const Entity e : {light, heavy})
      REQUIRE(impulse(w, e, {0, 0.4, 0}, w.bodies[e].pose.position));
    run(sim, 24);
    const Real close = solver == Solver::planar ? 1e-5 : 1e-9;  // Box2D reckons in floats
    CHECK(w.bodies[light].velocity.y == Approx(-1.962 + 0.2).epsilon(close));
    CHECK(w.bodies[heavy].velocity.y == Approx(-1.962 + 0.05).epsilon(close));
    CHECK(w.bodies[floating].velocity.y == Approx(-0.981).epsilon(close));
    const Real end = 0.981 * std::exp(-1.0) + 0.981 * (1 - std::exp(-1.0));
    CHECK(w.bodies[slow].velocity.y == Approx(-end).epsilon(2e-2));
  }
}

TEST_CASE("A cable is let out and taken in") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian}) {
    CAPTURE(name_of(solver));
    World world;
    world.default_settings.solver = solver;
    const Entity beam = world.add(RigidBody{.motion = Motion::fixed}).value();
    const Entity load =
        world.add(RigidBody{.shape = SphereShape{0.1}, .mass = 3, .position = {0, -1, 0}}).value();
    const Entity cable =
        world.add(CableJoint{.a = beam, .b = load, .anchor_b = {0, -1, 0}}).value();
    Simulation sim(std::move(world), {kStep});
    run(sim, 60);
    REQUIRE(set_cable_length(sim.world, cable, 1.5));
    CHECK(cable_length(sim.world, cable) == 1.5);
    run(sim, 24);
    CHECK(sim.world.bodies[load].velocity.y == Approx(-0.981).epsilon(0.02));  // falls freely
    run(sim, 480);
    CHECK(sim.world.bodies[load].pose.position.y == Approx(-1.5).margin(2e-3));
    for (Real length = 1.5; length > 1.2; length -= 1e-3) {
      REQUIRE(set_cable_length(sim.world, cable, length));
      run(sim, 1);
    }
    CHECK(sim.world.bodies[load].pose.position.y == Approx(-1.2).margin(5e-3));
  }
}

TEST_CASE("Cones, twists and second angles are set for joints that had none") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian}) {
    CAPTURE(name_of(solver));
    World world;
    world.default_settings.solver = solver;
    const Quat askew = glm::normalize(Quat(0.8, 0.3, -0.4, 0.2));
    const Entity wall = world.add(RigidBody{.motion = Motion::fixed, .rotation = askew}).value();
    const auto hang = [&](Vec3 at) {
      return world
          .add(RigidBody{.shape = BoxShape{{0.3, 0.04, 0.06}},
                         .mass = 1,
                         .position = at + Vec3(0.3, 0, 0),
                         .drag = 0})
          .value();
    };
    const Entity ball =
        world.add(BallJoint{.a = wall, .b = hang({0, 0, 0}), .axis = {1, 0, 0}}).value();
    const Entity cross = world
                             .add(UniversalJoint{.a = wall,
                                                 .b = hang({0, 0, 2}),
                                                 .anchor = {0, 0, 2},
                                                 .axis_a = {0, 1, 0},
                                                 .axis_b = {0, 0, 1}})
                             .value();
    Simulation sim(std::move(world), {kStep});
    CHECK(glm::length(joint_swing(sim.world, ball)) < 1e-12);  // the pose it was added in
    REQUIRE(set_cone(sim.world, ball, ConeLimit{0.2, 0.2}));
    REQUIRE(set_limits(sim.world, ball, Interval{-0.1, 0.1}));
    REQUIRE(set_second_limits(sim.world, cross, Interval{-0.3, 0.3}));
    Real swing = 0, twist = 0, second = 0;
    for (int i = 0; i < 480; ++i) {
      run(sim, 1);
      swing = std::max(swing, glm::length(joint_swing(sim.world, ball)));
      twist = std::max(twist, std::abs(joint_angle(sim.world, ball)));
      second = std::max(second, std::abs(joint_second_angle(sim.world, cross)));
    }
    CHECK(swing == Approx(0.2).margin(2e-3));
    CHECK(twist < 0.101);
    CHECK(second == Approx(0.3).margin(2e-3));
  }
}

TEST_CASE("A figure follows a pose, by as much as its muscles are strong") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian}) {
    CAPTURE(name_of(solver));
    World start;
    start.default_settings.solver = solver;
    start.gravity = Vec3(0);
    const Ragdoll doll = build_ragdoll(start, {.collision = {}}).value();
    const auto turn_of = [&](const World& w, Entity e) { return w.origin_pose(e).rotation; };
    // The pose: as it stands, but forearms bent forwards by 1 rad and the whole figure lying.
    const Quat lying(std::sqrt(0.5), std::sqrt(0.5), 0, 0);
    std::vector<BodyTurn> pose;
    for (const Entity e : doll.bodies()) pose.push_back({e, lying * turn_of(start, e)});
    const Quat bent(std::cos(0.5), -std::sin(0.5), 0, 0);
    for (BodyTurn& turn : pose)
      if (turn.body == doll.forearms[0] || turn.body == doll.forearms[1])
        turn.rotation = lying * bent * turn_of(start, turn.body);
    Simulation sim(std::move(start), {kStep});
    World& w = sim.world;
    const Real before = joint_angle(w, doll.elbows[0]);
    const auto bends = [&](Real part, int steps) {
      for (int i = 0; i < steps; ++i) {
        REQUIRE(follow(w, doll.joints(), pose,
                       {.stiffness = part * 60, .damping = part * 6, .keys = {}}));
        run(sim, 1);
      }
      return std::abs(joint_angle(w, doll.elbows[0]) - before);
    };
    const Quat pelvis = turn_of(w, doll.pelvis);
    CHECK(bends(0, 60) < 1e-9);
    CHECK(bends(1, 720) == Approx(1).margin(0.02));
    CHECK(std::abs(glm::dot(turn_of(w, doll.pelvis), pelvis)) > 0.9);  // not turned as a whole
    CHECK(!follow(w, {&doll.pelvis, 1}, pose, {}));
  }
}

TEST_CASE("What is wrong is told by member, and nothing is changed") {
  Rig r = arm(Solver::articulated, [](HingeJoint& j) { j.name = "knee", j.motor = kTurning; });
  World& w = r.world;
  const Entity body = w.bodies.owners()[1], wall = w.bodies.owners()[0];
  const std::uint64_t before = state_hash(w);
  const auto refuses = [&](const Result<Done>& result, const std::string& why) {
    REQUIRE(!result);
    CHECK(result.errors().front().message == why);
    CHECK(state_hash(w) == before);
  };
  refuses(set_motor(w, r.knee, {.kind = MotorKind::velocity, .target = 1, .gain = -1}),
          "set_motor 'knee': motor.gain: found -1, expected 0 or a number above it");
  refuses(set_motor(w, body, kTurning),
          "set_motor '#1': joint: found '#1', which is no joint, expected a joint");
  refuses(set_motor(w, r.knee, kTurning, JointCoordinate::travel),
          "set_motor 'knee': joint: found a joint of kind hinge, expected one with one rotational "
          "or translational coordinate");
  refuses(set_limits(w, r.knee, Interval{1, 0}),
          "set_limits 'knee': limits: found 1 to 0, expected two finite numbers, the lower one "
          "first");
  refuses(set_cone(w, r.knee, ConeLimit{1, 1}),
          "set_cone 'knee': joint: found a joint of kind hinge, expected a ball joint");
  refuses(set_soft_stop(w, r.knee, SoftStop{0.1, 10}),
          "set_soft_stop 'knee': soft_stop: found one, expected limits beside it");
  refuses(set_drive(w, r.knee, JointDrive{.stiffness = -1, .keys = {}}),
          "set_drive 'knee': drive.stiffness: found -1, expected 0 or a number above it");
  refuses(set_cable_length(w, r.knee, 1),
          "set_cable_length 'knee': cable: found 'knee', which is no cable, expected a cable");
  refuses(set_mass(w, wall, 1),
          "set_mass '#0': body: found a fixed or kinematic body, expected a dynamic one");
  refuses(set_mass(w, body, 0), "set_mass '#1': mass: found 0, expected a number above 0");
  refuses(impulse(w, body, {NAN, 0, 0}, {}),
          "impulse '#1': impulse: found (nan, 0, 0), expected finite numbers");
  refuses(ignore(w, body, body, 1), "ignore: b: found the same body as a, expected another one");
  w.default_settings.solver = Solver::sweep, w.mark_dirty();
  CHECK(!set_spring(w, r.knee, kSpring));  // a solver that knows no springs
  CHECK(motor_of(w, body).gain == 0);
}
