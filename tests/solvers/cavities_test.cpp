// Bodies that roll and slide on the wall of a closed cavity, from inside: against closed forms.
#include <catch2/catch.hpp>

#include "engine/world/surface_start.hpp"
#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81, kWall = 1, kBall = 0.3, kArm = kWall - kBall;

SkinPtr cavity_skin(Vec3 half_axes) {
  return std::make_shared<const nurbs::Skin>(nurbs::Skin::ellipsoid_cavity(half_axes));
}
/// A torus about y whose tube is seen from inside.
SkinPtr tube_skin(Real major, Real tube) {
  const nurbs::Frame at{{}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
  return skin_of(nurbs::inside_out(nurbs::torus(at, major, tube)));
}

void run(Simulation& sim, int steps) {
  for (int i = 0; i < steps; ++i) REQUIRE(sim.step().status == Status::ok);
}

/// A ball in a sphere, its centre at this angle from the lowest place.
struct Inside {
  World world;
  Entity ball, contact;
};
Inside ball_in_sphere(Integrator integrator, Real angle, SurfaceMotion motion) {
  Inside s{exact_world(integrator), {}, {}};
  const Entity ground = add_ground(s.world);
  s.ball =
      s.world.add_body(solid_ball(2, kBall, kArm * Vec3(std::sin(angle), -std::cos(angle), 0)));
  s.contact =
      touch(s.world, {s.ball, ball_skin(Vec3(kBall)), ground, cavity_skin(Vec3(kWall))}, motion);
  return s;
}

/// 4 K(sin(amplitude / 2)) sqrt(length / g), by the arithmetic-geometric mean.
Real period_of(Real length, Real amplitude) {
  Real a = 1, b = std::cos(amplitude / 2);
  for (int i = 0; i < 40 && a != b; ++i) {
    const Real mean = (a + b) / 2;
    b = std::sqrt(a * b), a = mean;
  }
  return 2 * kPi * std::sqrt(length / kG) / a;
}

/// How far a ball is from the lowest place after a quarter of a period.
Real error_after_quarter(Integrator integrator, SurfaceMotion motion, Real amplitude, int steps) {
  Inside s = ball_in_sphere(integrator, amplitude, motion);
  const Real length = motion == SurfaceMotion::sliding ? kArm : 1.4 * kArm;
  Simulation sim(std::move(s.world), {period_of(length, amplitude) / (4 * steps)});
  run(sim, steps);
  CHECK(std::abs(sim.world.surface_contacts[s.contact].gap) <= 1e-12);
  if (motion != SurfaceMotion::sliding) CHECK(slip_of(sim.world, s.contact) <= 1e-12);
  return glm::distance(sim.world.bodies[s.ball].pose.position, {0, -kArm, 0});
}

Real energy_of(const World& w, Entity body) {
  const Body& b = w.bodies[body];
  const Vec3 spin = glm::conjugate(b.pose.rotation) * b.angular_velocity;
  return b.mass / 2 * glm::dot(b.velocity, b.velocity) + glm::dot(spin, b.inertia * spin) / 2 -
         b.mass * glm::dot(w.gravity, b.pose.position);
}

}  // namespace

