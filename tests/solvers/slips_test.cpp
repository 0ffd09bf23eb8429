// Skates and wheels, rows that constrain velocities only: against closed forms.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

#include "engine/world/surface_start.hpp"
#include "tests/solvers/sleighs.hpp"
#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

void run(Simulation& sim, Real time) {
  const int steps = static_cast<int>(std::lround(time / sim.settings.h));
  for (int i = 0; i < steps; ++i) REQUIRE(sim.step().status == Status::ok);
}

Real heading_of(const Body& b) {
  const Vec3 x = b.pose.rotation * Vec3(1, 0, 0);
  return std::atan2(-x.z, x.x);  // about +y
}

/// Chaplygin's sleigh: forward speed, yaw rate, heading and place at a time, from speed u0 and yaw
/// rate w0. With J = I + m a^2, c^2 = J / m and V^2 = u^2 + c^2 w^2 (energy):
///
///   u = V tanh(s),  c w = V / cosh(s),  heading = (c / a) (gd(s) - gd(s_0)),  s = a V t / c^2 +
///   s_0
struct Chaplygin {
  Real behind, u0, w0;
  Real c() const { return std::sqrt((kInertia + kMass * behind * behind) / kMass); }
  Real energy_speed() const { return std::hypot(u0, c() * w0); }
  Real s_at(Real t) const {
    return std::atanh(u0 / energy_speed()) + behind * energy_speed() / (c() * c()) * t;
  }
  Real speed(Real t) const { return energy_speed() * std::tanh(s_at(t)); }
  Real rate(Real t) const { return energy_speed() / std::cosh(s_at(t)) / c(); }
  Real heading(Real t) const {
    const auto gd = [](Real s) { return 2 * std::atan(std::tanh(s / 2)); };
    return c() / behind * (gd(s_at(t)) - gd(s_at(0)));
  }
  /// Of the mass centre: its velocity u along the heading and a w across, by Simpson's rule.
  Vec3 place(Real t) const {
    const int n = 4000;
    Vec3 sum(0);
    for (int i = 0; i <= n; ++i) {
      const Real at = t * i / n, angle = heading(at);
      const Vec3 ahead(std::cos(angle), 0, -std::sin(angle)), aside(glm::cross(kUp, ahead));
      const Real weight = i == 0 || i == n ? 1 : i % 2 == 1 ? 4 : 2;
      sum += weight * (speed(at) * ahead + behind * rate(at) * aside);
    }
    return t / (3 * n) * sum;
  }
};

/// How far the sleigh is from its closed form after 2 s.
Real error_of_sleigh(Integrator integrator, Real h) {
  const Chaplygin exact{0.4, -0.5, 3};
  Sleigh s = sleigh(integrator, exact.behind);
  Body& start = s.world.bodies[s.body];
  start.velocity = {exact.u0, 0, -exact.behind * exact.w0};
  start.angular_velocity = exact.w0 * kUp;
  Simulation sim(std::move(s.world), {h});
  run(sim, 2);
  const Body& b = sim.world.bodies[s.body];
  const Real turn = std::remainder(heading_of(b) - exact.heading(2), 2 * kPi);
  const Vec3 ahead = b.pose.rotation * Vec3(1, 0, 0);
  return std::max({glm::distance(b.pose.position, exact.place(2)), std::abs(turn),
                   std::abs(glm::dot(b.velocity, ahead) - exact.speed(2)),
                   std::abs(b.angular_velocity.y - exact.rate(2))});
}

}  // namespace

TEST_CASE("slips: Chaplygin's sleigh follows its closed form at the integrator's order") {
  struct Case {
    Integrator integrator;
    Real order, coarse, fine, bound;
  };
  for (const auto& [integrator, order, coarse, fine, bound] :
       {Case{Integrator::euler, 1, 0.002, 0.001, 2e-2},
        Case{Integrator::rattle, 2, 0.005, 0.0025, 1e-4},
        Case{Integrator::implicit, 2, 0.005, 0.0025, 1e-4},
        Case{Integrator::rk4, 4, 0.02, 0.01, 1e-7}}) {
    const Real at_coarse = error_of_sleigh(integrator, coarse),
               at_fine = error_of_sleigh(integrator, fine);
    INFO(name_of(integrator) << ": " << at_coarse << ", " << at_fine);
    CHECK(at_fine <= bound);
    CHECK(std::log2(at_coarse / at_fine) == Approx(order).margin(0.25));
  }
  const Real radau = error_of_sleigh(Integrator::radau, 0.02);
  INFO("radau: " << radau);
  CHECK(radau <= 1e-8);
}

