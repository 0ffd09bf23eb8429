// Every kind of joint in motion, what acts along freedoms, limits, cables, ratios, moved frames:
// against closed forms.
#include <catch2/catch.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/exact.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81;

/// One body on a joint to the ground whose point is the origin and whose axis is `axes` x.
struct Single {
  World world;
  Entity ground, body, link;
};
Single single(Integrator integrator, JointKind kind, const Body& body, Quat axes,
              Vec3 gravity = {0, -kG, 0}) {
  Single s;
  s.world = exact_world(integrator, gravity);
  s.ground = add_ground(s.world), s.body = s.world.add_body(body);
  s.link = add_link(s.world,
                    {s.ground, s.body, joint_at(s.world, s.ground, s.body, kind, Vec3(0), axes)});
  return s;
}

StepReport run(Simulation& sim, Real time) {
  StepReport last;
  const long steps = std::lround(time / sim.settings.h);
  for (long i = 0; i < steps; ++i) {
    last = sim.step();
    if (last.status != Status::ok) return last;
  }
  return last;
}

/// How far along its axis, and how far it has turned about it.
Real slide_of(const Single& s, const World& w) {
  return coordinate_of(w, s.link, Coordinate::travel);
}
Real rotation_of(const Single& s, const World& w, Real before = 0) {
  return coordinate_of(w, s.link, Coordinate::angle, before);
}

const Vec3 kMoments{0.1, 0.2, 0.3};

}  // namespace

TEST_CASE("a block on an incline with viscous friction slides as closed form has it") {
  const Real slope = 0.5, mass = 2, c = 3;
  const Vec3 down(std::cos(slope), -std::sin(slope), 0);
  for (Integrator integrator : kAll) {
    Single s = single(integrator, JointKind::prismatic, solid(mass, kMoments), frame_along(down));
    s.world.links[s.link].joint.parameters.edit().translation.friction.viscous = c;
    const Real h = integrator == Integrator::euler ? 1e-4 : 1e-3;
    Simulation sim = Simulation::copy_of(s.world, {h});
    REQUIRE(run(sim, 1).status == Status::ok);
    const Real rate = c / mass, final = kG * std::sin(slope) / rate;
    const Real way = final * (1 - (1 - std::exp(-rate)) / rate);
    const Real miss = std::abs(slide_of(s, sim.world) - way);
    INFO(name_of(integrator) << ": " << miss);
    CHECK(miss <= (integrator == Integrator::rk4     ? 1e-12
                   : integrator == Integrator::euler ? 5e-4
                                                     : 1e-6));
    CHECK(glm::length(glm::cross(sim.world.bodies[s.body].pose.position, down)) <= 1e-12);
  }
}

TEST_CASE("a body on a cylindrical joint slides and turns by itself") {
  for (Integrator integrator : kAll) {
    Body b = solid(2, kMoments);
    b.angular_velocity = {0, 3, 0};
    Single s = single(integrator, JointKind::cylindrical, b, frame_along({0, 1, 0}));
    Simulation sim = Simulation::copy_of(s.world, {1e-3});
    REQUIRE(run(sim, 1).status == Status::ok);
    const Body& end = sim.world.bodies[s.body];
    INFO(name_of(integrator));
    CHECK(std::abs(slide_of(s, sim.world) + kG / 2) <=
          (integrator == Integrator::euler ? 6e-3 : 1e-10));
    CHECK(glm::length(end.angular_velocity - Vec3(0, 3, 0)) <= 1e-10);
    CHECK(glm::length(end.velocity + Vec3(0, kG, 0)) <= 1e-9);
  }
}

