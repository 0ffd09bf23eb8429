// Random bodies dropped on a floor with friction, free, joined, limited or tied: as the step falls,
// where they are converges to where the Lagrangian solver has them.
#include <catch2/catch.hpp>
#include <random>

#include "engine/joints/kinds.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr int kRuns = 10, kBodies = 3;
constexpr Real kTime = 0.3;

enum class Held { free, joined, hinged, stopped, limited, tied };
constexpr std::array kHeld{Held::free,    Held::joined,  Held::hinged,
                           Held::stopped, Held::limited, Held::tied};
constexpr std::array kNames{"free", "joined", "hinged", "stopped", "limited", "tied"};

/// Axes at random, limits about where the bodies are.
Joint joint_of(Held held, Quat frame, const Pose& a, const Pose& b) {
  const Vec3 point = 0.5 * (a.position + b.position);
  Joint joint{to_local(a, point), to_local(b, point)};
  if (held == Held::joined) return joint;
  joint.frames.set(glm::conjugate(a.rotation) * frame, glm::conjugate(b.rotation) * frame);
  JointLimits limits;
  if (held == Held::limited) {
    limits.angle = {true, -0.35, 0.35}, limits.swing = {true, 0.26, 0.26};
  } else {
    joint.kind = JointKind::hinge;
    if (held == Held::stopped) limits.angle = {true, -0.26, 0.26};
  }
  joint.limits = limits;
  return joint;
}

World drop(Held held, unsigned seed) {
  std::mt19937 random(seed);
  const auto any = [&](Real from, Real to) {
    return std::uniform_real_distribution<Real>(from, to)(random);
  };
  World w;
  w.default_settings.sleep_speed = 0;
  Collision rough;
  rough.friction = 0.4;
  add_ground(w, rough);
  Entity last;
  Vec3 before(0);
  for (int i = 0; i < kBodies; ++i) {
    const Shape shapes[] = {ball_shape(any(0.05, 0.1)),
                            box_shape({any(0.05, 0.1), any(0.05, 0.1), any(0.05, 0.1)}),
                            rod_shape(any(0.03, 0.06), any(0.05, 0.12))};
    const Quat turned = glm::normalize(Quat(any(-1, 1), any(-1, 1), any(-1, 1), any(-1, 1)));
    const Vec3 at = held == Held::free ? Vec3(any(-0.1, 0.1), 0.25 + 0.3 * i, any(-0.1, 0.1))
                                       : Vec3(0.42 * i, any(0.25, 0.4), any(-0.05, 0.05));
    const Shape& shape = shapes[random() % 3];
    const Entity e = add_solid(w, shape, {at, turned}, Motion::dynamic, rough);
    w.bodies[e].velocity = {0, -1, 0};
    if (i > 0 && held == Held::tied) {
      add_cable(w, {last, e, {Vec3(0), Vec3(0), any(1, 1.1) * glm::distance(at, before)}});
    } else if (i > 0 && held != Held::free) {
      const Quat frame = glm::normalize(Quat(any(-1, 1), any(-1, 1), any(-1, 1), any(-1, 1)));
      add_link(w, {last, e, joint_of(held, frame, w.bodies[last].pose, w.bodies[e].pose)});
    }
    last = e, before = at;
  }
  return w;
}

std::vector<Vec3> places_after(World w, int rate) {
  Simulation sim(std::move(w), {1.0 / rate});
  for (int i = 0; i < std::lround(kTime * rate); ++i) REQUIRE(sim.step().status == Status::ok);
  std::vector<Vec3> places;
  for (const Body& b : sim.world.bodies.values()) places.push_back(b.pose.position);
  return places;
}

}  // namespace

TEST_CASE("random bodies dropped on a floor go where a finer step has them go") {
  constexpr std::array<int, 3> kRates{240, 960, 3840};
  constexpr std::array<Real, 3> kBounds{4e-3, 1e-3, 5e-4};  // m
  // Stops and cones end a blow within their spring, which vanishes with the step more slowly.
  constexpr std::array<Real, 3> kBoundsOfStops{4.5e-3, 2.5e-3, 1.7e-3};
  for (const Held held : kHeld) {
    std::array<std::vector<Real>, 3> errors;
    for (unsigned seed = 1; seed <= kRuns; ++seed) {
      World exact = drop(held, seed);
      exact.default_settings.solver = Solver::lagrangian;
      const std::vector<Vec3> to = places_after(std::move(exact), 7680);
      for (std::size_t k = 0; k < kRates.size(); ++k) {
        const std::vector<Vec3> places = places_after(drop(held, seed), kRates[k]);
        Real most = 0;
        for (std::size_t i = 0; i < to.size(); ++i)
          most = std::max(most, glm::distance(places[i], to[i]));
        errors[k].push_back(most);
      }
    }
    for (std::size_t k = 0; k < kRates.size(); ++k) {
      std::sort(errors[k].begin(), errors[k].end());
      const Real median = 0.5 * (errors[k][kRuns / 2 - 1] + errors[k][kRuns / 2]);
      INFO(kNames[std::size_t(held)] << " at " << kRates[k] << " Hz");
      const bool stops = held == Held::stopped || held == Held::limited;
      CHECK(median <= (stops ? kBoundsOfStops : kBounds)[k]);
    }
  }
}