TEST_CASE("slips: a sleigh keeps its energy, never slips, and ends on a straight line") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    const Real behind = 0.4;
    Sleigh s = sleigh(integrator, behind);
    Body& start = s.world.bodies[s.body];
    start.velocity = {-1, 0, -behind * 2}, start.angular_velocity = 2.0 * kUp;
    const Entity body = s.body;
    Simulation sim(std::move(s.world), {0.01});
    const auto energy = [&] {
      const Body& b = sim.world.bodies[body];
      return kMass / 2 * glm::dot(b.velocity, b.velocity) +
             kInertia / 2 * glm::dot(b.angular_velocity, b.angular_velocity);
    };
    const Real before = energy();
    for (int i = 0; i < 1500; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      REQUIRE(std::abs(sideways_at_blade(sim.world, body, behind)) <= 1e-12);
    }
    const bool first = integrator == Integrator::euler;
    CHECK(energy() <= before * (1 + 1e-4));
    CHECK(energy() == Approx(before).epsilon(first ? 0.05 : 1e-4));
    const Body& b = sim.world.bodies[body];
    CHECK(std::abs(b.angular_velocity.y) <= 1e-5);
    CHECK(glm::dot(b.velocity, b.pose.rotation * Vec3(1, 0, 0)) > 0.99 * std::sqrt(before));
    CHECK(std::abs(b.pose.position.y) <= 1e-12);
  }
}

TEST_CASE("slips: a sleigh with its blade at the mass centre draws a cycloid on an incline") {
  // Level along x, g' along -x within the plane: x = -g' sin(wt)^2 / (2 w^2), and
  // sideways g' (wt - sin(2wt) / 2) / (2 w^2).
  constexpr Real kPull = 4, kRate = 3, kTime = 1.5;
  for (const Integrator integrator : kAll) {
    Sleigh s = sleigh(integrator, 0, {-kPull, 0, 0});
    s.world.bodies[s.body].angular_velocity = kRate * kUp;
    Simulation sim(std::move(s.world), {0.005});
    run(sim, kTime);
    const Body& b = sim.world.bodies[s.body];
    const Real wt = kRate * kTime, scale = kPull / (2 * kRate * kRate);
    const Vec3 place(-scale * std::pow(std::sin(wt), 2), 0, scale * (wt - std::sin(2 * wt) / 2));
    INFO(name_of(integrator) << ": " << glm::distance(b.pose.position, place));
    const Real tolerance = integrator == Integrator::euler   ? 2e-2
                           : integrator == Integrator::rk4   ? 1e-8
                           : integrator == Integrator::radau ? 1e-10
                                                             : 1e-4;
    CHECK(glm::distance(b.pose.position, place) <= tolerance);
    CHECK(b.angular_velocity.y == Approx(kRate).epsilon(1e-12));
  }
}

TEST_CASE("slips: a blade between two free bodies keeps their momenta") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    World w = exact_world(integrator, Vec3(0));
    const Entity a = w.add_body(solid(3, {0.2, 0.4, 0.5}));
    const Entity b = w.add_body(solid(1, {0.1, 0.05, 0.08}, {{0.5, 0.3, 0}, kIdentity}));
    add_link(w,
             {a, b, joint_at(w, a, b, JointKind::skate, {0.8, 0.2, 0.1}, frame_along({1, 2, 2}))});
    w.bodies[a].angular_velocity = {0.3, -0.5, 0.4}, w.bodies[b].velocity = {0.2, 0.1, -0.4};
    w.bodies[b].angular_velocity = {-0.6, 0.2, 0.9};
    const auto momenta = [&](const World& of) {
      std::pair<Vec3, Vec3> sum{Vec3(0), Vec3(0)};
      for (const Body& body : of.bodies.values()) {
        const Mat3 r = glm::mat3_cast(body.pose.rotation);
        const Vec3 spin = r * (body.inertia * (glm::transpose(r) * body.angular_velocity));
        sum.first += body.mass * body.velocity;
        sum.second += spin + body.mass * glm::cross(body.pose.position, body.velocity);
      }
      return sum;
    };
    Simulation sim(std::move(w), {0.005});
    REQUIRE(sim.step().status == Status::ok);  // closes the start
    const auto before = momenta(sim.world);
    run(sim, 1);
    const auto now = momenta(sim.world);
    CHECK(glm::distance(now.first, before.first) <= 1e-12);
    const Real turned = integrator == Integrator::rattle  ? 1e-4
                        : integrator == Integrator::euler ? 2e-2
                                                          : 1e-5;
    CHECK(glm::distance(now.second, before.second) <= turned);
  }
}