TEST_CASE("a nut falls along its screw, many turns") {
  // m y'' = -m g - f, I w' = f p; y' = p w: y'' = -g / (1 + I / (m p^2)).
  const Real pitch = 0.05, mass = 2;
  const Real fall = kG / (1 + kMoments.y / (mass * pitch * pitch));
  for (Integrator integrator : kAll) {
    Single s = single(integrator, JointKind::screw, solid(mass, kMoments), frame_along({0, 1, 0}));
    s.world.links[s.link].joint.parameters.edit().pitch = pitch;
    Simulation sim = Simulation::copy_of(s.world, {2e-3});
    Real before = 0, worst = 0;
    for (int i = 0; i < 2000; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      before = rotation_of(s, sim.world, before);
      worst = std::max(worst, std::abs(slide_of(s, sim.world) - pitch * before));
    }
    const Real miss = std::abs(slide_of(s, sim.world) + 0.5 * fall * 16);
    INFO(name_of(integrator) << ": " << miss << ", thread " << worst << ", turned " << before);
    CHECK(before < -30);
    CHECK(miss <= (integrator == Integrator::euler ? 2e-3 : 1e-9));
    CHECK(worst <= 1e-12);
  }
}

TEST_CASE("a nut that is pushed or joined by another body stays where it is on its screw") {
  Single s = single(Integrator::rk4, JointKind::screw, solid(2, kMoments), frame_along({0, 1, 0}));
  s.world.links[s.link].joint.parameters.edit().pitch = 0.05;
  Simulation sim = Simulation::copy_of(s.world, {2e-3});
  run(sim, 3);
  const auto step = [&] {
    const Real before = slide_of(s, sim.world);
    const StepReport report = sim.step();
    CHECK(report.status == Status::ok);
    return std::abs(slide_of(s, sim.world) - before);
  };
  const Real even = step();
  sim.world.bodies[s.body].restart = true;
  CHECK(step() <= 1.1 * even);
  const Entity rider = sim.world.add_body(solid(
      0.1, Vec3(0.01), {sim.world.bodies[s.body].pose.position + Vec3(0.2, 0, 0), kIdentity}));
  add_link(sim.world, {s.body, rider,
                       joint_at(sim.world, s.body, rider, JointKind::ball,
                                sim.world.bodies[s.body].pose.position)});
  CHECK(step() <= 1.1 * even);
}

TEST_CASE("a body on a planar joint keeps its plane and is free in it") {
  const Vec3 normal = glm::normalize(Vec3(1, 2, 0.5));
  for (Integrator integrator : kAll) {
    Body b = solid(2, Vec3(0.2));
    b.angular_velocity = 2.0 * normal, b.velocity = glm::cross(normal, Vec3(1, 0, 0));
    Single s = single(integrator, JointKind::planar, b, frame_along(normal));
    Simulation sim = Simulation::copy_of(s.world, {1e-3});
    REQUIRE(run(sim, 1).status == Status::ok);
    const Vec3 along = Vec3(0, -kG, 0) + kG * normal.y * normal;
    const Vec3 want = b.velocity + 0.5 * along;
    const Body& end = sim.world.bodies[s.body];
    INFO(name_of(integrator) << ": " << glm::length(end.pose.position - want));
    CHECK(glm::length(end.pose.position - want) <=
          (integrator == Integrator::euler ? 6e-3 : 1e-10));
    CHECK(std::abs(glm::dot(end.pose.position, normal)) <= 1e-12);
    CHECK(glm::length(end.angular_velocity - b.angular_velocity) <= 1e-10);
  }
}

TEST_CASE("a body at a distance swings like one on a ball joint") {
  // A solid hung at its centre from a massless bar is a pendulum of its mass alone.
  World w = exact_world(Integrator::rk4);
  const Entity ground = add_ground(w);
  const Real start = 1.2;
  const Vec3 at(std::sin(start), -std::cos(start), 0);
  const Entity bob = w.add_body(solid(2, kMoments, {1.5 * at, kIdentity}));
  Joint j;
  j.kind = JointKind::distance, j.parameters.edit().length = 1.5;
  add_link(w, {ground, bob, j});
  // ... and one on a ball joint has the length 1 + I / (m 1).
  const Entity ball = w.add_body(solid(2, Vec3(1), {at, from_rotation_vector({0, 0, start})}));
  Joint k;
  k.anchor_b = {0, 1, 0};
  add_link(w, {ground, ball, k});
  Simulation sim = Simulation::copy_of(w, {1e-3});
  REQUIRE(run(sim, 5).status == Status::ok);
  const Real miss =
      glm::length(sim.world.bodies[bob].pose.position - 1.5 * sim.world.bodies[ball].pose.position);
  INFO(miss);
  CHECK(miss <= 1e-10);
  CHECK(std::abs(glm::length(sim.world.bodies[bob].pose.position) - 1.5) <= 1e-12);
}

