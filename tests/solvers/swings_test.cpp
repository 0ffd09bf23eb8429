// Trees of random rods with limits swing freely: each limit is hit at its time, holds while it is
// pressed, and lets go. They go where the Lagrangian solver has them, to second order but for slow
// blows.
#include <catch2/catch.hpp>
#include <random>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/world/ties.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

constexpr int kRods = 4, kRuns = 8;

enum class Limited { stops, universals, cones };
enum class Root { held, free };

struct Dice {
  std::mt19937 random;
  Real any(Real from, Real to) { return std::uniform_real_distribution<Real>(from, to)(random); }
  Vec3 direction() {
    for (;;) {
      const Vec3 v(any(-1, 1), any(-1, 1), any(-1, 1));
      if (const Real l = glm::length(v); l < 1 && l > 0.1) return v / l;
    }
  }
};

Quat to_direction(Vec3 to) { return glm::normalize(Quat(1 + to.x, glm::cross(Vec3(1, 0, 0), to))); }

struct Rod {
  Entity body;
  Vec3 tip{0}, along{0};
  Real length = 0;
  Quat rotation = kIdentity;
};

/// The joint of a rod at its parent's tip, somewhere within its limits.
Joint joint_at(Limited limited, const Rod* parent, const Rod& rod, Dice& dice) {
  Joint j;
  j.anchor_a = {parent ? 0.5 * parent->length : 0, 0, 0}, j.anchor_b = {-0.5 * rod.length, 0, 0};
  const Quat turned = parent ? parent->rotation : kIdentity;
  const Real half = dice.any(0.3, 0.8), off = dice.any(-0.8, 0.8), side = dice.any(-kPi, kPi);
  const Quat axes = to_direction(dice.direction());
  JointLimits limits;
  if (limited == Limited::cones) {
    const Vec3 by = off * half * Vec3(0, std::cos(side), std::sin(side));
    j.frames.set(glm::conjugate(turned) * rod.rotation * from_rotation_vector(by), kIdentity);
    limits.swing = {true, half, half};
  } else {
    j.kind = limited == Limited::stops ? JointKind::hinge : JointKind::universal;
    j.frames.set(glm::conjugate(turned) * axes, glm::conjugate(rod.rotation) * axes);
    limits.angle = {true, -half * (1 + off), half * (1 - off)};
    if (limited == Limited::universals)
      limits.second = {true, -half * (1 - 0.5 * off), half * (1 + 0.5 * off)};
  }
  j.limits = limits;
  return j;
}

/// Rods at the tips of others; the first hangs from a wall, or is free, and all spin.
World tree_of_rods(Limited limited, Root root, unsigned seed) {
  Dice dice{std::mt19937(seed)};
  World w;
  w.default_settings.sleep_speed = 0;
  Body wall;
  wall.motion = Motion::fixed;
  const Entity holder = w.add_body(wall);
  std::vector<Rod> rods;
  for (int i = 0; i < kRods; ++i) {
    const Rod* parent =
        rods.empty() ? nullptr : &rods[dice.random() % static_cast<unsigned>(rods.size())];
    Body b;
    b.drag = 0, b.mass = std::pow(2, dice.any(-1, 1));
    Rod rod;
    rod.length = dice.any(0.2, 0.5);
    const Real r = dice.any(0.02, 0.1) * rod.length,
               across = b.mass * (rod.length * rod.length / 12 + r * r / 4);
    b.inertia = {b.mass * r * r / 2, across, across};
    rod.along = dice.direction();
    if (parent && glm::dot(rod.along, parent->along) < -0.3) rod.along = -rod.along;
    rod.rotation = to_direction(rod.along);
    const Vec3 from = parent ? parent->tip : Vec3(0);
    rod.tip = from + rod.length * rod.along;
    b.pose = {from + 0.5 * rod.length * rod.along, rod.rotation};
    if (root == Root::free) b.angular_velocity = 5.0 * dice.direction();
    rod.body = w.add_body(b);
    if (parent || root == Root::held)
      add_link(w, {parent ? parent->body : holder, rod.body, joint_at(limited, parent, rod, dice)});
    rods.push_back(rod);
  }
  return w;
}

std::vector<Vec3> places_after(World w, int rate, Real time) {
  Simulation sim(std::move(w), {1.0 / rate});
  for (int i = 0; i < std::lround(time * rate); ++i) REQUIRE(sim.step().status == Status::ok);
  std::vector<Vec3> places;
  for (const Body& b : sim.world.bodies.values()) places.push_back(b.pose.position);
  return places;
}

/// Largest distance of a body from where the Lagrangian solver has it, m; the median of all runs.
std::array<Real, 2> median_errors(Limited limited, Root root, Real time = 0.8) {
  constexpr std::array<int, 2> kRates{60, 240};
  std::array<std::vector<Real>, 2> errors;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    World exact = tree_of_rods(limited, root, seed);
    exact.default_settings.solver = Solver::lagrangian;
    const std::vector<Vec3> to = places_after(std::move(exact), 1920, time);
    for (std::size_t k = 0; k < 2; ++k) {
      const std::vector<Vec3> at = places_after(tree_of_rods(limited, root, seed), kRates[k], time);
      Real most = 0;
      for (std::size_t i = 0; i < to.size(); ++i)
        most = std::max(most, glm::distance(at[i], to[i]));
      errors[k].push_back(most);
    }
  }
  std::array<Real, 2> medians{};
  for (std::size_t k = 0; k < 2; ++k) {
    std::sort(errors[k].begin(), errors[k].end());
    medians[k] = 0.5 * (errors[k][kRuns / 2 - 1] + errors[k][kRuns / 2]);
  }
  return medians;
}

}  // namespace

TEST_CASE("trees of hinges with stops swing as the Lagrangian solver has them") {
  for (const Root root : {Root::held, Root::free}) {
    INFO((root == Root::held ? "held" : "free"));
    const auto [coarse, fine] = median_errors(Limited::stops, root);
    CHECK(coarse <= 2e-3);
    CHECK(fine <= 2e-4);
  }
}

TEST_CASE("trees of universal joints with stops swing as the Lagrangian solver has them") {
  const auto [coarse, fine] = median_errors(Limited::universals, Root::free);
  CHECK(coarse <= 2e-3);
  CHECK(fine <= 2e-4);
}

TEST_CASE("free trees of ball joints with cones move as the Lagrangian solver has them") {
  const auto [coarse, fine] = median_errors(Limited::cones, Root::free);
  CHECK(coarse <= 1e-2);
  CHECK(fine <= 1e-3);
}

TEST_CASE("hanging trees of ball joints with cones keep near what the Lagrangian solver has") {
  // Rods that whip round on one another take small errors far: later, half of the runs are chaotic.
  const auto [coarse, fine] = median_errors(Limited::cones, Root::held, 0.5);
  CHECK(coarse <= 6e-3);
  CHECK(fine <= 1.2e-3);
}
