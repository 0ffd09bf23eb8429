// Rolling and sliding on bodies whose motion is given.
#include <catch2/catch.hpp>

#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81, kRadius = 0.1;

/// A ball on a table that is moved along a path.
struct Led {
  World world;
  Entity table, ball, contact;
};
Led on_table(Integrator integrator, const KinematicPath& path, SurfaceMotion motion) {
  Led s{exact_world(integrator), {}, {}, {}};
  Body table;
  table.motion = Motion::kinematic, table.pose = pose_at(path, 0);
  s.table = s.world.add_body(table);
  s.world.paths.add(s.table, path);
  s.ball = s.world.add_body(solid_ball(2, kRadius, {0.5, kRadius, 0}));
  s.contact = touch(s.world, {s.ball, ball_skin(Vec3(kRadius)), s.table, flat_skin(20)}, motion);
  return s;
}

void run(Simulation& sim, Real time) {
  const int steps = static_cast<int>(std::lround(time / sim.settings.h));
  for (int i = 0; i < steps; ++i) REQUIRE(sim.step().status == Status::ok);
}

KinematicPath turning(Real rate) {
  SteadyMotion path;
  path.angular_velocity = {0, rate, 0};
  return {path};
}

/// A table that rises and falls by a half, 1 Hz.
constexpr Real kRise = 0.05, kRate = 2 * kPi;
KinematicPath rising() {
  Lissajous path;
  path.amplitude = {0, kRise, 0}, path.frequency = {0, 1, 0};
  return {path};
}

/// Of a ball on a turntable after 2 s: its velocity turns at 2/7 of the table's rate.
Real error_on_turntable(Integrator integrator, Real rate, Real h) {
  Led s = on_table(integrator, turning(rate), SurfaceMotion::rolling);
  const Vec3 v(0.2, 0, 0.4);
  const Vec3 slip = v - glm::cross(Vec3(0, rate, 0), Vec3(0.5, 0, 0));
  s.world.bodies[s.ball].velocity = v;
  s.world.bodies[s.ball].angular_velocity = glm::cross(Vec3(0, 1, 0), slip) / kRadius;
  Simulation sim(std::move(s.world), {h});
  run(sim, 2);
  const Real own = 2.0 / 7 * rate, turn = own * 2;
  const Real sine = std::sin(turn) / own, cosine = (1 - std::cos(turn)) / own;
  const Vec3 way(sine * v.x + cosine * v.z, 0, sine * v.z - cosine * v.x);
  return glm::distance(sim.world.bodies[s.ball].pose.position, Vec3(0.5, kRadius, 0) + way);
}

}  // namespace

TEST_CASE("led surfaces: a ball on a table that turns steadily goes round at 2/7 of its rate") {
  for (const Real rate : {3.0, -6.0}) {
    CHECK(error_on_turntable(Integrator::rk4, rate, 0.01) <= 5e-8);
    CHECK(error_on_turntable(Integrator::radau, rate, 0.01) <= 1e-8);
    for (const Integrator second : {Integrator::rattle, Integrator::implicit}) {
      INFO(name_of(second) << ", " << rate);
      const Real coarse = error_on_turntable(second, rate, 0.01),
                 fine = error_on_turntable(second, rate, 0.005);
      CHECK(fine <= 1e-3);
      CHECK(std::log2(coarse / fine) == Approx(2).margin(0.25));
    }
  }
}

TEST_CASE("led surfaces: a ball on a table that rises keeps its roll and bears its acceleration") {
  for (const Integrator integrator : kAll)
    for (const SurfaceMotion motion : {SurfaceMotion::rolling, SurfaceMotion::sliding}) {
      INFO(name_of(integrator) << " " << static_cast<int>(motion));
      Led s = on_table(integrator, rising(), motion);
      Body& start = s.world.bodies[s.ball];
      start.velocity = {0.3, kRise * kRate, 0};
      if (motion == SurfaceMotion::rolling) start.angular_velocity = {0, 0, -0.3 / kRadius};
      const Real h = 0.005;
      Simulation sim(std::move(s.world), {h});
      for (int i = 1; i <= 300; ++i) {
        REQUIRE(sim.step().status == Status::ok);
        const Real t = i * h, height = kRise * std::sin(kRate * t);
        const Body& b = sim.world.bodies[s.ball];
        REQUIRE(std::abs(b.pose.position.y - kRadius - height) <= 1e-11);
        REQUIRE(std::abs(b.velocity.x - 0.3) <= 1e-9);
        // The mean over the step: of the velocity's change.
        if (i == 1 || integrator == Integrator::euler) continue;
        const Real lifts =
            kRise * kRate * (std::cos(kRate * t) - std::cos(kRate * (t - h))) / h + kG;
        REQUIRE(-sim.world.surface_contacts[s.contact].force.y == Approx(2 * lifts).epsilon(5e-3));
      }
      CHECK(sim.world.bodies[s.ball].pose.position.x == Approx(0.5 + 0.3 * 1.5).epsilon(1e-9));
    }
}

TEST_CASE(
    "led surfaces: a ball on a table that falls faster than it leaves it and meets it again") {
  Lissajous path;  // 0.3 m, 1 Hz: 11.8 m/s^2 at the top
  path.amplitude = {0, 0.3, 0}, path.frequency = {0, 1, 0};
  Led s = on_table(Integrator::rk4, {path}, SurfaceMotion::rolling);
  s.world.surface_contacts[s.contact].lifts = true;
  s.world.bodies[s.ball].velocity = {0, 0.3 * kRate, 0};
  Simulation sim(std::move(s.world), {0.001});
  Real left = 0, lowest = 1;
  for (int i = 0; i < 1000; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    const Real height = 0.3 * std::sin(kRate * sim.world.time);
    lowest = std::min(lowest, sim.world.bodies[s.ball].pose.position.y - kRadius - height);
    if (left == 0 && !sim.world.surface_contacts[s.contact].touches) left = sim.world.time;
  }
  // Where the table's deceleration exceeds g: sin(kRate t) = g / (0.3 kRate^2).
  CHECK(left == Approx(std::asin(kG / (0.3 * kRate * kRate)) / kRate).margin(2e-3));
  CHECK(lowest >= -1e-8);
  CHECK(sim.world.surface_contacts[s.contact].touches);
}

TEST_CASE("led surfaces: a copy of the World goes on with the same bits") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    Led s = on_table(integrator, rising(), SurfaceMotion::rolling);
    s.world.bodies[s.ball].velocity = {0.3, 0, 0.1};
    Simulation sim(std::move(s.world), {0.01});
    run(sim, 0.3);
    Simulation copy = Simulation::copy_of(sim.world, sim.settings);
    run(sim, 0.3), run(copy, 0.3);
    CHECK(state_hash(sim.world) == state_hash(copy.world));
  }
}