TEST_CASE("springs between anchors and along slides have their period") {
  const Real stiffness = 200, mass = 2, w0 = std::sqrt(stiffness / mass);
  for (Integrator integrator : kAll)
    for (const bool line : {false, true}) {
      Single s = single(integrator, line ? JointKind::spring : JointKind::prismatic,
                        solid(mass, kMoments, {{1.1, 0, 0}, kIdentity}), kIdentity, Vec3(0));
      Joint& j = s.world.links[s.link].joint;
      j.anchor_b = Vec3(0);
      j.parameters.edit().translation.spring = {stiffness, 0, 1};
      Simulation sim = Simulation::copy_of(s.world, {1e-3});
      Real worst = 0;
      for (int i = 1; i <= 2000; ++i) {
        REQUIRE(sim.step().status == Status::ok);
        worst = std::max(worst, std::abs(sim.world.bodies[s.body].pose.position.x - 1 -
                                         0.1 * std::cos(w0 * i * 1e-3)));
      }
      INFO(name_of(integrator) << (line ? " line: " : " slide: ") << worst);
      CHECK(worst <= (integrator == Integrator::rk4     ? 2e-8
                      : integrator == Integrator::euler ? 1.2e-2
                                                        : 2e-4));
    }
}

TEST_CASE("a torsion spring has its period") {
  for (Integrator integrator : kAll) {
    Body b = solid(1, kMoments);
    b.angular_velocity = {0, 0, 1};
    Single s = single(integrator, JointKind::hinge, b, frame_along({0, 0, 1}), Vec3(0));
    s.world.links[s.link].joint.parameters.edit().rotation.spring.stiffness = 30;
    Simulation sim = Simulation::copy_of(s.world, {1e-3});
    REQUIRE(run(sim, 2).status == Status::ok);
    const Real miss = std::abs(rotation_of(s, sim.world) - 0.1 * std::sin(20));
    INFO(name_of(integrator) << ": " << miss);
    CHECK(miss <= (integrator == Integrator::rk4     ? 1e-8
                   : integrator == Integrator::euler ? 1.2e-2
                                                     : 2e-4));
  }
}

TEST_CASE(
    "springs a hundred times too stiff for an explicit step are no trouble to the implicit one") {
  // Limit of explicit steps: h sqrt(k / m) = 2; here 200. A soft spring beside it sets the motion.
  const auto miss = [](Real h, Real stiffness) {
    World w = exact_world(Integrator::implicit, Vec3(0));
    const Entity ground = add_ground(w);
    const Entity a = w.add_body(solid(1, kMoments, {{0.1, 0, 0}, kIdentity}));
    const Entity b = w.add_body(solid(1, kMoments, {{0.1, 0, 0}, kIdentity}));
    Joint soft = joint_at(w, ground, a, JointKind::prismatic, Vec3(0));
    soft.anchor_b = Vec3(0), soft.parameters.edit().translation.spring.stiffness = 2;
    add_link(w, {ground, a, soft});
    Joint stiff;
    stiff.kind = JointKind::prismatic,
    stiff.parameters.edit().translation.spring.stiffness = stiffness;
    add_link(w, {a, b, stiff});
    Simulation sim = Simulation::copy_of(w, {h});
    const StepReport end = run(sim, 4);
    if (end.status != Status::ok) return Real(1e9);
    return std::abs(sim.world.bodies[b].pose.position.x - 0.1 * std::cos(4.0));
  };
  const Real coarse = miss(0.1, 4e6), fine = miss(0.05, 1.6e7);
  INFO(coarse << " " << fine << " " << coarse / fine);
  CHECK(coarse <= 1e-3);
  CHECK(coarse / fine >= 3.6);
  CHECK(coarse / fine <= 4.4);
}

