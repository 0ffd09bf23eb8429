// Surfaces that touch at several places, and pairs that open, end and take over.
#include <catch2/catch.hpp>

#include "engine/world/surface_start.hpp"
#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81;
constexpr Real kFoot = 0.1, kApart = 0.3;  // m: radius of a foot, and from the middle to it

/// Two balls in one skin, their poles along x.
SkinPtr dumbbell() {
  std::vector<nurbs::Surface> faces;
  for (const Real x : {-kApart, kApart})
    faces.push_back(nurbs::sphere({{x, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, kFoot));
  return std::make_shared<const nurbs::Skin>(std::move(faces), 1e-9);
}

void run(Simulation& sim, int steps) {
  for (int i = 0; i < steps; ++i) REQUIRE(sim.step().status == Status::ok);
}

std::vector<SurfaceSpot> spots_of(const SurfaceContact& c) {
  std::vector<SurfaceSpot> all{{c.touches, c.slips, c.point, c.normal, c.force, c.gap}};
  all.insert(all.end(), c.more.begin(), c.more.end());
  std::erase_if(all, [](const SurfaceSpot& s) { return s.normal == Vec3(0); });
  std::sort(all.begin(), all.end(),
            [](const SurfaceSpot& x, const SurfaceSpot& y) { return x.point.x < y.point.x; });
  return all;
}

/// The lower end of each foot above the floor, m.
Real lowest(const Body& b) {
  Real least = 1e300;
  for (const Real x : {-kApart, kApart})
    least = std::min(least, to_world(b.pose, Vec3(x, 0, 0)).y - kFoot);
  return least;
}

struct Rocker {
  World world;
  Entity body, contact;
};
Rocker rocker(Integrator integrator, SurfaceMotion motion, Real tilt) {
  Rocker r{exact_world(integrator), {}, {}};
  const Entity ground = add_ground(r.world);
  Body b = solid(2, {0.02, 0.1, 0.1},
                 {{0, 0.12 + kApart * std::sin(tilt), 0}, from_rotation_vector({0, 0, tilt})});
  r.body = r.world.add_body(b);
  r.contact = touch(r.world, {r.body, dumbbell(), ground, flat_skin(20)}, motion);
  SurfaceContact& c = r.world.surface_contacts[r.contact];
  c.lifts = true, c.spots = usual_spots(c);
  return r;
}

}  // namespace

TEST_CASE("surfaces: a dumbbell that is dropped rocks on its two feet and comes to rest on both") {
  for (const Integrator integrator : kAll)
    for (const SurfaceMotion motion : {SurfaceMotion::sliding, SurfaceMotion::rolling}) {
      INFO(name_of(integrator) << " " << static_cast<int>(motion));
      Rocker r = rocker(integrator, motion, 0.3);
      REQUIRE(r.world.surface_contacts[r.contact].spots == 4);
      Simulation sim(std::move(r.world), {1.0 / 120});
      Real deepest = 0;
      for (int i = 0; i < 360; ++i) {
        run(sim, 1);
        deepest = std::min(deepest, lowest(sim.world.bodies[r.body]));
      }
      CHECK(deepest >= -1e-6);
      const std::vector<SurfaceSpot> feet = spots_of(sim.world.surface_contacts[r.contact]);
      REQUIRE(feet.size() == 2);
      for (const SurfaceSpot& foot : feet) {
        CHECK(foot.touches);
        CHECK(std::abs(foot.gap) <= 1e-9);
        CHECK(foot.force.y == Approx(-kG).epsilon(1e-6));
      }
    }
}

TEST_CASE(
    "surfaces: feet that stand share the weight by its lever, and one that is pushed up lifts") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    Rocker r = rocker(integrator, SurfaceMotion::rolling, 0);
    r.world.bodies[r.body].pose.position.y = kFoot;
    const Entity body = r.body;
    Simulation sim(std::move(r.world), {1.0 / 120});
    const auto push = [&](Real torque) {
      for (int i = 0; i < 2; ++i) {
        sim.world.forces.remove(body);
        sim.world.forces.add(body, {{0, 0, 0}, {0, 0, torque}});
        run(sim, 1);
      }
      return spots_of(sim.world.surface_contacts[r.contact]);
    };
    std::vector<SurfaceSpot> feet = push(2);
    REQUIRE(feet.size() == 2);
    // About z: the right foot loses what the left one gains.
    CHECK(feet[0].force.y == Approx(-(kG + 2 / (2 * kApart))).epsilon(1e-6));
    CHECK(feet[1].force.y == Approx(-(kG - 2 / (2 * kApart))).epsilon(1e-6));
    feet = push(2 * kG * kApart * 1.2);
    REQUIRE(feet.size() == 2);
    CHECK(feet[0].touches);
    CHECK_FALSE(feet[1].touches);
    CHECK(feet[1].gap > 0);
    CHECK(feet[1].force == Vec3(0));
  }
}

