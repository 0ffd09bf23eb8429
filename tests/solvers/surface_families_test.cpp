// Families of contacts of surfaces and curves: hollows, flat sides, needles, what is fast or heavy.
#include <catch2/catch.hpp>

#include "engine/nurbs/plane_curves.hpp"
#include "engine/world/surface_start.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81;

nurbs::Curve rounded(std::vector<Vec3> corners) {
  const Result<nurbs::Curve> curve = nurbs::rounded_polygon(corners, 0.02);
  REQUIRE(curve);
  return *curve;
}
/// A block with a V of 90 degrees, its lowest place at y = -0.2.
nurbs::Curve vee() {
  return rounded({{-1, -0.5, 0}, {1, -0.5, 0}, {1, 0.8, 0}, {0, -0.2, 0}, {-1, 0.8, 0}});
}
nurbs::Curve box() {
  return rounded({{-0.2, -0.1, 0}, {0.2, -0.1, 0}, {0.2, 0.1, 0}, {-0.2, 0.1, 0}});
}

struct CurveOn {
  nurbs::Curve on_a, on_b;
  Real friction = -1;  // below 0: it slides
};
struct Falling {
  World world;
  Entity body, contact;
};
/// A body that falls on a fixed curve.
Falling falling(Integrator integrator, const Body& body, const CurveOn& curves) {
  Falling s{exact_world(integrator), {}, {}};
  const Entity ground = add_ground(s.world);
  s.body = s.world.add_body(body);
  SurfaceContact c;
  c.a = s.body, c.b = ground, c.lifts = true, c.friction = curves.friction;
  c.on_a.curve = contact_curve(curves.on_a, OuterSide::right);
  c.on_b.curve = contact_curve(curves.on_b, OuterSide::right);
  c.motion = curves.friction < 0 ? SurfaceMotion::sliding : SurfaceMotion::rolling;
  c.spots = usual_spots(c);
  s.contact = add_surface_contact(s.world, c);
  return s;
}
Falling falling_on(Integrator integrator, const Body& body, SkinPtr skin, SkinPtr ground) {
  Falling s{exact_world(integrator), {}, {}};
  const Entity floor = add_ground(s.world);
  s.body = s.world.add_body(body);
  s.contact = touch(s.world, {s.body, skin, floor, ground}, SurfaceMotion::sliding);
  SurfaceContact& c = s.world.surface_contacts[s.contact];
  c.lifts = true, c.spots = usual_spots(c);
  return s;
}

/// Steps, and the most energy that there is on the way above that at the start, J.
Real run(Simulation& sim, int steps) {
  const Real start = measure(sim.world).energy();
  Real gain = 0;
  for (int i = 0; i < steps; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    gain = std::max(gain, measure(sim.world).energy() - start);
  }
  return gain;
}

std::vector<SurfaceSpot> bearing(const SurfaceContact& c) {
  std::vector<SurfaceSpot> all{{c.touches, c.slips, c.point, c.normal, c.force, c.gap}};
  all.insert(all.end(), c.more.begin(), c.more.end());
  std::erase_if(all, [](const SurfaceSpot& s) { return !s.touches; });
  std::sort(all.begin(), all.end(),
            [](const SurfaceSpot& x, const SurfaceSpot& y) { return x.point.x < y.point.x; });
  return all;
}

}  // namespace

TEST_CASE("surfaces: a disc that falls into a V comes to rest on both of its sides") {
  for (const Integrator integrator : kAll)
    for (const Real friction : {-1.0, 0.3}) {
      INFO(name_of(integrator) << ", friction " << friction);
      const Body disc = solid(1, {0.0025, 0.0025, 0.005}, {{0.12, 0.35, 0}, kIdentity});
      Falling s = falling(integrator, disc, {nurbs::circle({}, 0.1), vee(), friction});
      Simulation sim(std::move(s.world), {1.0 / 120});
      CHECK(run(sim, 360) <= 1e-12);
      const Body& b = sim.world.bodies[s.body];
      CHECK(b.pose.position.y == Approx(-0.2 + 0.1 * std::sqrt(2)).margin(1e-9));
      CHECK(glm::length(b.velocity) + glm::length(b.angular_velocity) <= 1e-9);
      const auto sides = bearing(sim.world.surface_contacts[s.contact]);
      REQUIRE(sides.size() == 2);
      CHECK(glm::distance(sides[0].force + sides[1].force, {0, -kG, 0}) <= 1e-9);
      // Friction takes no more of a load that both share than it has to.
      const Real each = kG / std::sqrt(2);
      for (const SurfaceSpot& side : sides)
        CHECK(-glm::dot(side.force, side.normal) == Approx(each).epsilon(0.03));
    }
}

