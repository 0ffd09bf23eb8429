// Belts: ways in closed form, ratios, tensioners and slip.
#include <catch2/catch.hpp>

#include "engine/world/ties.hpp"
#include "tests/solvers/planar.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

BeltPulley pulley_on(const World& w, Entity body, Real radius, Real sense) {
  BeltPulley p;
  p.body = body, p.sense = sense, p.outline.radius = radius;
  p.frame = glm::conjugate(w.bodies[body].pose.rotation);
  return p;
}

std::vector<Pose> poses_of(const World& w, const Belt& belt) {
  std::vector<Pose> poses;
  for (const BeltPulley& p : belt.pulleys) poses.push_back(w.bodies[p.body].pose);
  return poses;
}

Entity add_laid(World& w, Belt belt) {
  REQUIRE(lay_belt(belt, poses_of(w, belt)));
  return add_belt(w, belt);
}

/// A disc of 1 kg/m^2 that turns about its middle.
Entity add_wheel(World& w, Entity frame, Vec3 at, Real inertia) {
  Body b;
  b.mass = 1, b.inertia = Vec3(inertia), b.drag = 0, b.pose.position = at;
  const Entity e = w.add_body(b);
  add_hinge(w, frame, e, at);
  return e;
}

Real turn_of(const World& w, Entity e) {
  const Quat q = w.bodies[e].pose.rotation;
  return 2 * std::atan2(q.z, q.w);
}

/// Turns counted from step to step.
struct Count {
  Entity of;
  Real way = 0, last = 0;
  void add(const World& w) {
    const Real now = turn_of(w, of);
    way += std::remainder(now - last, 2 * kPi), last = now;
  }
};

/// The circumference of an ellipse by 720 corners.
std::vector<Vec3> ellipse(Real a, Real b) {
  std::vector<Vec3> points;
  for (int i = 0; i < 720; ++i)
    points.push_back({a * std::cos(i * kPi / 360), b * std::sin(i * kPi / 360), 0});
  return points;
}

Real spin_energy(const World& w) {
  Real sum = 0;
  for (const Body& b : w.bodies.values())
    if (b.motion == Motion::dynamic)
      sum += 0.5 * b.inertia.z * b.angular_velocity.z * b.angular_velocity.z +
             0.5 * b.mass * glm::dot(b.velocity, b.velocity);
  return sum;
}

}  // namespace

TEST_CASE("belts on two round pulleys are as long as the closed form says") {
  for (const Real sense : {1.0, -1.0}) {
    World w = planar_world();
    const Entity frame = add_fixed(w);
    Belt belt;
    belt.pulleys = {pulley_on(w, add_wheel(w, frame, {0, 0, 0}, 1), 0.5, 1),
                    pulley_on(w, add_wheel(w, frame, {3, 0, 0}, 1), 1, sense)};
    REQUIRE(lay_belt(belt, poses_of(w, belt)));
    // The vectors of the method: r = 0.5 and 1, 3 m apart.
    CHECK(belt.length ==
          Approx(sense > 0 ? 10.795916842703996 : 11.479337729886218).epsilon(1e-14));
    CHECK(std::abs(belt.turning) == Approx(sense > 0 ? 2 * kPi : 0).margin(1e-12));
  }
}

TEST_CASE("a hull of many corners has the way of its circle") {
  World w = planar_world();
  const Entity frame = add_fixed(w);
  const Entity one = add_wheel(w, frame, {0, 0, 0}, 1), two = add_wheel(w, frame, {3, 0, 0}, 1);
  Belt belt;
  belt.pulleys = {pulley_on(w, one, 0.5, 1), pulley_on(w, two, 1, 1)};
  belt.pulleys[0].outline = hull_outline(ellipse(0.5, 0.5));
  REQUIRE(lay_belt(belt, poses_of(w, belt)));
  CHECK(belt.length == Approx(10.795916842703996).margin(2e-5));
  CHECK(hull_outline(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}).corners.empty());
  const BeltOutline square =
      hull_outline(std::vector<Vec3>{{1, 1, 0}, {-1, 1, 0}, {0.2, 0, 0}, {-1, -1, 0}, {1, -1, 0}});
  CHECK(square.corners.size() == 4);
  CHECK(perimeter_of(square) == Approx(8));
  CHECK(length_up_to(square, 0.3 + 6 * kPi) - length_up_to(square, 0.3) == Approx(24));
}

