// Joints that do more than hold a point: hinges, stops, soft zones and drives in motion.
#include <catch2/catch.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/chains.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// Joint axes whose x is the body's z: planar hinges.
const Quat kTurnedUp = from_rotation_vector({0, -kPi / 2, 0});
/// ... whose x runs down a link of chain(): cones about the limb.
const Quat kAlong = from_rotation_vector({0, 0, -kPi / 2});

World jointed_chain(const ChainSpec& spec, JointKind kind, const JointLimits& limits = {}) {
  World w = chain(spec);
  for (std::size_t i = 0; i < w.links.size(); ++i) {
    Joint& j = w.links.values()[i].joint;
    if (kind != JointKind::ball) j.kind = kind, j.frames.set(kTurnedUp, kTurnedUp);
    if (i == 0 || !limits.any()) continue;
    j.limits = limits;
    if (kind == JointKind::ball) j.frames.set(kAlong, kAlong);
  }
  w.mark_dirty();
  return w;
}

Real angle_of(const World& w, const Link& l) {
  return swing_twist(
             relative_rotation(l.joint, w.bodies[l.a].pose.rotation, w.bodies[l.b].pose.rotation))
      .twist;
}

Vec3 tip_of(const World& w, Real half) {
  const Body& b = w.bodies.values()[w.bodies.size() - 1];
  return to_world(b.pose, Vec3(0, -half, 0));
}

/// The energy a hanging chain has least, J.
Real lowest(const ChainSpec& s) {
  const Real l = s.length / s.links;
  Real sum = 0;
  for (int i = 0; i < s.links; ++i) sum -= 9.81 * s.mass * (i + 0.5) * l;
  return sum;
}

}  // namespace

TEST_CASE("in a plane a chain of hinges moves like one of ball joints") {
  ChainSpec spec;
  JointLimits far;  // never reached, nor its soft zone: the two are solved by one method
  far.swing.on = true, far.swing.y = far.swing.z = 3, far.soft_zone = 1e-3;
  Simulation ball(jointed_chain(spec, JointKind::ball, far), {1.0 / 240});
  Simulation hinge(jointed_chain(spec, JointKind::hinge), {1.0 / 240});
  Real worst = 0;
  for (int i = 0; i < 960; ++i) {
    ball.step(), hinge.step();
    worst = std::max(worst, glm::length(tip_of(ball.world, 0.05) - tip_of(hinge.world, 0.05)));
  }
  CHECK(worst <= 1e-6);
  CHECK(measure(hinge.world).worst_violation <= 1e-14);
}

TEST_CASE("hinges hold what would turn them another way, momentum kept") {
  Random dice(21);
  World w;
  w.gravity = Vec3(0);
  Entity before;
  for (int i = 0; i < 5; ++i) {
    Body b;
    b.drag = 0, b.inertia = {0.1, 0.05, 0.12};
    b.pose = {Vec3(i, 0, 0), kIdentity};
    b.angular_velocity = dice.in_cube(2), b.velocity = dice.in_cube(1);
    const Entity e = w.add_body(b);
    if (before) {
      Joint j;
      j.anchor_a = {0.5, 0, 0}, j.anchor_b = {-0.5, 0, 0};
      constexpr JointKind kKinds[] = {JointKind::ball, JointKind::hinge, JointKind::universal,
                                      JointKind::fixed};
      j.kind = kKinds[i % 4];
      const Quat axes = dice.rotation();
      j.frames.set(axes, axes);
      add_link(w, {before, e, j});
    }
    before = e;
  }
  Simulation sim = Simulation::copy_of(w, {1.0 / 240});
  // The given velocities suit no joint: the first step makes them suit, and keeps their momentum.
  const Measures start = measure(sim.world);
  for (int i = 0; i < 480; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    const Measures m = measure(sim.world);
    REQUIRE(m.worst_gap_rel <= 1e-14);
    REQUIRE(m.worst_violation <= 1e-13);
  }
  const Measures end = measure(sim.world);
  CHECK(glm::length(end.momentum - start.momentum) <= 1e-10);
}