TEST_CASE("cavities: an ellipsoid's wall is its surface, seen from inside") {
  const Vec3 half(0.7, 0.5, 0.9);
  const nurbs::Skin out = nurbs::Skin::ellipsoid(half), in = nurbs::Skin::ellipsoid_cavity(half);
  REQUIRE(in.faces().size() == 6);
  CHECK(in.fingerprint() != out.fingerprint());
  CHECK_FALSE(in.is_convex());
  for (int face = 0; face < 6; ++face)
    for (const Real u : {-0.6, -0.1, 0.3})
      for (const Real v : {-0.5, 0.2, 0.65}) {
        const nurbs::Jet a = out.face(face).at(u, v), b = in.face(face).at(-u, v);
        CHECK(glm::distance(a.s, b.s) <= 1e-15);
        const Vec3 n = glm::normalize(glm::cross(a.u, a.v)),
                   m = glm::normalize(glm::cross(b.u, b.v));
        CHECK(glm::distance(n, -m) <= 1e-14);
      }
  // Across an edge the wall goes on at the same point.
  for (int edge = 0; edge < nurbs::kEdges; ++edge) {
    const Real end = edge % 2 == 0 ? -nurbs::kChartReach : nurbs::kChartReach;
    const nurbs::Place at = edge < 2 ? nurbs::Place{2, end, 0.1} : nurbs::Place{2, 0.1, end};
    const auto to = in.across(at, static_cast<nurbs::Edge>(edge));
    REQUIRE(to);
    CHECK(glm::distance(in.face(to->face).at(to->u, to->v).s, in.face(at.face).at(at.u, at.v).s) <=
          1e-14);
  }
}

TEST_CASE("cavities: a ball in a sphere swings with the period of its pendulum") {
  for (const SurfaceMotion motion : {SurfaceMotion::sliding, SurfaceMotion::rolling})
    for (const Real amplitude : {0.05, 1.2, 2.8}) {
      const int steps = amplitude > 2 ? 100 : 25;  // a fast ball's steps are divided
      const Real coarse = error_after_quarter(Integrator::rk4, motion, amplitude, steps),
                 fine = error_after_quarter(Integrator::rk4, motion, amplitude, 2 * steps);
      INFO(amplitude << ": " << coarse << ", " << fine);
      CHECK(fine <= 2e-6 * amplitude);
      CHECK(std::log2(coarse / fine) == Approx(4).margin(0.6));
    }
  for (const Integrator second : {Integrator::rattle, Integrator::implicit}) {
    const Real coarse = error_after_quarter(second, SurfaceMotion::rolling, 1.2, 50),
               fine = error_after_quarter(second, SurfaceMotion::rolling, 1.2, 100);
    INFO(name_of(second) << ": " << coarse << ", " << fine);
    CHECK(fine <= 1e-3);
    CHECK(std::log2(coarse / fine) == Approx(2).margin(0.4));
  }
  CHECK(error_after_quarter(Integrator::radau, SurfaceMotion::rolling, 1.2, 50) <= 1e-8);
}

TEST_CASE("cavities: a ball runs round in a sphere, over its top, and keeps its energy") {
  for (const Integrator integrator : {Integrator::rk4, Integrator::rattle, Integrator::radau}) {
    INFO(name_of(integrator));
    Inside s = ball_in_sphere(integrator, 0.3, SurfaceMotion::rolling);
    Body& start = s.world.bodies[s.ball];
    start.velocity = {6 * std::cos(0.3), 6 * std::sin(0.3), 1.5};
    const Entity ball = s.ball;
    Simulation sim(std::move(s.world), {0.002});
    run(sim, 1);
    const Real before = energy_of(sim.world, ball);
    Real highest = -1;
    for (int i = 0; i < 1000; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      highest = std::max(highest, sim.world.bodies[ball].pose.position.y);
      REQUIRE(slip_of(sim.world, s.contact) <= 1e-11);
    }
    CHECK(highest > 0.5 * kArm);
    CHECK(energy_of(sim.world, ball) ==
          Approx(before).epsilon(integrator == Integrator::rattle ? 1e-3 : 1e-6));
    CHECK(std::abs(glm::length(sim.world.bodies[ball].pose.position) - kArm) <= 1e-12);
  }
}

