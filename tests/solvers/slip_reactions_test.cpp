// Reactions of blades that hold and that slide: against closed forms.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

#include "tests/solvers/sleighs.hpp"

using namespace pantin;
using namespace pantin::test;

TEST_CASE("reactions: a blade that holds bears side forces, and centripetal force on a circle") {
  // On a circle of radius u / w the force is m u w across the heading; the mean force of a step is
  // given along the blade at its end.
  constexpr Real kSpeed = 1.5, kRate = 2, kSide = 3, kStep = 0.01;
  const Real centripetal = kMass * kSpeed * kRate;
  struct Case {
    Integrator integrator;
    Real bound;  // N
  };
  for (const auto& [integrator, bound] :
       {Case{Integrator::euler, 0.4}, Case{Integrator::rattle, 1e-3},
        Case{Integrator::implicit, 1e-3}, Case{Integrator::rk4, 1e-8},
        Case{Integrator::radau, 1e-9}}) {
    Sleigh turns = sleigh(integrator, 0), stands = sleigh(integrator, 0, {0, 0, kSide});
    turns.world.bodies[turns.body].velocity = {kSpeed, 0, 0};
    turns.world.bodies[turns.body].angular_velocity = kRate * kUp;
    Simulation turning(std::move(turns.world), {kStep}), standing(std::move(stands.world), {kStep});
    Real worst = 0;
    for (int i = 0; i < 300; ++i) {
      REQUIRE(turning.step().status == Status::ok);
      REQUIRE(standing.step().status == Status::ok);
      const Vec3 inwards = turning.world.bodies[turns.body].pose.rotation * Vec3(0, 0, -1);
      const auto on_turning = joint_reaction(turning.world, turns.skate),
                 on_standing = joint_reaction(standing.world, stands.skate);
      REQUIRE(on_turning);
      REQUIRE(on_standing);
      worst = std::max(worst, glm::distance(on_turning->force, centripetal * inwards));
      CHECK(glm::length(on_turning->torque) <= 1e-9);
      CHECK(glm::distance(on_standing->force, Vec3(0, 0, -kMass * kSide)) <= 1e-11);
    }
    INFO(name_of(integrator) << ": " << worst << " N of " << centripetal);
    CHECK(worst <= bound);
  }
}

TEST_CASE("reactions: a blade holds on its circle up to mu N, then slides with mu N outwards") {
  constexpr Real kFriction = 0.4, kWeight = 9.81, kRate = 2, kStep = 0.005;
  const Real most = kFriction * kMass * kWeight;
  for (const Integrator integrator : kAll)
    for (const Real share : {0.98, 1.05}) {  // of the friction that there is
      INFO(name_of(integrator) << ", " << share);
      Sleigh s = loaded_sleigh(integrator, {0, -kWeight, 0}, kFriction);
      const Real speed = share * kFriction * kWeight / kRate;
      s.world.bodies[s.body].velocity = {speed, 0, 0};
      s.world.bodies[s.body].angular_velocity = kRate * kUp;
      Simulation sim(std::move(s.world), {kStep});
      for (int i = 0; i < 40; ++i) {
        REQUIRE(sim.step().status == Status::ok);
        const auto reaction = joint_reaction(sim.world, s.skate);
        REQUIRE(reaction);
        const Real force = glm::length(reaction->force);
        const Real slip = sideways_at_blade(sim.world, s.body, 0);
        if (share < 1) {
          const bool slows = integrator == Integrator::euler;
          CHECK(force == Approx(kMass * speed * kRate).epsilon(slows ? 3e-3 : 1e-3));
          CHECK(std::abs(slip) <= 1e-7);
        } else if (i > 0) {
          CHECK(force == Approx(most).epsilon(1e-4));
          CHECK(slip > 0);  // outwards, which is to the right of a left turn
        }
      }
    }
}

TEST_CASE(
    "slips: the reaction of a sliding blade is mu times the load of the table that carries it") {
  // The table moves by A sin(wt), so the mean load of a step is m (g + its change of speed / h).
  constexpr Real kG = 10, kSide = 8, kFriction = 0.5, kA = 0.1, kRate = 6, kStep = 0.005;
  for (const Integrator integrator : kAll) {
    Sleigh s = loaded_sleigh(integrator, {0, -kG, kSide}, kFriction);
    Lissajous path;
    path.amplitude = {0, kA, 0}, path.frequency = {0, kRate / (2 * kPi), 0};
    s.world.bodies[s.ground].motion = Motion::kinematic;
    s.world.paths.add(s.ground, {path});
    s.world.bodies[s.body].velocity = {0, kA * kRate, 1};
    Simulation sim(std::move(s.world), {kStep});
    Real worst = 0;
    for (int i = 0; i < 200; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      const Real end = kRate * sim.world.time;
      const Real gained = kA * kRate * (std::cos(end) - std::cos(end - kRate * kStep));
      const Vec3 exact(0, 0, -kFriction * kMass * (kG + gained / kStep));
      const auto reaction = joint_reaction(sim.world, s.skate);
      REQUIRE(reaction);
      if (i > 0) worst = std::max(worst, glm::distance(reaction->force, exact));
    }
    INFO(name_of(integrator) << ": " << worst << " N");
    // The multipliers of `implicit` are those of another time of the step.
    CHECK(worst <= (integrator == Integrator::implicit ? 0.1 : 1e-9));
  }
}