TEST_CASE("surfaces: with one place it moves over to the foot that is deeper") {
  Rocker r = rocker(Integrator::rk4, SurfaceMotion::sliding, 0.3);
  r.world.surface_contacts[r.contact].spots = 1;
  Simulation sim(std::move(r.world), {1.0 / 240});
  bool left = false, right = false;
  Real deepest = 0;
  for (int i = 0; i < 480; ++i) {
    run(sim, 1);
    const SurfaceContact& c = sim.world.surface_contacts[r.contact];
    if (c.touches) (c.point.x < sim.world.bodies[r.body].pose.position.x ? left : right) = true;
    deepest = std::min(deepest, lowest(sim.world.bodies[r.body]));
  }
  CHECK(left);
  CHECK(right);
  CHECK(deepest >= -0.05);
}

TEST_CASE("surfaces: condyles on a plateau bear by their distance from the weight, rolling on") {
  // Two ellipsoids beside one another on a body, their weight nearer to one.
  for (const Integrator integrator : {Integrator::rk4, Integrator::euler, Integrator::rattle}) {
    INFO(name_of(integrator));
    World w = exact_world(integrator);
    const Entity ground = add_ground(w);
    std::vector<nurbs::Surface> faces;
    for (const Real z : {-0.2, 0.1})
      faces.push_back(nurbs::transformed(nurbs::sphere({{}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1),
                                         {Mat3(0.15, 0, 0, 0, 0.1, 0, 0, 0, 0.06), {0, 0, z}}));
    const auto skin = std::make_shared<const nurbs::Skin>(std::move(faces), 1e-9);
    const Entity body = w.add_body(solid(3, {0.05, 0.05, 0.02}, {{0, 0.1, 0}, kIdentity}));
    const Entity contact = touch(w, {body, skin, ground, flat_skin(20)}, SurfaceMotion::rolling);
    SurfaceContact& c = w.surface_contacts[contact];
    c.lifts = true, c.spots = usual_spots(c);
    Simulation sim(std::move(w), {1.0 / 240});
    run(sim, 10);
    std::vector<SurfaceSpot> all = spots_of(sim.world.surface_contacts[contact]);
    std::sort(all.begin(), all.end(),
              [](const SurfaceSpot& x, const SurfaceSpot& y) { return x.point.z < y.point.z; });
    REQUIRE(all.size() == 2);
    CHECK(all[0].force.y == Approx(-3 * kG / 3).epsilon(1e-6));
    CHECK(all[1].force.y == Approx(-3 * kG * 2 / 3).epsilon(1e-6));
    // Pushed, it rolls on both as one ellipse does; it turns about z alone.
    sim.world.bodies[body].velocity = {0.1, 0, 0};
    sim.world.bodies[body].angular_velocity = {0, 0, -1};
    sim.world.bodies[body].restart = true;
    run(sim, 60);
    all = spots_of(sim.world.surface_contacts[contact]);
    REQUIRE(all.size() == 2);
    for (const SurfaceSpot& s : all) {
      CHECK(s.touches);
      CHECK(std::abs(s.gap) <= 1e-9);
    }
    const Vec3 spin = sim.world.bodies[body].angular_velocity;
    CHECK(std::abs(spin.x) + std::abs(spin.y) <= 1e-6);
    CHECK(slip_of(sim.world, contact) <= 1e-9);
  }
}

TEST_CASE(
    "surfaces: what is on a thin lens touches its near side only, at any depth of its far one") {
  World w = exact_world(Integrator::rk4);
  const Entity ground = add_ground(w);
  const Entity ball = w.add_body(solid_ball(1, 0.05, {0, 0.06 + 0.004, 0}));
  const Entity contact =
      touch(w, {ball, ball_skin(Vec3(0.05)), ground, ball_skin({0.5, 0.004, 0.5})},
            SurfaceMotion::sliding);
  SurfaceContact& c = w.surface_contacts[contact];
  c.lifts = true, c.spots = 4;
  Simulation sim(std::move(w), {1.0 / 240});
  for (int i = 0; i < 240; ++i) {
    run(sim, 1);
    for (const SurfaceSpot& s : spots_of(sim.world.surface_contacts[contact]))
      if (s.touches) {
        CHECK(s.normal.y > 0.9);
        CHECK(s.gap >= -1e-9);
      }
  }
  CHECK(sim.world.bodies[ball].pose.position.y == Approx(0.054).margin(1e-6));
  CHECK(spots_of(sim.world.surface_contacts[contact]).size() == 1);
}

TEST_CASE("surfaces: one that is held follows its pair, though another is nearer") {
  Rocker r = rocker(Integrator::rk4, SurfaceMotion::sliding, 0.02);
  SurfaceContact& c = r.world.surface_contacts[r.contact];
  c.lifts = false, c.spots = 1;
  Simulation sim(std::move(r.world), {1.0 / 120});
  run(sim, 1);
  const int face = sim.world.surface_contacts[r.contact].at.a.face;
  for (int i = 0; i < 40; ++i) {
    run(sim, 1);
    CHECK(sim.world.surface_contacts[r.contact].at.a.face == face);
    CHECK(std::abs(sim.world.surface_contacts[r.contact].gap) <= 1e-9);
  }
  CHECK(lowest(sim.world.bodies[r.body]) < -0.05);  // the other foot is let through
}

TEST_CASE("surfaces: several places go on to the same bits in copies") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    Rocker r = rocker(integrator, SurfaceMotion::rolling, 0.3);
    Simulation one(std::move(r.world), {1.0 / 120});
    run(one, 40);
    Simulation copy = Simulation::copy_of(one.world, {1.0 / 120});
    run(one, 60), run(copy, 60);
    CHECK(state_hash(one.world) == state_hash(copy.world));
  }
}