TEST_CASE("two rods fixed together swing like one") {
  const auto error = [](Real h) {
    ChainSpec two, one;
    two.links = 2, one.links = 1, two.mass = 0.5;
    World w = chain(two);
    w.links.values()[1].joint.kind = JointKind::fixed;
    w.mark_dirty();
    World alone = chain(one);
    Simulation pair = Simulation::copy_of(w, {h}), rod = Simulation::copy_of(alone, {h});
    Real worst = 0;
    for (int i = 0; i < std::lround(4 / h); ++i) {
      pair.step(), rod.step();
      worst = std::max(worst, glm::length(tip_of(pair.world, 0.25) - tip_of(rod.world, 0.5)));
    }
    return worst;
  };
  const Real coarse = error(1.0 / 60), middle = error(1.0 / 240), fine = error(1.0 / 960);
  // One method, whose iterations alone tell them apart.
  CHECK(coarse <= 1e-7);
  CHECK(middle <= 1e-10);
  CHECK(fine <= 1e-10);
}

TEST_CASE("a blow against a stop is inelastic: both sides take it, as closed form has it") {
  // Two free rods in a row; the second spins about the hinge until it strikes the stop.
  const auto after = [](Real h) {
    World w;
    w.gravity = Vec3(0);
    Body rod;
    rod.drag = 0, rod.inertia = {0.001, 1.0 / 12, 1.0 / 12};
    rod.pose.position = {-0.5, 0, 0};
    const Entity a = w.add_body(rod);
    rod.pose.position = {0.5, 0, 0};
    rod.angular_velocity = {0, 0, 1};
    const Entity b = w.add_body(rod);
    w.bodies[a].angular_velocity = {0, 0, -1};
    Joint j;
    j.anchor_a = {0.5, 0, 0}, j.anchor_b = {-0.5, 0, 0}, j.kind = JointKind::hinge;
    j.frames.set(kTurnedUp, kTurnedUp);
    JointLimits limits;
    limits.angle = {true, -0.3, 0.3};
    j.limits = limits;
    add_link(w, {a, b, j});
    // Both turn towards one another: the whole has no angular momentum, so all motion ends.
    Simulation sim = Simulation::copy_of(w, {h});
    const Measures start = measure(sim.world);
    for (int i = 0; i < std::lround(1 / h); ++i) sim.step();
    const Measures end = measure(sim.world);
    CHECK(start.kinetic == Approx(1.0 / 12));
    CHECK(glm::length(end.momentum - start.momentum) <= 1e-12);
    CHECK(glm::length(end.angular_momentum - start.angular_momentum) <= 1e-12);
    CHECK(angle_of(sim.world, sim.world.links.values()[0]) == Approx(0.3).margin(1e-12));
    return end.kinetic;
  };
  for (Real h : {1.0 / 60, 1.0 / 240}) CHECK(after(h) <= 1e-12);
}

TEST_CASE("chains within cones: no violation, no gap, no energy gained, in all 54 runs",
          "[limits]") {
  // Released at 60 degrees; with the drag the swing has decayed within 10 s, stops or no stops.
  for (Real cone : {10.0, 20.0, 45.0})
    for (int links : {5, 10, 20})
      for (Real rate : {60.0, 240.0}) {
        INFO("cone " << cone << ", " << links << " links, " << rate << " Hz");
        ChainSpec spec;
        spec.links = links, spec.angle = kPi / 3, spec.mass = 1.0 / links;
        JointLimits limits;
        limits.swing = {true, cone * kPi / 180, cone * kPi / 180};
        limits.angle = {true, -0.1, 0.1};
        World w = jointed_chain(spec, JointKind::ball, limits);
        for (Body& b : w.bodies.values()) b.drag = 1;
        w.mark_dirty();
        Simulation sim = Simulation::copy_of(w, {1 / rate});
        const Real start = measure(w).energy(), swing = start - lowest(spec);
        Real violation = 0, gap = 0, most = start;
        for (int i = 0; i < 10 * rate; ++i) {
          REQUIRE(sim.step().status == Status::ok);
          const Measures m = measure(sim.world);
          violation = std::max(violation, m.worst_violation);
          gap = std::max(gap, m.worst_gap_rel), most = std::max(most, m.energy());
        }
        CHECK(violation <= 1e-12);
        CHECK(gap <= 1e-14);
        CHECK(most <= start + 0.02 * swing);
        CHECK(measure(sim.world).energy() - lowest(spec) <= 1e-3 * swing);  // at rest
      }
}