TEST_CASE("belts keep their ratio over a thousand turns, by both solvers") {
  for (const Solver solver : {Solver::planar, Solver::lagrangian})
    for (const Real sense : {1.0, -1.0}) {
      World w = planar_world();
      w.default_settings.solver = solver;
      const Entity frame = add_fixed(w);
      const Entity one = add_wheel(w, frame, {0, 0, 0}, 1), two = add_wheel(w, frame, {3, 0, 0}, 4);
      Belt belt;
      belt.pulleys = {pulley_on(w, one, 0.5, 1), pulley_on(w, two, 1, sense)};
      const Entity e = add_laid(w, belt);
      w.bodies[one].angular_velocity.z = 80, w.bodies[two].angular_velocity.z = 40 * sense;
      Count first{one}, second{two};
      while (std::abs(first.way) < 1000 * 2 * kPi) {
        REQUIRE(run(w, 1.0 / 60, 1).status == Status::ok);
        first.add(w), second.add(w);
        REQUIRE(w.time < 100);
      }
      CHECK(std::abs(second.way - 0.5 * sense * first.way) < 1e-6);
      CHECK(w.belts[e].travel == Approx(0.5 * first.way).margin(1e-6));
      CHECK(std::abs(w.belts[e].defect) < 1e-9);
    }
}

TEST_CASE("a drive by an ellipse keeps its energy, and its defect is that of its way") {
  World w = planar_world({0, 0, 0});
  const Entity frame = add_fixed(w);
  const Entity one = add_wheel(w, frame, {0, 0, 0}, 1), two = add_wheel(w, frame, {3, 0, 0}, 4);
  Belt belt;
  belt.pulleys = {pulley_on(w, one, 0.5, 1), pulley_on(w, two, 1, 1)};
  belt.pulleys[0].outline = hull_outline(ellipse(0.6, 0.4));
  const Entity e = add_laid(w, belt);
  w.bodies[one].angular_velocity.z = 6;
  run(w, 1.0 / 60, 1);
  const Real start = spin_energy(w);
  Real worst = 0, most = 0, least = 0, slowest = 1e9, fastest = 0;
  for (int i = 0; i < 600; ++i) {
    REQUIRE(run(w, 1.0 / 60, 1).status == Status::ok);
    worst = std::max(worst, std::abs(spin_energy(w) / start - 1));
    const Belt& now = w.belts[e];
    most = std::max(most, now.defect), least = std::min(least, now.defect);
    const Real ratio = w.bodies[two].angular_velocity.z / w.bodies[one].angular_velocity.z;
    slowest = std::min(slowest, ratio), fastest = std::max(fastest, ratio);
  }
  INFO(worst << " " << most << " " << least << " " << slowest << " " << fastest);
  CHECK(worst < 1e-4);
  // Half of each ellipse lies against the belt, so its way changes by less than its axes differ.
  CHECK(most - least > 0.01);
  CHECK(most - least < 0.2);
  // The belt's line passes the ellipse's centre at 0.4 to 0.6 m, and the wheel's at 1 m.
  CHECK(slowest == Approx(0.4).margin(0.01));
  CHECK(fastest == Approx(0.6).margin(0.01));
}