TEST_CASE("surfaces: both feet of a dumbbell that is thrown along the floor tell that they slip") {
  Rocker r = rocker(Integrator::rk4, SurfaceMotion::rolling, 0);
  r.world.surface_contacts[r.contact].friction = 0.2;
  r.world.bodies[r.body].velocity = {3, 0, 0};
  Simulation sim(std::move(r.world), {1.0 / 120});
  run(sim, 24);
  const std::vector<SurfaceSpot> feet = spots_of(sim.world.surface_contacts[r.contact]);
  REQUIRE(feet.size() == 2);
  for (const SurfaceSpot& foot : feet) {
    CHECK(foot.touches);
    CHECK(foot.slips);
    CHECK(foot.force.x == Approx(-0.2 * foot.force.y).epsilon(1e-6));
  }
}

TEST_CASE("surfaces: what is met from its inner side is told, with the way to turn it over") {
  World w = exact_world(Integrator::rk4);
  const auto why = [&](Real height, SkinPtr on_a, SkinPtr on_b) {
    SurfaceContact c;
    c.a = w.add_body(solid_ball(1, kFoot, {0, height, 0})), c.b = add_ground(w);
    c.on_a.skin = std::move(on_a), c.on_b.skin = std::move(on_b);
    return place_surfaces(c, {w.bodies[c.a].pose, w.bodies[c.b].pose});
  };
  const SkinPtr ball = ball_skin(Vec3(kFoot)), floor = flat_skin(4);
  const SkinPtr hollow = skin_of(turned_over(nurbs::sphere({}, kFoot)));
  CHECK(why(kFoot + 0.003, ball, floor).empty());
  CHECK(why(-kFoot - 0.003, ball, floor) ==
        "found surfaces 0.003 m apart that face each other with an inner side, that of b, expected "
        "outer sides to face each other: \"inside_out\" flips a surface");
  CHECK(why(kFoot + 0.003, hollow, floor).find("inner side, that of a,") != std::string::npos);
  CHECK(why(-kFoot - 0.003, hollow, floor).find("inner side, both,") != std::string::npos);
  CHECK(why(9, ball, floor).find("m apart, expected them to face") != std::string::npos);
}
