// Surfaces that may lift off, at speed: what comes down is met, what leaves lets go in time.
#include <catch2/catch.hpp>
#include <random>

#include "engine/nurbs/closest.hpp"
#include "engine/nurbs/plane_curves.hpp"
#include "engine/world/surface_start.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81;

/// y = height cos(2 pi x / length), from -1 m to `end`; outwards is up.
struct Waves {
  Real length, height, end;

  Real at(Real x) const { return height * std::cos(2 * kPi * x / length); }
  std::shared_ptr<const nurbs::Wire> curve() const {
    constexpr int kPointsAWave = 24;
    const int count = static_cast<int>((end + 1) / length * kPointsAWave);
    std::vector<Vec3> points;
    for (int i = 0; i <= count; ++i) {
      const Real x = end - (end + 1) * i / count;
      points.push_back({x, at(x), 0});
    }
    const Result<nurbs::Curve> made = nurbs::interpolated(points, 3, nurbs::Ends::open);
    REQUIRE(made);
    return contact_curve(*made, OuterSide::right);
  }
};

/// A disc of 1 kg on a curve that is fixed.
struct Disc {
  Real radius;
  Vec3 at, velocity;
};
struct OnCurve {
  World world;
  Entity disc, contact;
};
OnCurve disc_on(Integrator integrator, const Disc& disc,
                const std::shared_ptr<const nurbs::Wire>& curve) {
  OnCurve s{exact_world(integrator), {}, {}};
  const Entity ground = add_ground(s.world);
  const Real across = 0.25 * disc.radius * disc.radius;
  Body body = solid(1, {across, across, 2 * across}, {disc.at, kIdentity});
  body.velocity = disc.velocity;
  s.disc = s.world.add_body(body);
  SurfaceContact c;
  c.a = s.disc, c.b = ground, c.lifts = true;
  c.on_a.curve = contact_curve(nurbs::circle({}, disc.radius), OuterSide::right),
  c.on_b.curve = curve;
  c.spots = usual_spots(c);
  s.contact = add_surface_contact(s.world, c);
  return s;
}

struct Run {
  Waves waves;
  Real radius, speed, rate;  // m, m/s, steps a second
};
/// How far a disc is within the waves at worst, m, and the energy it gains, J.
struct Worst {
  Real overlap = 0, gain = 0;
};
Worst worst_of(Integrator integrator, const Run& run) {
  const auto curve = run.waves.curve();
  OnCurve s = disc_on(
      integrator, {run.radius, {0, run.waves.height + run.radius, 0}, {run.speed, 0, 0}}, curve);
  Simulation sim(std::move(s.world), {1 / run.rate});
  const Real start = measure(sim.world).energy();
  Worst worst;
  for (int i = 0; i < 0.4 * run.rate; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    const Vec3 at = sim.world.bodies[s.disc].pose.position;
    const Real distance = nurbs::closest_point(*curve, at).distance;
    const Real outside = at.y > run.waves.at(at.x) ? distance : -distance;
    worst.overlap = std::max(worst.overlap, run.radius - outside);
    worst.gain = std::max(worst.gain, measure(sim.world).energy() - start);
  }
  return worst;
}

}  // namespace

TEST_CASE("surfaces: a disc that flies from wave to wave is within none at the end of a step") {
  const Run runs[] = {{{1, 0.02, 10}, 0.05, 10, 60},  {{1, 0.06, 20}, 0.05, 30, 60},
                      {{3, 0.06, 10}, 0.5, 10, 60},   {{3, 0.18, 50}, 0.05, 100, 60},
                      {{20, 0.4, 30}, 0.15, 50, 60},  {{20, 1.2, 10}, 0.5, 10, 120},
                      {{8, 0.48, 30}, 0.05, 50, 240}, {{1, 0.06, 25}, 0.05, 50, 60}};
  for (const Integrator integrator : kAll)
    for (const Run& run : runs) {
      INFO(name_of(integrator) << ", waves of " << run.waves.length << " m, " << run.speed
                               << " m/s, " << run.rate << " Hz");
      const Worst worst = worst_of(integrator, run);
      CHECK(worst.overlap <= 2e-9);
      CHECK(worst.gain <= 0.005 * run.speed * run.speed);
    }
}

TEST_CASE("surfaces: a step along waves is as short as their normal asks for") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    CHECK(worst_of(integrator, {{1, 0.02, 25}, 0.05, 50, 60}).gain <= 0.01 * 1250);
  }
}

