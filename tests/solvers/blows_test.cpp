// Bodies that touch and are struck: what they do follows from one complementarity problem.
#include <catch2/catch.hpp>
#include <random>

#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr int kBalls = 7;
constexpr Real kRadius = 0.05;

/// Balls of which each touches one or two others.
std::vector<Vec3> touching_balls(std::mt19937& random) {
  std::uniform_real_distribution<Real> any(0, 1);
  std::normal_distribution<Real> bell;
  std::vector<Vec3> at{Vec3(0)};
  while (at.size() < kBalls) {
    const auto pick = [&] { return at[std::size_t(any(random) * Real(at.size()))]; };
    const Vec3 p = pick(), q = pick();
    const Real d = glm::distance(p, q);
    Vec3 aside(bell(random), bell(random), bell(random));
    Vec3 found = p + 2 * kRadius * glm::normalize(aside);
    if (d > 0) {
      if (d > 3.99 * kRadius) continue;
      aside -= glm::dot(aside, q - p) / (d * d) * (q - p);
      found = 0.5 * (p + q) + std::sqrt(4 * kRadius * kRadius - d * d / 4) * glm::normalize(aside);
    }
    if (std::all_of(at.begin(), at.end(),
                    [&](Vec3 o) { return glm::distance(o, found) > 2 * kRadius - 1e-12; }))
      at.push_back(found);
  }
  return at;
}

/// The velocities of least kinetic energy without approach: impulses by projected Gauss-Seidel.
std::vector<Vec3> velocities_after(const std::vector<Vec3>& at, std::vector<Vec3> v,
                                   const std::vector<Real>& masses) {
  struct Touch {
    std::size_t i, j;
    Real impulse;
  };
  std::vector<Touch> touches;
  for (std::size_t i = 0; i < at.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (glm::distance(at[i], at[j]) < 2 * kRadius + 1e-9) touches.push_back({i, j, 0});
  for (int sweep = 0; sweep < 20000; ++sweep)
    for (Touch& t : touches) {
      const Vec3 n = glm::normalize(at[t.i] - at[t.j]);
      const Real give = 1 / masses[t.i] + 1 / masses[t.j];
      const Real now = std::max(Real(0), t.impulse - glm::dot(n, v[t.i] - v[t.j]) / give);
      v[t.i] += (now - t.impulse) / masses[t.i] * n, v[t.j] -= (now - t.impulse) / masses[t.j] * n;
      t.impulse = now;
    }
  return v;
}

}  // namespace

TEST_CASE("seven balls that touch, of which one is struck, move with least kinetic energy") {
  std::mt19937 random(7);
  for (int run = 0; run < 12; ++run) {
    const std::vector<Vec3> at = touching_balls(random);
    std::vector<Vec3> v(kBalls, Vec3(0));
    std::vector<Real> masses;
    for (int i = 0; i < kBalls; ++i) masses.push_back(0.5 + 1.5 * Real(random() % 1000) / 1000);
    Vec3 middle(0);
    for (const Vec3 p : at) middle += p / Real(kBalls);
    v[0] = 2.0 * glm::normalize(middle - at[0] + Vec3(1e-3, 2e-3, 0));
    const std::vector<Vec3> exact = velocities_after(at, v, masses);
    for (const Real h : {1e-5, 1.0 / 960}) {
      World w;
      w.gravity = Vec3(0), w.default_settings.sleep_speed = 0;
      Collision smooth;
      smooth.friction = 0;
      std::vector<Entity> balls;
      for (std::size_t i = 0; i < at.size(); ++i) {
        balls.push_back(
            add_solid(w, ball_shape(kRadius), {at[i], kIdentity}, Motion::dynamic, smooth));
        w.bodies[balls[i]].mass = masses[i], w.bodies[balls[i]].velocity = v[i];
      }
      Simulation sim(std::move(w), {h});
      REQUIRE(sim.step().status == Status::ok);
      for (std::size_t i = 0; i < at.size(); ++i) {
        INFO("run " << run << ", ball " << i << ", " << h << " s");
        CHECK(glm::length(sim.world.bodies[balls[i]].velocity - exact[i]) <= 1e-6 * 2);
      }
    }
  }
}

// A shot is decided by where the balls touch, not by where they were when the step began.
TEST_CASE("a ball struck off its middle goes along the line of centres, at every rate") {
  constexpr Real kRadius = 0.03, kSpeed = 5;
  for (const Solver solver : {Solver::articulated, Solver::lagrangian})
    for (const Real restitution : {0.0, 0.5, 1.0})
      for (const Real aside : {0.0, 0.4, 1.0, 1.6})
        for (const int rate : {30, 60, 240, 960}) {
          World w;
          w.gravity = Vec3(0), w.default_settings.solver = solver;
          Collision smooth;
          smooth.friction = 0, smooth.restitution = restitution;
          const Entity a =
              add_solid(w, ball_shape(kRadius), {{-0.5, 0, 0}, kIdentity}, Motion::dynamic, smooth);
          const Entity b = add_solid(w, ball_shape(kRadius), {{0, 0, aside * kRadius}, kIdentity},
                                     Motion::dynamic, smooth);
          w.bodies[a].velocity = {kSpeed, 0, 0};
          Simulation sim(std::move(w), {1.0 / rate});
          for (int i = 0; i < rate / 5; ++i) REQUIRE(sim.step().status == Status::ok);
          const Real sine = aside / 2, cosine = std::sqrt(1 - sine * sine);
          const Vec3 to = 0.5 * (1 + restitution) * kSpeed * cosine * Vec3(cosine, 0, sine);
          INFO(name_of(solver) << ", e " << restitution << ", aside " << aside << ", " << rate);
          CHECK(glm::distance(sim.world.bodies[b].velocity, to) <= 2e-3 * kSpeed);
          CHECK(glm::distance(sim.world.bodies[a].velocity, Vec3(kSpeed, 0, 0) - to) <=
                2e-3 * kSpeed);
        }
}

TEST_CASE("a ball that passes another one closely is not turned away") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian})
    for (const int rate : {30, 60, 240}) {
      World w;
      w.gravity = Vec3(0), w.default_settings.solver = solver;
      const Entity a = add_solid(w, ball_shape(0.03), {{-0.5, 0, 0}, kIdentity}, Motion::dynamic);
      const Entity b = add_solid(w, ball_shape(0.03), {{0, 0, 0.061}, kIdentity}, Motion::dynamic);
      w.bodies[a].velocity = {5, 0, 0};
      Simulation sim(std::move(w), {1.0 / rate});
      for (int i = 0; i < rate / 5; ++i) REQUIRE(sim.step().status == Status::ok);
      INFO(name_of(solver) << " at " << rate << " Hz");
      CHECK(glm::length(sim.world.bodies[b].velocity) <= 1e-12);
      CHECK(glm::distance(sim.world.bodies[a].velocity, Vec3(5, 0, 0)) <= 1e-12);
    }
}
