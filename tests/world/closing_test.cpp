// Joints that close loops: which of them hold more than the point that a tree of bodies leaves
// them.
#include "engine/world/closing.hpp"

#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

#include "engine/solvers/takeover.hpp"
#include "engine/world/scope.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

const Vec3 kCorners[] = {{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}};

/// Four bars in a ring, the first of them fixed if `grounded`.
struct Ring {
  World world;
  std::vector<Entity> bars;

  explicit Ring(bool grounded) {
    for (int i = 0; i < 4; ++i)
      bars.push_back(
          world
              .add(RigidBody{.motion = grounded && i == 0 ? Motion::fixed : Motion::dynamic,
                             .shape = SphereShape{0.1},
                             .position = 0.5 * (kCorners[i] + kCorners[(i + 1) % 4])})
              .value());
  }
  Entity bar(int i) const { return bars[static_cast<std::size_t>(i % 4)]; }
  Entity hinge(int i, Vec3 axis = {0, 0, 1}, std::optional<Interval> limits = {}) {
    return world
        .add(HingeJoint{.a = bar(i),
                        .b = bar(i + 1),
                        .anchor = kCorners[(i + 1) % 4],
                        .axis = axis,
                        .limits = limits})
        .value();
  }
  Entity fix(int i) {
    return world.add(FixedJoint{.a = bar(i), .b = bar(i + 1), .anchor = kCorners[(i + 1) % 4]})
        .value();
  }
  Entity ball(int i) {
    return world.add(BallJoint{.a = bar(i), .b = bar(i + 1), .anchor = kCorners[(i + 1) % 4]})
        .value();
  }
  std::vector<Entity> closing() const {
    std::vector<Entity> found;
    for (const std::uint32_t i : list_closing(world, Scope::all(world).links))
      found.push_back(world.links.owners()[i]);
    return found;
  }
};

}  // namespace

TEST_CASE("a loop of parallel hinges, of fixed joints or with a ball joint loses nothing") {
  for (const bool grounded : {false, true}) {
    CAPTURE(grounded);
    Ring hinges(grounded), fixed(grounded), with_ball(grounded);
    with_ball.ball(0);
    for (int i = 0; i < 4; ++i) {
      hinges.hinge(i), fixed.fix(i);
      if (i > 0) with_ball.hinge(i, {1, 0, 0});
    }
    CHECK(hinges.closing().empty());
    CHECK(fixed.closing().empty());
    CHECK(with_ball.closing().empty());
    CHECK(check(hinges.world).empty());
  }
}

TEST_CASE(
    "a loop that needs the axis, the limits or the kind of the joint that closes it tells it") {
  for (const bool grounded : {false, true}) {
    CAPTURE(grounded);
    Ring askew(grounded), limited(grounded), mixed(grounded), some(grounded);
    for (int i = 0; i < 4; ++i) {
      askew.hinge(i, i == 2 ? Vec3(1, 0, 0) : Vec3(0, 0, 1));
      limited.hinge(i, {0, 0, 1}, Interval{-1, 1});
      if (i < 3) some.hinge(i, {0, 0, 1}, Interval{-1, 1});
      mixed.fix(i);
    }
    some.hinge(3);
    CHECK(askew.closing().size() == 1);
    CHECK(limited.closing().size() == 1);
    CHECK(some.closing().empty());  // trees take up those with limits first
    mixed.world.destroy(mixed.world.links.owners()[0]);
    mixed.ball(0);
    CHECK(mixed.closing().empty());
    // "auto" leaves what it would lose to the solver that holds it, and says so.
    Simulation sim = Simulation::copy_of(askew.world);
    REQUIRE(sim.step().status == Status::ok);
    const std::vector<std::string> told = lines_beyond_auto(sim.world);
    REQUIRE(told.size() == 1);
    CHECK(told.front().find("is stepped by lagrangian") != std::string::npos);
  }
}