TEST_CASE("a cone of zero, or next to zero, is a hinge about the limb") {
  for (const Real cone : {0.0, 1e-5, 1e-3}) {
    CAPTURE(cone);
    JointLimits narrow;
    narrow.swing = {true, cone, cone};
    const ChainSpec spec{.links = 4, .angle = kPi / 3};
    World cones = jointed_chain(spec, JointKind::ball, narrow), hinges = cones;
    for (std::size_t i = 1; i < hinges.links.size(); ++i) {
      Joint& j = hinges.links.values()[i].joint;
      j.kind = JointKind::hinge, j.limits = JointLimits{};
    }
    hinges.mark_dirty();
    Simulation a = Simulation::copy_of(cones, {1.0 / 60}),
               b = Simulation::copy_of(hinges, {1.0 / 60});
    const Real first = measure(a.world).energy();
    for (int i = 0; i < 240; ++i) {
      REQUIRE(a.step().status == Status::ok);
      b.step();
      CHECK(measure(a.world).energy() <= first + 1e-6 * std::abs(first));
    }
    for (std::size_t i = 0; i < cones.bodies.size(); ++i)
      CHECK(glm::length(a.world.bodies.values()[i].pose.position -
                        b.world.bodies.values()[i].pose.position) < 1e-9);
  }
}

TEST_CASE("a cantilever falls into its stops and is still within 10 s") {
  // Held level by a fixed joint; every joint may bend by 4 degrees, so that all lie at their stops.
  ChainSpec spec;
  spec.angle = kPi / 2, spec.mass = 0.1;
  JointLimits limits;
  limits.angle = {true, -4 * kPi / 180, 4 * kPi / 180};
  World w = jointed_chain(spec, JointKind::hinge, limits);
  Joint& wall = w.links.values()[0].joint;
  wall.kind = JointKind::fixed;
  wall.frames.set(from_rotation_vector({0, 0, spec.angle}), kIdentity);
  w.mark_dirty();
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  StepReport last;
  for (int i = 0; i < 600; ++i) last = sim.step();
  CHECK(measure(sim.world).kinetic <= 1e-12);
  CHECK(last.stops_hit == 9);
  for (std::size_t i = 1; i < sim.world.links.size(); ++i)
    CHECK(std::abs(angle_of(sim.world, sim.world.links.values()[i])) ==
          Approx(4 * kPi / 180).margin(1e-12));
}

TEST_CASE("the clamp of the sweep keeps to limits too") {
  ChainSpec spec;
  JointLimits limits;
  limits.swing = {true, 0.2, 0.2}, limits.angle = {true, -0.1, 0.1};
  World w = jointed_chain(spec, JointKind::ball, limits);
  w.default_settings.solver = Solver::sweep;
  const Entity hand = w.add_pin({w.bodies.owners()[10], {0, -0.05, 0}, {0.3, -0.4, 0.3}});
  w.mark_dirty();
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  for (int i = 0; i < 60; ++i) {
    sim.world.pins[hand].target = {0.5 * std::sin(0.2 * i), -0.4, 0.4 * std::cos(0.3 * i)};
    REQUIRE(sim.step().status == Status::ok);
    REQUIRE(measure(sim.world).worst_violation <= 1e-12);
    REQUIRE(measure(sim.world).worst_gap_rel <= 1e-13);
  }
}

TEST_CASE("a soft zone brakes before the stop") {
  const auto first_blow = [](Real stiffness) {
    ChainSpec spec;
    spec.links = 1, spec.angle = 1.0;
    World w = chain(spec);
    Joint& j = w.links.values()[0].joint;
    j.kind = JointKind::hinge;
    j.frames.set(kTurnedUp, kTurnedUp);
    JointLimits limits;
    limits.angle = {true, -0.2, 2};
    limits.soft_zone = 0.5, limits.soft_stiffness = stiffness,
    limits.soft_damping = 0.1 * stiffness;
    j.limits = limits;
    w.mark_dirty();
    Simulation sim = Simulation::copy_of(w, {1.0 / 240});
    Real fastest = 0;
    for (int i = 0; i < 480; ++i) {
      const Real before = glm::length(sim.world.bodies.values()[1].angular_velocity);
      sim.step();
      if (measure(sim.world).worst_violation > 1e-12) return -1.0;
      fastest =
          std::max(fastest, before - glm::length(sim.world.bodies.values()[1].angular_velocity));
    }
    return fastest;
  };
  const Real hard = first_blow(0), soft = first_blow(20);
  CHECK(hard > 2);  // all its spin in one step
  CHECK(soft >= 0);
  CHECK(soft < 0.3 * hard);
}

