#pragma once
/// Groups that stand on the ground at rest.
#include <catch2/catch.hpp>
#include <vector>

#include "engine/contact/memory.hpp"
#include "engine/runtime/simulation.hpp"
#include "tests/solvers/solids.hpp"

namespace pantin::test {

inline Collision rough(Real friction = 0.5) {
  Collision c;
  c.friction = friction, c.others = true;
  return c;
}

/// N, of all contacts of the ground.
inline Real borne_by_ground(const World& w) {
  Real sum = 0;
  each_contact(w, [&](const Contact& c) {
    if (w.bodies.values()[c.slot_b].motion == Motion::fixed) sum += c.force.y;
  });
  return sum;
}

/// What stands on rough ground.
struct Standing {
  World world;
  Entity ground;
  std::vector<Entity> blocks;
  Collision of;

  explicit Standing(Real friction = 0.5) : of(rough(friction)) { ground = add_ground(world, of); }
  Entity add(Vec3 at, Vec3 half, Real density = 1000, Quat turn = kIdentity) {
    blocks.push_back(add_solid(world, box_shape(half), {at, turn}, Motion::dynamic, of, density));
    return blocks.back();
  }
  /// kg
  Real mass() const {
    Real sum = 0;
    for (const Entity e : blocks) sum += world.bodies[e].mass;
    return sum;
  }
  /// Runs it. The ground has to bear the weight from the fourth step on, until all sleep, if they
  /// may, where they were, but for `most`, m.
  enum class Ends : std::uint8_t { asleep, awake };
  void stays(Real h, Real time, Real most, Ends ends = Ends::asleep) const {
    Simulation sim = Simulation::copy_of(world, {h});
    const World start = sim.world;
    Real borne = 0;
    for (int i = 0; i < std::lround(time / h); ++i) {
      REQUIRE(sim.step().status == Status::ok);
      if (i < 4 || is_asleep(sim.world, blocks.front())) continue;
      borne = borne_by_ground(sim.world);
      CHECK(borne == Approx(9.81 * mass()).epsilon(1e-4));
    }
    CHECK(borne > 0);
    for (const Entity e : blocks) {
      REQUIRE(is_asleep(sim.world, e) == (ends == Ends::asleep));
      REQUIRE(glm::distance(sim.world.bodies[e].pose.position, start.bodies[e].pose.position) <
              most);
    }
  }
};

}  // namespace pantin::test