TEST_CASE("cavities: a ball that slides over the side of a sphere leaves it where it must") {
  // From the lowest place at v: it leaves where cos(angle) = -(v^2 / (g D) - 2) / 3.
  const Real v2 = 3.2 * kG * kArm;
  Inside s = ball_in_sphere(Integrator::rk4, 0, SurfaceMotion::sliding);
  s.world.bodies[s.ball].velocity = {std::sqrt(v2), 0, 0};
  s.world.surface_contacts[s.contact].lifts = true;
  s.world.mark_dirty();
  const Entity ball = s.ball;
  Simulation sim(std::move(s.world), {0.001});
  Real left_at = -2;
  for (int i = 0; i < 1000 && left_at < -1; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    const Vec3 at = sim.world.bodies[ball].pose.position;
    if (!sim.world.surface_contacts[s.contact].touches) left_at = -at.y / glm::length(at);
  }
  CHECK(left_at == Approx(-(v2 / (kG * kArm) - 2) / 3).margin(5e-3));
}

TEST_CASE("cavities: a ball runs round in the tube of a torus on its circle") {
  constexpr Real kMajor = 1, kTube = 0.25, kOwn = 0.1, kSpeed = 2, kTime = 1.5;
  const Real circle = kMajor + kTube - kOwn;
  for (const SurfaceMotion motion : {SurfaceMotion::sliding, SurfaceMotion::rolling}) {
    World w = exact_world(Integrator::rk4, Vec3(0));
    const Entity ground = add_ground(w);
    const Entity ball = w.add_body(solid_ball(1, kOwn, {circle, 0, 0}));
    const Entity contact =
        touch(w, {ball, ball_skin(Vec3(kOwn)), ground, tube_skin(kMajor, kTube)}, motion);
    w.bodies[ball].velocity = {0, 0, -kSpeed};
    if (motion == SurfaceMotion::rolling) w.bodies[ball].angular_velocity = {0, -kSpeed / kOwn, 0};
    Simulation sim(std::move(w), {0.005});
    run(sim, 300);
    const Real turned = kSpeed * kTime / circle;
    const Vec3 place(circle * std::cos(turned), 0, -circle * std::sin(turned));
    CHECK(glm::distance(sim.world.bodies[ball].pose.position, place) <= 1e-8);
    CHECK(glm::dot(sim.world.surface_contacts[contact].force, glm::normalize(place)) ==
          Approx(kSpeed * kSpeed / circle).epsilon(1e-6));
  }
}

TEST_CASE("cavities: an egg rolls in a closed ellipsoid and keeps its energy") {
  World w = exact_world(Integrator::rk4);
  const Entity ground = add_ground(w);
  const Vec3 half(0.16, 0.1, 0.12), wall(0.7, 0.6, 0.8);
  const Pose at{{0.25, -0.35, 0.1}, from_rotation_vector({0.2, 0.4, 0.3})};
  const Entity egg = w.add_body(solid_ellipsoid(1, half, at));
  SurfaceContact c;
  c.a = egg, c.b = ground, c.on_a.skin = ball_skin(half), c.on_b.skin = cavity_skin(wall);
  c.motion = SurfaceMotion::rolling;
  REQUIRE(place_surfaces(c, {at, {}}).empty());
  const Entity contact = add_surface_contact(w, c);
  Simulation sim(std::move(w), {0.004});
  run(sim, 1);
  const Real before = energy_of(sim.world, egg);
  run(sim, 1500);
  CHECK(energy_of(sim.world, egg) == Approx(before).epsilon(1e-5));
  CHECK(slip_of(sim.world, contact) <= 1e-11);
  CHECK(std::abs(sim.world.surface_contacts[contact].gap) <= 1e-12);
}

TEST_CASE("cavities: a ball larger than its cavity is refused, a smaller one is not") {
  for (const Real radius : {0.5, 0.98, 1.02, 1.2})
    for (const Vec3 at : {Vec3(0, -0.1, 0), Vec3(0.02, 0, 0.03), Vec3(0.3, 0.2, 0)}) {
      SurfaceContact c;
      c.on_a.skin = ball_skin(Vec3(radius)), c.on_b.skin = cavity_skin(Vec3(kWall));
      const std::string why = place_surfaces(c, {{at, kIdentity}, {}});
      INFO(radius << ": " << why);
      CHECK(why.empty() == (radius < kWall));
      CHECK(c.known == (radius < kWall));
    }
}
