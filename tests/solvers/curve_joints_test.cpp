// Curves on surfaces under the solver lagrangian: a rim that rolls, an edge that slides.
#include <catch2/catch.hpp>

#include "engine/world/surface_start.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

Entity touch_by_curve(World& w, const SurfacePair& pair, const nurbs::Curve& curve,
                      SurfaceMotion motion) {
  SurfaceContact c;
  c.a = pair.a, c.b = pair.b, c.motion = motion;
  c.on_a.curve = contact_curve(curve, OuterSide::right), c.on_b.skin = pair.on_b;
  const std::string why = place_surfaces(c, {w.bodies[c.a].pose, w.bodies[c.b].pose});
  INFO(why);
  REQUIRE(why.empty());
  return add_surface_contact(w, c);
}

constexpr Real kRadius = 0.4, kLean = 1.2, kTurning = 2, kAcross = 0.04, kAxial = 0.08;

/// How far from its circle a disc of 1 kg is after a second of its steady turn: axis at kLean from
/// the vertical, kTurning about it. The rim's point at rest: s R = -W (D + R cos l); moments:
/// W sin l (I3 (s + W cos l) - I1 W cos l) = -R m g cos l + R sin l m W^2 D.
Real error_of_disc(Real h) {
  const Real c = std::cos(kLean), s = std::sin(kLean), w = kTurning, g = 9.81;
  // s = -(D + R c) W / R, which makes the moments linear in D.
  const auto moments = [&](Real d) {
    const Real spin = -w * (d + kRadius * c) / kRadius;
    return w * s * (kAxial * (spin + w * c) - kAcross * w * c) + kRadius * g * c -
           kRadius * s * w * w * d;
  };
  const Real at = moments(0) / (moments(0) - moments(1));
  const Real spin = -w * (at + kRadius * c) / kRadius;
  World world = exact_world(Integrator::rk4, {0, 0, -g});
  const Entity ground = add_ground(world);
  Body disc = solid(1, {kAcross, kAcross, kAxial},
                    {{at, 0, kRadius * s}, from_rotation_vector({0, kLean, 0})});
  disc.velocity = {0, w * at, 0};
  disc.angular_velocity = spin * Vec3(s, 0, c) + Vec3(0, 0, w);
  const Entity body = world.add_body(disc);
  const Entity contact = touch_by_curve(world, {body, nullptr, ground, flat_skin(6, {0, 0, 1})},
                                        nurbs::circle({}, kRadius), SurfaceMotion::rolling);
  Simulation sim(std::move(world), {h});
  for (int i = 0; i < std::lround(1 / h); ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(std::abs(sim.world.surface_contacts[contact].gap) <= 1e-12);
  return glm::distance(sim.world.bodies[body].pose.position,
                       {at * std::cos(w), at * std::sin(w), kRadius * s});
}

}  // namespace

TEST_CASE("curve joints: a thin disc rolls round on its rim in its steady turn") {
  const Real coarse = error_of_disc(0.02), middle = error_of_disc(0.01),
             fine = error_of_disc(0.005);
  INFO(coarse << " " << middle << " " << fine);
  CHECK(fine <= 1e-8);
  CHECK(std::log2(middle / fine) == Approx(4).margin(0.4));
  CHECK(coarse > middle);
}

TEST_CASE("curve joints: a bent edge slides down a ball as its least point does") {
  // A ring across the vertical plane of its motion hangs over a ball: one of a pair of bodies whose
  // energy is kept, whose gap stays closed, and that pull with opposite forces.
  World w = exact_world(Integrator::rk4);
  const Entity ball = w.add_body(solid(2, Vec3(0.05)));
  Body hoop =
      solid(1, {0.02, 0.02, 0.04}, {{0.05, 0.42, 0.02}, from_rotation_vector({0.4, 0, 0.1})});
  const Entity ring = w.add_body(hoop);
  const nurbs::Frame across{.y = {0, 0, 1}, .z = {0, -1, 0}};
  const Entity contact = touch_by_curve(w, {ring, nullptr, ball, ball_skin({0.3, 0.25, 0.3})},
                                        nurbs::circle(across, 0.2), SurfaceMotion::sliding);
  Simulation sim(std::move(w), {0.002});
  sim.step();
  const Real start = measure(sim.world).energy();
  for (int i = 0; i < 200; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    const SurfaceContact& c = sim.world.surface_contacts[contact];
    CHECK(std::abs(c.gap) <= 1e-12);
    const Vec3 on_ring = to_local(compose(sim.world.bodies[ball].pose, c.on_b.pose), c.point);
    const Vec3 scaled = on_ring / Vec3(0.3, 0.25, 0.3);
    CHECK(std::abs(glm::dot(scaled, scaled) - 1) <= 1e-10);
  }
  CHECK(measure(sim.world).energy() == Approx(start).epsilon(1e-6));
}
