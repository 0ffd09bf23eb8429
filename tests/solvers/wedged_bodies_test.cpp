// Bodies that an impact has wedged into others are parted and fall asleep.
#include <catch2/catch.hpp>

#include "engine/contact/contact.hpp"
#include "tests/base/random.hpp"
#include "tests/solvers/standing.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// Bodies above one another over a bin.
struct Bin {
  World world;
  Real size;  // m
  std::vector<Entity> bodies;
  Collision how = rough();
  Random random;

  Bin(Real of, std::uint64_t seed) : size(of), random(seed) {
    add_ground(world, how);
    for (const int side : {-1, 1}) {
      add_wall({2.1 * side, 1.5, 0}, {0.1, 1.5, 2.2});
      add_wall({0, 1.5, 2.1 * side}, {2.2, 1.5, 0.1});
    }
  }
  void add_wall(Vec3 at, Vec3 half) {
    add_solid(world, box_shape(size * half), {size * at, kIdentity}, Motion::fixed, how);
  }
  Real half() { return random.between(0.3, 0.5) * size; }
  void drop(const Shape& shape) {
    const Real x = random.between(-1.3, 1.3), z = random.between(-1.3, 1.3);
    const Vec3 at(x, 0.6 + 0.9 * static_cast<Real>(bodies.size()), z);
    const Quat turn = random.orientation();
    bodies.push_back(add_solid(world, shape, {size * at, turn}, Motion::dynamic, how));
    world.bodies[bodies.back()].drag = 0.1;
  }
};

Shape box_of(Bin& bin) {
  const Real half = bin.half();
  return box_shape({half, half * bin.random.between(0.6, 1), half * bin.random.between(0.6, 1)});
}
Shape plate_of(Bin& bin) {
  const Real half = bin.half();
  return box_shape({half, 0.2 * half, half});
}

/// m: the deepest overlap.
Real deepest(const World& world) {
  Real most = 0;
  for (const Contact& c : contacts_of(world)) most = std::max(most, c.depth);
  return most;
}

}  // namespace

TEST_CASE("boxes and plates that fall into a bin come apart and fall asleep") {
  struct Case {
    Shape (*shape)(Bin&);
    Real size;       // m
    Real asleep_by;  // s
    Real deep;       // of the size, when the first half of them is asleep
  };
  for (const Case& c : {Case{box_of, 0.1, 8, 0.01}, Case{plate_of, 0.1, 10, 0.01},
                        Case{box_of, 1, 10, 2e-3}, Case{plate_of, 1, 10, 5e-3}})
    for (const std::uint64_t seed : {2, 3}) {
      CAPTURE(c.size, c.asleep_by, seed);
      Bin bin(c.size, seed);
      for (int i = 0; i < 40; ++i) bin.drop(c.shape(bin));
      Simulation simulation(std::move(bin.world), {.h = 1.0 / 60});
      StepReport report;
      Real deep = 0;
      for (int i = 0; i < 60 * c.asleep_by && report.asleep < 40; ++i) {
        report = simulation.step();
        REQUIRE(report.status == Status::ok);
        if (report.asleep < 20) deep = deepest(simulation.world);
      }
      CHECK(report.asleep == 40);
      CHECK(deep < c.deep * c.size);
    }
}
