// Few bodies that tumble over one another with friction: their sweeps are extrapolated where
// they converge steadily (extrapolation.hpp), which must neither add energy nor leave them in the
// ground.
#include <catch2/catch.hpp>

#include "tests/base/random.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// Boxes and balls that are thrown at the ground, and at one another.
World thrown(std::uint64_t seed) {
  Random dice(seed);
  World w;
  Collision how;
  how.friction = dice.between(0, 1), how.restitution = dice.below(2) == 0 ? 0 : 0.8;
  add_ground(w, how);
  const int count = 2 + dice.below(6);
  for (int i = 0; i < count; ++i) {
    const Real size = dice.between(0.03, 0.15);
    const bool is_ball = dice.below(4) == 0;
    const Shape shape = is_ball ? ball_shape(size) : box_shape(size * dice.in_box(0.5, 2));
    const Pose at{{0, 0.7 + 0.9 * i, 0}, dice.rotation()};
    Body& b = w.bodies[add_solid(w, shape, at, Motion::dynamic, how)];
    b.velocity = dice.in_cube(1) - Vec3(0, 1 + 3 * i, 0), b.angular_velocity = dice.in_cube(8);
  }
  return w;
}

}  // namespace

TEST_CASE("few bodies that tumble over one another gain no energy, at any step") {
  for (const Real h : {1.0 / 30, 1.0 / 60, 1.0 / 240})
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      CAPTURE(h, seed);
      Simulation sim = Simulation::copy_of(thrown(seed), {h});
      const Real first = measure(sim.world).energy();
      Real most = first;
      for (int i = 0; i < std::lround(3 / h); ++i) {
        REQUIRE(sim.step().status == Status::ok);
        most = std::max(most, measure(sim.world).energy());
      }
      CHECK(most <= 1.001 * first);
      for (std::size_t i = 1; i < sim.world.bodies.size(); ++i)
        CHECK(sim.world.bodies.values()[i].pose.position.y > 0.01);
    }
}