TEST_CASE(
    "surfaces: a ball that falls into a groove of one closed face rests on both of its sides") {
  CHECK_FALSE(skin_of(nurbs::extruded(vee(), {0, 0, 1}))->is_convex());
  CHECK_FALSE(skin_of(nurbs::cylinder({}, 1, 2))->is_convex());
  CHECK(flat_skin(2)->is_convex());
  const Body ball = solid_ball(1, 0.1, {0.02, 0.0, 0.5});
  Falling s = falling_on(Integrator::rk4, ball, ball_skin(Vec3(0.1)),
                         skin_of(nurbs::extruded(vee(), {0, 0, 1})));
  Simulation sim(std::move(s.world), {1.0 / 120});
  CHECK(run(sim, 30) <= 1e-12);
  const auto sides = bearing(sim.world.surface_contacts[s.contact]);
  REQUIRE(sides.size() == 2);
  for (const SurfaceSpot& side : sides)
    CHECK(glm::length(side.force) == Approx(kG / std::sqrt(2)).epsilon(1e-9));
}

TEST_CASE("surfaces: a box that lands on an edge falls flat and stands on both ends of its side") {
  for (const Integrator integrator : {Integrator::euler, Integrator::rk4, Integrator::implicit}) {
    INFO(name_of(integrator));
    const Body body = solid(1, Vec3(0.01), {{0, 0.35, 0}, from_rotation_vector({0, 0, 0.2})});
    Falling s = falling(integrator, body, {box(), nurbs::line({4, 0, 0}, {-4, 0, 0})});
    Simulation sim(std::move(s.world), {1.0 / 120});
    CHECK(run(sim, 240) <= 1e-12);
    const Body& b = sim.world.bodies[s.body];
    CHECK(b.pose.position.y == Approx(0.1).margin(1e-9));
    CHECK(glm::length(b.velocity) + glm::length(b.angular_velocity) <= 1e-9);
    const auto ends = bearing(sim.world.surface_contacts[s.contact]);
    REQUIRE(ends.size() == 2);
    CHECK(ends[1].point.x - ends[0].point.x == Approx(0.36).margin(1e-6));
    for (const SurfaceSpot& end : ends) CHECK(end.force.y == Approx(-kG / 2).epsilon(1e-6));
  }
}

TEST_CASE("surfaces: a needle of 100:1 that falls over slaps the floor and gains no energy") {
  Real height[2] = {};
  for (const Integrator integrator : {Integrator::rk4, Integrator::radau}) {
    INFO(name_of(integrator));
    const Vec3 half{1, 0.01, 0.01};
    Body body = solid_ellipsoid(0.1, half, {{0, 0.5, 0}, from_rotation_vector({0, 0.2, 0.4})});
    body.velocity = {0.5, 0, 0.2};
    Falling s = falling_on(integrator, body, ball_skin(half), flat_skin(200));
    Simulation sim(std::move(s.world), {1.0 / 240});
    CHECK(run(sim, 480) <= 1e-9);
    height[integrator == Integrator::radau] = sim.world.bodies[s.body].pose.position.y;
  }
  CHECK(height[0] == Approx(height[1]).epsilon(1e-3));
}

TEST_CASE("surfaces: a small ball at 50 m/s does not pass through a floor that it was far from") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    Body ball = solid_ball(1, 0.05, {-90, 0.3, 0});
    ball.velocity = {50, -10, 0};
    Falling s = falling_on(integrator, ball, ball_skin(Vec3(0.05)), flat_skin(400));
    Simulation sim(std::move(s.world), {1.0 / 60});
    run(sim, 60);
    CHECK(sim.world.bodies[s.body].pose.position.y == Approx(0.05).margin(1e-9));
  }
}