TEST_CASE("motors reach what they aim at and never push harder than they may") {
  for (Integrator integrator : kAll) {
    INFO(name_of(integrator));
    Single s = single(integrator, JointKind::hinge, solid(1, kMoments), frame_along({0, 0, 1}));
    JointMotor& motor = s.world.links[s.link].joint.parameters.edit().rotation.motor;
    motor.kind = MotorKind::velocity, motor.target = 5, motor.gain = 10, motor.cap = 1.5;
    Simulation sim = Simulation::copy_of(s.world, {1e-3});
    Real hardest = 0, before = 0;
    for (int i = 0; i < 2000; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      const Real angular_velocity = sim.world.bodies[s.body].angular_velocity.z;
      hardest = std::max(hardest, std::abs(angular_velocity - before) / 1e-3 * kMoments.z);
      before = angular_velocity;
      if (i == 499)
        CHECK(std::abs(angular_velocity - 2.5) <= 1e-9);  // at full cap: 1.5 / 0.3 rad/s^2
    }
    CHECK(hardest <= 1.5 * (1 + 1e-9));
    CHECK(std::abs(before - 5) <= 1e-9);

    Single p = single(integrator, JointKind::hinge, solid(1, kMoments), frame_along({0, 0, 1}));
    JointMotor& to = p.world.links[p.link].joint.parameters.edit().rotation.motor;
    to.kind = MotorKind::position, to.target = 7, to.gain = 30, to.damping = 6, to.cap = 20;
    Simulation place = Simulation::copy_of(p.world, {1e-3});
    Real angle = 0;
    for (int i = 0; i < 4000; ++i) {
      REQUIRE(place.step().status == Status::ok);
      angle = rotation_of(p, place.world, angle);
    }
    CHECK(std::abs(angle - 7) <= 1e-9);
  }
}

TEST_CASE("dry friction holds a block that pulls less, and brakes one that pulls more") {
  for (Integrator integrator : kAll) {
    const auto way = [&](Real slope) {
      const Vec3 down(std::cos(slope), -std::sin(slope), 0);
      Single s = single(integrator, JointKind::prismatic, solid(1, kMoments), frame_along(down));
      s.world.links[s.link].joint.parameters.edit().translation.friction = {0, 3, 1e-3};
      Simulation sim = Simulation::copy_of(s.world, {1e-4});
      if (run(sim, 1).status != Status::ok) return Real(1e9);
      return slide_of(s, sim.world);
    };
    const Real held = way(0.2), slid = way(0.6);
    // It creeps: 3 tanh(v / slip) = g sin 0.2.
    const Real creep = 1e-3 * std::atanh(kG * std::sin(0.2) / 3);
    const Real free = 0.5 * (kG * std::sin(0.6) - 3);
    INFO(name_of(integrator) << ": " << held << " " << creep << ", " << slid << " " << free);
    CHECK(std::abs(held - creep) <= 2e-2 * creep);
    CHECK(std::abs(slid - free) <= 1e-3);
  }
}