TEST_CASE("slips: a blade slides against its grip until it holds") {
  // Thrown at (u, s) with the blade along x: s falls at grip / m, u stays.
  constexpr Real kGrip = 5, kAhead = 1.5, kAside = 2;
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    Sleigh s = sleigh(integrator, 0);
    s.world.links[s.skate].joint.parameters.edit().grip = kGrip;
    s.world.bodies[s.body].velocity = {kAhead, 0, kAside};
    Simulation sim(std::move(s.world), {0.01});
    run(sim, 0.5);
    const Body& b = sim.world.bodies[s.body];
    CHECK(b.velocity.z == Approx(kAside - kGrip / kMass * 0.5).epsilon(1e-9));
    run(sim, 0.5);
    CHECK(std::abs(b.velocity.z) <= 1e-12);
    CHECK(b.velocity.x == Approx(kAhead).epsilon(1e-12));
    CHECK(b.pose.position.x == Approx(kAhead).epsilon(1e-9));
    const Real way = kAside * kAside * kMass / (2 * kGrip);
    CHECK(b.pose.position.z == Approx(way).epsilon(integrator == Integrator::euler ? 2e-2 : 1e-7));
  }
}

TEST_CASE("slips: a blade gives way when the side force exceeds its grip, and not before") {
  // The cycloid needs the side force 2 m g' sin(wt).
  constexpr Real kPull = 4, kRate = 1, kGrip = 8;
  const Real gives = std::asin(kGrip / (2 * kMass * kPull)) / kRate;  // 0.5236 s
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    Sleigh s = sleigh(integrator, 0, {-kPull, 0, 0});
    s.world.links[s.skate].joint.parameters.edit().grip = kGrip;
    s.world.bodies[s.body].angular_velocity = kRate * kUp;
    Simulation sim(std::move(s.world), {0.01});
    Real slid = 0;
    for (int i = 0; i < 80 && slid == 0; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      if (std::abs(sideways_at_blade(sim.world, s.body, 0)) > 1e-9) slid = sim.world.time;
      // Not more than the grip, nor in the step in which it gives way.
      const auto reaction = joint_reaction(sim.world, s.skate);
      REQUIRE(reaction);
      CHECK(glm::length(reaction->force) <= kGrip * (1 + 1e-9));
    }
    CHECK(slid >= gives);
    CHECK(slid <= gives + 0.02);
    REQUIRE(sim.step().status == Status::ok);  // slides all through
    const auto reaction = joint_reaction(sim.world, s.skate);
    REQUIRE(reaction);
    CHECK(glm::length(reaction->force) == Approx(kGrip).epsilon(1e-9));
  }
}