namespace {

/// Two wheels and an idler on an arm that a spring draws against the belt from outside.
struct Tensioned {
  World w = planar_world();
  Entity one, two, arm, idler, belt;
  explicit Tensioned(Solver solver) {
    w.default_settings.solver = solver;
    const Entity frame = add_fixed(w);
    one = add_wheel(w, frame, {0, 0, 0}, 0.5), two = add_wheel(w, frame, {3, 0, 0}, 0.5);
    arm = add_rod(w, {0.7, 1.2, 0}, {1.5, 0.9, 0});
    const Entity hinge = add_hinge(w, frame, arm, {0.7, 1.2, 0});
    JointParameters own;
    own.rotation.spring = {100, 5, -1};
    w.links[hinge].joint.parameters.edit() = own;
    idler = add_wheel(w, arm, {1.5, 0.9, 0}, 0.05);
    Belt made;
    made.pulleys = {pulley_on(w, one, 0.5, 1), pulley_on(w, two, 1, 1),
                    pulley_on(w, idler, 0.2, -1)};
    made.pulleys[0].outline = hull_outline(ellipse(0.55, 0.45));
    belt = add_laid(w, made);
    w.bodies[one].angular_velocity.z = 6, w.bodies[two].angular_velocity.z = 3;
    w.bodies[idler].angular_velocity.z = -15;
  }
};

}  // namespace

TEST_CASE("a belt over a tensioner keeps its length while pulleys out of round move the idler") {
  Tensioned flat(Solver::planar), exact(Solver::lagrangian);
  CHECK(held_spans(flat.w, flat.w.belts[flat.belt]) == 3);
  const Real length = flat.w.belts[flat.belt].length;
  Real most = -10, least = 10;
  for (int i = 0; i < 480; ++i) {
    REQUIRE(run(flat.w, 1.0 / 240, 1).status == Status::ok);
    REQUIRE(std::abs(flat.w.belts[flat.belt].length - length) < 1e-9);
    most = std::max(most, turn_of(flat.w, flat.arm));
    least = std::min(least, turn_of(flat.w, flat.arm));
  }
  CHECK(most - least > 0.02);
  run(exact.w, 1.0 / 960, 1920);
  CHECK(std::abs(exact.w.belts[exact.belt].length - length) < 1e-7);
  for (const Entity e : {flat.one, flat.two, flat.arm})
    CHECK(std::remainder(turn_of(flat.w, e) - turn_of(exact.w, e), 2 * kPi) ==
          Approx(0).margin(0.04));
  for (int i = 0; i < 3; ++i)
    CHECK(flat.w.belts[flat.belt].pulleys[i].tension ==
          Approx(exact.w.belts[exact.belt].pulleys[i].tension).epsilon(0.05));
}

TEST_CASE("a belt with too little pretension slips at the capstan limit and no earlier") {
  for (const Real torque : {60.0, 120.0}) {
    World w = planar_world({0, 0, 0});
    const Entity frame = add_fixed(w);
    const Entity one = add_wheel(w, frame, {0, 0, 0}, 1), two = add_wheel(w, frame, {3, 0, 0}, 1);
    Belt belt;
    belt.pulleys = {pulley_on(w, one, 0.5, 1), pulley_on(w, two, 0.5, 1)};
    belt.friction = 0.3, belt.pretension = 100;
    const Entity e = add_laid(w, belt);
    const Real grip = 2 * 100 * std::tanh(0.5 * 0.3 * kPi);
    CHECK(grip_of(w.belts[e]) == Approx(grip));
    for (int i = 0; i < 240; ++i) {
      w.forces.add(one, {Vec3(0), {0, 0, torque}});
      run(w, 1.0 / 240, 1);
    }
    // Without a slip both turn as one and the belt bears half of the torque.
    const bool slips = 0.5 * torque / 0.5 > grip;
    CHECK(w.belts[e].slips == slips);
    const Real pull = slips ? grip : 0.5 * torque / 0.5;
    CHECK(w.bodies[two].angular_velocity.z == Approx(0.5 * pull).epsilon(1e-3));
    CHECK(w.bodies[one].angular_velocity.z == Approx(torque - 0.5 * pull).epsilon(1e-3));
    CHECK(std::abs(w.belts[e].pulleys[0].tension - 100) == Approx(pull).epsilon(1e-3));
  }
}