TEST_CASE("a pendulum leaves its stop with the part e of its speed") {
  for (Integrator integrator : kAll)
    for (const Real e : {0.0, 0.5, 0.8}) {
      // A rod falls from level onto a stop where it hangs down.
      Body b = rod(1, 1, {{0.5, 0, 0}, kIdentity});
      Single s = single(integrator, JointKind::hinge, b, frame_along({0, 0, 1}));
      Joint& j = s.world.links[s.link].joint;
      j.limits.edit().angle = {true, -kPi / 2, kPi / 2};
      j.parameters.edit().restitution = e;
      Simulation sim = Simulation::copy_of(s.world, {2e-3});
      const auto height = [&] { return sim.world.bodies[s.body].pose.position.y + 0.5; };
      std::vector<Real> peaks;
      Real last = height(), best = 0, deepest = 0;
      bool down = true;
      int events = 0;
      StepReport report;
      for (int i = 0; i < 3000; ++i) {
        report = sim.step();
        REQUIRE(report.status == Status::ok);
        events += report.events;
        const Real now = height();
        if (down && now > last) down = false, best = 0;
        best = std::max(best, now);
        if (!down && now < last) peaks.push_back(best), down = true;
        last = now;
        deepest = std::max(deepest, -kPi / 2 - rotation_of(s, sim.world));
      }
      INFO(name_of(integrator) << ", e = " << e << ": " << peaks.size() << " peaks, " << events
                               << " blows, deepest " << deepest);
      CHECK(deepest <= 2e-9);
      if (e == 0) {
        CHECK(std::abs(rotation_of(s, sim.world) + kPi / 2) <= 1e-8);
        CHECK(glm::length(sim.world.bodies[s.body].angular_velocity) <= 1e-10);
        continue;
      }
      REQUIRE(peaks.size() >= 2);
      const Real slack = integrator == Integrator::euler ? 0.02 : 2e-3;
      CHECK(std::abs(peaks[0] / (0.5 * e * e) - 1) <= slack);
      CHECK(std::abs(peaks[1] / (0.5 * e * e * e * e) - 1) <= 2 * slack);
    }
}

TEST_CASE("what turns and slides has stops for its turn") {
  for (JointKind kind : {JointKind::cylindrical, JointKind::screw, JointKind::planar}) {
    CAPTURE(name_of(kind));
    Body b = solid(1, kMoments);
    b.angular_velocity = {2, 0, 0};
    if (kind == JointKind::screw) b.velocity = {0.2, 0, 0};
    Single s = single(Integrator::rk4, kind, b, kIdentity, Vec3(0));
    Joint& joint = s.world.links[s.link].joint;
    joint.limits.edit().angle = {true, -1, 2.5};
    joint.parameters.edit().restitution = 1;
    joint.parameters.edit().pitch = 0.1;
    Simulation sim = Simulation::copy_of(s.world, {1e-2});
    for (int i = 0; i < 500; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      const Real angle = rotation_of(s, sim.world);
      REQUIRE(angle >= -1 - 2e-9);
      REQUIRE(angle <= 2.5 + 2e-9);
    }
    // 10 rad on a way of 3.5 rad there and 3.5 rad back.
    CHECK(rotation_of(s, sim.world) == Approx(2.5 - (10 - 2.5 - 2 * 3.5)).margin(1e-7).epsilon(0));
    CHECK(std::abs(sim.world.bodies[s.body].angular_velocity.x) == Approx(2).epsilon(1e-12));
  }
}

TEST_CASE("a slide between two stops goes to and fro without loss") {
  for (Integrator integrator : kAll) {
    Body b = solid(1, kMoments);
    b.velocity = {1, 0, 0};
    Single s = single(integrator, JointKind::prismatic, b, kIdentity, Vec3(0));
    JointParameters& parameters = s.world.links[s.link].joint.parameters.edit();
    parameters.travel = {true, -0.25, 0.5}, parameters.restitution = 1;
    Simulation sim = Simulation::copy_of(s.world, {1e-2});
    for (int i = 0; i < 1000; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      const Real x = slide_of(s, sim.world);
      REQUIRE(x >= -0.25 - 2e-9);
      REQUIRE(x <= 0.5 + 2e-9);
    }
    // 10 m on a way of 0.75 m there and 0.75 m back.
    const Real phase = std::fmod(10 - 0.5, 1.5);  // after the upper stop
    const Real x = phase < 0.75 ? 0.5 - phase : -0.25 + (phase - 0.75);
    INFO(name_of(integrator) << ": " << slide_of(s, sim.world) - x);
    CHECK(std::abs(slide_of(s, sim.world) - x) <= 1e-7);
    CHECK(std::abs(std::abs(sim.world.bodies[s.body].velocity.x) - 1) <= 1e-12);
  }
}