namespace {

/// A cart in the plane xz on two wheels beside its mass centre: a frame, and its wheels in hinges.
struct Cart {
  World world;
  Entity frame, left, right;
};
constexpr Real kRadius = 0.2, kTrack = 0.6;
Cart cart(Integrator integrator) {
  Cart s{exact_world(integrator), {}, {}, {}};
  World& w = s.world;
  const Entity ground = add_ground(w);
  s.frame = w.add_body(solid(4, {0.2, 0.3, 0.2}, {{0, kRadius, 0}, kIdentity}));
  add_link(w, {ground, s.frame,
               joint_at(w, ground, s.frame, JointKind::planar, {0, kRadius, 0}, frame_along(kUp))});
  const auto wheel = [&](Real z) {
    const Vec3 hub(0, kRadius, z);
    const Entity e = w.add_body(solid(0.5, {0.005, 0.005, 0.01}, {hub, kIdentity}));
    add_link(w,
             {s.frame, e, joint_at(w, s.frame, e, JointKind::hinge, hub, frame_along({0, 0, 1}))});
    Joint rolls = joint_at(w, ground, e, JointKind::wheel, hub, frame_along({0, 0, 1}));
    rolls.parameters.edit().length = kRadius;
    add_link(w, {ground, e, rolls});
    return e;
  };
  s.left = wheel(-kTrack / 2), s.right = wheel(kTrack / 2);
  return s;
}

/// How far the cart is from its circle after 2 s.
Real error_of_cart(Integrator integrator, Real h) {
  constexpr Real kSpeed = 1, kTurn = 0.8, kTime = 2;
  Cart s = cart(integrator);
  for (const Entity e : {s.frame, s.left, s.right}) {
    Body& b = s.world.bodies[e];
    b.velocity = Vec3(kSpeed, 0, 0) + glm::cross(kTurn * kUp, b.pose.position);
    b.angular_velocity = kTurn * kUp;
    if (e != s.frame) b.angular_velocity.z = -b.velocity.x / kRadius;
  }
  Simulation sim(std::move(s.world), {h});
  run(sim, kTime);
  for (const Entity e : {s.left, s.right}) {
    const Body& wheel = sim.world.bodies[e];
    const Vec3 bottom = wheel.velocity + glm::cross(wheel.angular_velocity, -kRadius * kUp);
    CHECK(glm::length(bottom) <= 1e-8);
  }
  const Body& b = sim.world.bodies[s.frame];
  const Real turned = kTurn * kTime, radius = kSpeed / kTurn;
  const Vec3 place(radius * std::sin(turned), kRadius, radius * (std::cos(turned) - 1));
  return std::max(glm::distance(b.pose.position, place), std::abs(heading_of(b) - turned));
}

}  // namespace

TEST_CASE("slips: a cart on two wheels runs on a circle, its wheels at the speeds of the track") {
  for (const Integrator integrator : kAll) {
    const Real coarse = error_of_cart(integrator, 0.01), fine = error_of_cart(integrator, 0.005);
    INFO(name_of(integrator) << ": " << coarse << ", " << fine);
    CHECK(fine <= (integrator == Integrator::euler ? 1e-2 : 1e-3));
    CHECK((fine <= 1e-9 || coarse / fine > 1.7));
    if (integrator != Integrator::euler) CHECK((fine <= 1e-9 || coarse / fine > 3.4));
  }
}

TEST_CASE("slips: beyond the coefficient of friction times its load a blade or a cart slides") {
  constexpr Real kFriction = 0.5, kWeight = 9.81, kTime = 0.5;
  for (const Integrator integrator : kAll)
    for (const Real side : {0.49, 0.51})  // of the weight
      for (const bool on_wheels : {false, true}) {
        INFO(name_of(integrator) << ", side force " << side << (on_wheels ? ", cart" : ", blade"));
        const Vec3 gravity = kWeight * Vec3(0, -1, side);
        Entity body;
        World w;
        if (on_wheels) {
          Cart s = cart(integrator);
          s.world.gravity = gravity;
          for (Link& l : s.world.links.values())
            if (l.joint.kind == JointKind::wheel) l.joint.parameters.edit().friction = kFriction;
          w = std::move(s.world), body = s.frame;
        } else {
          Sleigh s = loaded_sleigh(integrator, gravity, kFriction);
          w = std::move(s.world), body = s.body;
        }
        Simulation sim(std::move(w), {0.01});
        run(sim, kTime);
        const Real exact = side > kFriction ? (side - kFriction) * kWeight * kTime : 0;
        CHECK(sim.world.bodies[body].velocity.z == Approx(exact).margin(1e-9));
      }
}

TEST_CASE("slips: a blade begins to slide when the table that carries it falls away fast enough") {
  // The load is m (g - A w^2 sin wt); it slides once mu times that is less than m g'.
  constexpr Real kG = 10, kSide = 3.5, kFriction = 0.5, kA = 1, kRate = 2, kTime = 0.7;
  const Real gives = std::asin((kG - kSide / kFriction) / (kA * kRate * kRate)) / kRate;
  const Real exact = (kSide - kFriction * kG) * (kTime - gives) +
                     kFriction * kA * kRate * (std::cos(kRate * gives) - std::cos(kRate * kTime));
  const auto error = [&](Integrator integrator, Real h) {
    Sleigh s = loaded_sleigh(integrator, {0, -kG, kSide}, kFriction);
    Lissajous path;
    path.amplitude = {0, kA, 0}, path.frequency = {0, kRate / (2 * kPi), 0};
    s.world.bodies[s.ground].motion = Motion::kinematic;
    s.world.paths.add(s.ground, {path});
    s.world.bodies[s.body].velocity = {0, kA * kRate, 0};
    Simulation sim(std::move(s.world), {h});
    run(sim, gives - 2 * h);
    CHECK(std::abs(sim.world.bodies[s.body].velocity.z) <= 1e-9);
    run(sim, kTime - sim.world.time);
    return std::abs(sim.world.bodies[s.body].velocity.z - exact);
  };
  for (const Integrator integrator : kAll) {
    const Real coarse = error(integrator, 0.01), fine = error(integrator, 0.0025);
    INFO(name_of(integrator) << ": " << coarse << ", " << fine);
    if (integrator != Integrator::implicit) {
      CHECK(coarse <= 1e-9);
      continue;
    }
    CHECK(fine <= 1e-5);
    CHECK(std::log2(coarse / fine) / 2 > 1.7);
  }
}