TEST_CASE("surfaces: 10 kg stand on a ball of 1 g, which rolls") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    World w = exact_world(integrator);
    const Entity ground = add_ground(w);
    const SkinPtr skin = ball_skin(Vec3(0.1));
    const Entity light = w.add_body(solid_ball(1e-3, 0.1, {0, 0.1, 0})),
                 heavy = w.add_body(solid_ball(10, 0.1, {0, 0.3001, 0}));
    const Entity below = touch(w, {light, skin, ground, flat_skin(20)}, SurfaceMotion::rolling),
                 above = touch(w, {heavy, skin, light, skin}, SurfaceMotion::rolling);
    for (const Entity contact : {below, above}) {
      w.surface_contacts[contact].lifts = true;
      w.surface_contacts[contact].friction = 0.4;
    }
    Simulation sim(std::move(w), {1.0 / 240});
    CHECK(run(sim, 240) <= 1e-12);
    CHECK(sim.world.bodies[heavy].pose.position.y == Approx(0.3).margin(1e-9));
    CHECK(sim.world.surface_contacts[below].force.y == Approx(-10.001 * kG).epsilon(1e-6));
    CHECK(sim.world.surface_contacts[above].force.y == Approx(-10 * kG).epsilon(1e-6));
  }
}

TEST_CASE("surfaces: a stick that is pushed with its foot ahead jams, and gains nothing") {
  // With friction beyond 4/3 a force at the foot of a stick that leans back presses it down more
  // than it takes: Painleve's paradox.
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    constexpr Real kLean = 1.1, kHalf = 0.5, kFoot = 0.02;
    World w = exact_world(integrator);
    const Entity ground = add_ground(w);
    const Vec3 foot(kHalf, 0, 0);
    Body stick = solid(1, {1e-3, 1.0 / 12, 1.0 / 12});
    stick.pose.rotation = from_rotation_vector({0, 0, -kLean});
    stick.pose.position = Vec3(0, kFoot, 0) - stick.pose.rotation * foot;
    stick.velocity = {2, 0, 0};
    const Entity body = w.add_body(stick);
    const Entity contact =
        touch(w, {body, ball_skin(Vec3(kFoot)), ground, flat_skin(20)}, SurfaceMotion::sliding);
    SurfaceContact& c = w.surface_contacts[contact];
    c.on_a.pose.position = foot, c.friction = 3, c.lifts = true;
    Simulation sim(std::move(w), {1.0 / 240});
    CHECK(run(sim, 1) <= 1e-9);
    // The foot is caught; the moment of momentum about it is kept.
    const Vec3 arm =
        sim.world.bodies[body].pose.position - sim.world.surface_contacts[contact].point;
    const Real spin = -2 * arm.y / (1.0 / 12 + glm::dot(arm, arm));
    CHECK(sim.world.bodies[body].angular_velocity.z == Approx(spin).epsilon(0.02));
    // Where the normal force and friction meet, the forces of this one lag.
    CHECK(run(sim, 23) <= 1e-9);
    CHECK(slip_of(sim.world, contact) <= 1e-9);
  }
}

TEST_CASE("surfaces: two rings hang in one another, hollow on hollow") {
  // Two rings through one another: the inner side of one tube on that of the other.
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    World w = exact_world(integrator, {0, 0, -kG});
    const Entity ground = add_ground(w);
    const SkinPtr lower = skin_of(nurbs::torus({}, 0.5, 0.05)),
                  upper = skin_of(nurbs::torus({{}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, 0.5, 0.05));
    const Entity link = w.add_body(solid(1, Vec3(0.1), {{0.51, 0.03, -0.399}, kIdentity}));
    const Entity contact = touch(w, {link, upper, ground, lower}, SurfaceMotion::rolling);
    SurfaceContact& c = w.surface_contacts[contact];
    c.lifts = true, c.friction = 0.4, c.spots = usual_spots(c);
    Simulation sim(std::move(w), {1.0 / 240});
    CHECK(run(sim, 480) <= 1e-9);
    CHECK(sim.world.surface_contacts[contact].touches);
    CHECK(sim.world.bodies[link].pose.position.z == Approx(-0.4).margin(0.01));
  }
}