TEST_CASE("surfaces: a small disc at 60 m/s does not pass through a thin wall in one step") {
  const Result<nurbs::Curve> wall = nurbs::rounded_polygon(
      std::vector<Vec3>{{2, -1, 0}, {2.04, -1, 0}, {2.04, 1, 0}, {2, 1, 0}}, 0.019);
  REQUIRE(wall);
  for (const Integrator integrator : kAll)
    for (const Real start : {0.0, 0.3, 0.7}) {
      INFO(name_of(integrator) << " from " << start);
      OnCurve s = disc_on(integrator, {0.02, {start, 0.3, 0}, {60, 0, 0}},
                          contact_curve(*wall, OuterSide::right));
      Simulation sim(std::move(s.world), {1.0 / 60});
      for (int i = 0; i < 6; ++i) REQUIRE(sim.step().status == Status::ok);
      CHECK(sim.world.bodies[s.disc].pose.position.x <= 1.98 + 1e-8);
    }
}

TEST_CASE("surfaces: a crest that a step flies through is hit") {
  // From trough to trough, one wave a step, 0.03 m below the crest between them.
  const Waves waves{1, 0.06, 8};
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    const Vec3 start{0.5, waves.height - 0.03 + 0.05, 0}, velocity{60, 0, 0};
    OnCurve s = disc_on(integrator, {0.05, start, velocity}, waves.curve());
    Simulation sim(std::move(s.world), {1.0 / 60});
    REQUIRE(sim.step().status == Status::ok);
    const Body& disc = sim.world.bodies[s.disc];
    CHECK(disc.velocity.y > 1);
    CHECK(glm::length(disc.velocity) < 60);
    CHECK(disc.pose.position.y > waves.height + 0.05);
  }
}

TEST_CASE("surfaces: a disc that slides down a round hill leaves it where it weighs nothing") {
  // m v^2 / rho = m g cos, v^2 = v0^2 + 2 g rho (1 - cos): cos = (2 + v0^2 / (g rho)) / 3.
  constexpr Real kHill = 2, kRadius = 0.1, kRho = kHill + kRadius, kStart = 0.5;
  const Real cosine = (2 + kStart * kStart / (kG * kRho)) / 3;
  const Real level = std::sqrt(kG * kRho * cosine) * cosine;  // its speed along x from there
  const auto error_of = [](Integrator integrator) {
    const bool is_exact = integrator == Integrator::rk4 || integrator == Integrator::radau;
    return integrator == Integrator::euler ? 1e-2 : is_exact ? 1e-6 : 1e-4;
  };
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    OnCurve s = disc_on(integrator, {kRadius, {0, kRho, 0}, {kStart, 0, 0}},
                        contact_curve(nurbs::circle({}, kHill), OuterSide::right));
    Simulation sim(std::move(s.world), {1.0 / 240});
    for (int i = 0; i < 336; ++i) REQUIRE(sim.step().status == Status::ok);
    CHECK_FALSE(sim.world.surface_contacts[s.contact].touches);
    CHECK(sim.world.bodies[s.disc].velocity.x == Approx(level).epsilon(error_of(integrator)));
  }
}

TEST_CASE("rings that tumble on a floor stay on it, or their step says that they fit it") {
  constexpr Real kRadius = 0.2, kTube = 0.05;
  const SkinPtr ring = skin_of(nurbs::torus({}, kRadius, kTube));
  for (const Integrator integrator :
       {Integrator::rattle, Integrator::rk4, Integrator::implicit, Integrator::radau}) {
    std::mt19937 random(5);
    std::uniform_real_distribution<Real> some(-1, 1);
    const auto vector = [&] {
      const Real x = some(random), y = some(random), z = some(random);
      return Vec3(x, y, z);
    };
    Real worst = 0;
    for (int n = 0; n < 40; ++n) {
      World w = exact_world(integrator);
      const Entity ground = add_ground(w);
      const Vec3 speed = 2.0 * vector(), spin = 15.0 * vector(), turned = 1.5 * vector();
      Body body = solid(1, {0.012, 0.012, 0.021}, {{0, 0.35, 0}, from_rotation_vector(turned)});
      body.velocity = speed, body.angular_velocity = spin;
      const Entity e = w.add_body(body);
      SurfaceContact& c =
          w.surface_contacts[touch(w, {e, ring, ground, flat_skin(40)}, SurfaceMotion::sliding)];
      c.lifts = true, c.spots = usual_spots(c);
      Simulation sim = Simulation::copy_of(w, {1.0 / 60});
      for (int i = 0; i < 120 && sim.step().status == Status::ok; ++i) {
        const Body& at = sim.world.bodies[e];
        const Real up = (at.pose.rotation * Vec3(0, 0, 1)).y;
        worst = std::min(worst, at.pose.position.y - kTube -
                                    kRadius * std::sqrt(std::max(Real(0), 1 - up * up)));
      }
    }
    INFO(static_cast<int>(integrator));
    CHECK(worst >= -1e-9);
  }
}