TEST_CASE("slips: a coefficient of friction needs one joint that carries the load") {
  Sleigh s = sleigh(Integrator::rk4, 0);
  s.world.links[s.skate].joint.parameters.edit().friction = 0.5;
  const auto faults = [](const World& w) {
    std::string all;
    for (const StructureFault& f : check(w)) all += f.reason + "\n";
    return all;
  };
  CHECK(faults(s.world).find("needs exactly one joint that carries it") != std::string::npos);
  add_table(s);
  CHECK(faults(s.world).empty());
  add_table(s);
  CHECK(faults(s.world).find("needs exactly one joint that carries it") != std::string::npos);
}

TEST_CASE("slips: a wheel that leans rolls as the rim of its disc does on the surface") {
  // Once as a curve that rolls on a plane, once as a curve that slides on it and a wheel.
  const auto rolled = [](bool as_wheel, Real h, Real friction) {
    constexpr Real kRim = 0.3;
    World w = exact_world(Integrator::rk4);
    const Entity ground = add_ground(w);
    const Quat leans = from_rotation_vector({0.5, 0, 0});
    const Entity disc =
        w.add_body(solid(1, {0.0225, 0.0225, 0.045}, {{0, kRim * std::cos(0.5), 0}, leans}));
    w.bodies[disc].velocity = {1.2, 0, 0};
    w.bodies[disc].angular_velocity = leans * Vec3(0, 0, -4) + Vec3(0, 1.1, 0);
    SurfaceContact c;
    c.a = disc, c.b = ground;
    c.motion = as_wheel ? SurfaceMotion::sliding : SurfaceMotion::rolling;
    if (!as_wheel && friction > 0) c.friction = friction;
    c.on_a.curve = contact_curve(nurbs::circle({}, kRim), OuterSide::right);
    c.on_b.skin = flat_skin(20);
    REQUIRE(place_surfaces(c, {w.bodies[disc].pose, w.bodies[ground].pose}).empty());
    add_surface_contact(w, c);
    if (as_wheel)
      REQUIRE(w.add(WheelJoint{.a = ground,
                               .b = disc,
                               .anchor = w.bodies[disc].pose.position,
                               .axle = leans * Vec3(0, 0, 1),
                               .radius = kRim,
                               .friction = friction}));
    Simulation sim(std::move(w), {h});
    run(sim, 1);
    return sim.world.bodies[disc];
  };
  for (const Real h : {0.005, 0.0025}) {  // it slips at first
    const Body rim = rolled(false, h, 0.2), wheel = rolled(true, h, 0.2),
               grips = rolled(true, h, 0);
    INFO(h << ", slipping: " << glm::distance(rim.velocity, wheel.velocity));
    CHECK(glm::distance(rim.velocity, wheel.velocity) <= 1e-6);
    CHECK(glm::distance(grips.velocity, wheel.velocity) > 1e-2);
  }
  Real before = 0;
  for (const Real h : {0.01, 0.005, 0.0025}) {
    const Body rim = rolled(false, h, 0), wheel = rolled(true, h, 0);
    const Real apart = glm::distance(rim.pose.position, wheel.pose.position) +
                       glm::distance(rim.velocity, wheel.velocity);
    INFO(h << ": " << apart);
    CHECK(glm::length(rim.velocity) > 0.5);
    if (before > 0) CHECK(before / apart > 8);
    if (h < 0.003) CHECK(apart <= 1e-7);
    before = apart;
  }
}