TEST_CASE("a driven pulley that touches something drives its belt without a slip") {
  World w = planar_world({0, 0, 0});
  const Entity frame = add_fixed(w);
  const Entity one = add_wheel(w, frame, {0, 0, 0}, 1), two = add_wheel(w, frame, {3, 0, 0}, 1);
  Belt belt;
  belt.pulleys = {pulley_on(w, one, 0.5, 1), pulley_on(w, two, 0.5, 1)};
  belt.friction = 0.3, belt.pretension = 100;
  const Entity e = add_laid(w, belt);
  Shape disc;
  disc.kind = ShapeKind::sphere, disc.size = {0.5, 0, 0};
  w.shapes.add(one, {{disc}}), w.collisions.add(one, {});
  add_solid(w, ShapeKind::sphere, {0.1, 0, 0}, {{0, 0.6, 0}});
  const DriveMotion steady{.speed = 20, .knots = {}};
  w.joint_drives.add(w.links.owners()[0],
                     {.max_torque = 1e300, .keys = {}, .exact = true, .motion = steady});
  for (const Entity wheel : {one, two}) w.bodies[wheel].angular_velocity.z = 20;
  int touched = 0;
  for (int i = 0; i < 60; ++i) {
    run(w, 1.0 / 60, 1);
    touched += !detail::planar::plane_of(w).touches.empty();
    CHECK(w.belts[e].slips == 0);
    CHECK(w.bodies[two].angular_velocity.z == Approx(20).epsilon(1e-6));
  }
  CHECK(touched > 0);
}

TEST_CASE("a stiff motor on a light pulley turns a wheel a thousand times as heavy as it should") {
  World w = planar_world({0, 0, 0});
  const Entity frame = add_fixed(w);
  const Entity one = add_wheel(w, frame, {0, 0, 0}, 0.01), two = add_wheel(w, frame, {3, 0, 0}, 10);
  Belt belt;
  belt.pulleys = {pulley_on(w, one, 0.5, 1), pulley_on(w, two, 1, 1)};
  add_laid(w, belt);
  JointParameters own;
  own.rotation.motor = {MotorKind::velocity, 10, 2, 0, 1e300};
  w.links.values()[0].joint.parameters.edit() = own;
  run(w, 1.0 / 60, 60);
  // w' = gain (10 - w) / I with I = 0.01 + 10 / 4 at the motor.
  CHECK(w.bodies[one].angular_velocity.z == Approx(10 * (1 - std::exp(-2 / 2.51))).epsilon(0.01));
}

TEST_CASE("belts run on over four thousand radians a second, and teleports do not stop them") {
  World w = planar_world({0, 0, 0});
  const Entity frame = add_fixed(w);
  const Entity one = add_wheel(w, frame, {0, 0, 0}, 1), two = add_wheel(w, frame, {3, 0, 0}, 1);
  Belt belt;
  belt.pulleys = {pulley_on(w, one, 0.5, 1), pulley_on(w, two, 1, 1)};
  const Entity e = add_laid(w, belt);
  w.bodies[one].angular_velocity.z = 4000, w.bodies[two].angular_velocity.z = 2000;
  run(w, 1.0 / 60, 300);
  CHECK(w.belts[e].travel == Approx(0.5 * 4000 * 5).epsilon(1e-6));
  CHECK(w.bodies[two].angular_velocity.z == Approx(2000).epsilon(1e-6));
  w.teleport(two, {{3, 0, 0}, from_rotation_vector({0, 0, 1})});
  REQUIRE(run(w, 1.0 / 60, 60).status == Status::ok);
  CHECK(std::abs(w.bodies[two].angular_velocity.z / w.bodies[one].angular_velocity.z) ==
        Approx(0.5).epsilon(1e-9));
}

TEST_CASE("a World with belts is a value: saved, copied and cut, it goes on") {
  Tensioned t(Solver::planar);
  run(t.w, 1.0 / 60, 30);
  World copy = t.w;
  run(t.w, 1.0 / 60, 30), run(copy, 1.0 / 60, 30);
  CHECK(state_hash(t.w) == state_hash(copy));
  copy.destroy(t.belt);
  REQUIRE(run(copy, 1.0 / 60, 30).status == Status::ok);
  CHECK(copy.belts.empty());
  t.w.destroy(t.idler);
  CHECK(t.w.belts.empty());
}