TEST_CASE("a drive holds a rod level against its weight, and no harder than it may") {
  ChainSpec spec;
  spec.links = 1, spec.angle = kPi / 2;
  World w = chain(spec);
  const Entity link = w.links.owners()[0];
  w.links[link].joint.kind = JointKind::hinge;
  w.links[link].joint.frames.set(kTurnedUp, kTurnedUp);
  JointDrive drive;
  drive.target = from_rotation_vector({kPi / 2, 0, 0}), drive.stiffness = 50, drive.damping = 5;
  w.joint_drives.add(link, drive);
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  for (int i = 0; i < 600; ++i) sim.step();
  const Real angle = angle_of(sim.world, sim.world.links[link]);
  const Real weight = 9.81 * 0.5 * std::sin(angle);
  CHECK(50 * (kPi / 2 - angle) == Approx(weight).margin(1e-9));
  CHECK(sim.world.joint_drives[link].torque == Approx(weight).margin(1e-9));
  CHECK(measure(sim.world).kinetic <= 1e-20);

  // With less torque than the weight asks for it sinks to where the weight's lever is short enough.
  sim.world.joint_drives[link].max_torque = 3;
  sim.world.bodies.values()[1].drag = 4;
  sim.world.mark_dirty();
  Real most = 0;
  for (int i = 0; i < 3000; ++i) {
    sim.step();
    if (i > 0) most = std::max(most, sim.world.joint_drives[link].torque);
  }
  CHECK(most <= 3 * 1.001);
  CHECK(9.81 * 0.5 * std::sin(angle_of(sim.world, sim.world.links[link])) ==
        Approx(3).epsilon(0.01));
}

TEST_CASE("a drive follows its keys, and any stiffness is stable") {
  ChainSpec spec;
  spec.links = 1, spec.angle = 0;
  for (Real stiffness : {1e2, 1e5, 1e9}) {
    World w = chain(spec);
    const Entity link = w.links.owners()[0];
    w.links[link].joint.kind = JointKind::hinge;
    w.links[link].joint.frames.set(kTurnedUp, kTurnedUp);
    JointDrive drive;
    drive.stiffness = stiffness, drive.damping = 0.1 * stiffness;
    for (int k = 0; k <= 8; ++k)
      drive.keys.push_back({0.5 * k, from_rotation_vector({0.8 * std::sin(kPi / 4 * k), 0, 0})});
    drive.loop = true;
    w.joint_drives.add(link, drive);
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    Real worst = 0;
    for (int i = 0; i < 600; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      const Real wanted = swing_twist(target_at(drive, sim.world.time)).twist;
      if (i > 60)
        worst = std::max(worst, std::abs(angle_of(sim.world, sim.world.links[link]) - wanted));
    }
    INFO(stiffness);
    CHECK(worst <= (stiffness > 1e4 ? 2e-3 : 0.1));
  }
}

TEST_CASE("copies of a world with stops and drives go the same way, bit for bit") {
  ChainSpec spec;
  JointLimits limits;
  limits.swing = {true, 0.15, 0.3}, limits.angle = {true, -0.1, 0.1};
  World w = jointed_chain(spec, JointKind::ball, limits);
  JointDrive drive;
  drive.stiffness = 5, drive.damping = 1, drive.max_torque = 0.3;
  w.joint_drives.add(w.links.owners()[3], drive);
  Simulation one = Simulation::copy_of(w, {1.0 / 60});
  for (int i = 0; i < 100; ++i) one.step();
  Simulation other = Simulation::copy_of(one.world, {1.0 / 60});
  for (int i = 0; i < 100; ++i) one.step(), other.step();
  CHECK(state_hash(one.world) == state_hash(other.world));
}
