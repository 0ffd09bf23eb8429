// Pendulums that bounce, off a wall and in a row: impacts of restitution 1 keep energy.
#include <catch2/catch.hpp>

#include "engine/world/ties.hpp"
#include "tests/solvers/exact.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kRadius = 0.05, kLength = 0.5;

Collision elastic() {
  Collision c;
  c.friction = 0, c.restitution = 1;
  return c;
}

/// A ball that hangs from a hinge at `x`, turned back by an angle.
Entity hang(World& w, Entity ceiling, Real x, Real angle) {
  const Quat turned = glm::angleAxis(-angle, Vec3(0, 0, 1));
  const Vec3 anchor(x, 0, 0);
  const Entity e =
      add_solid(w, ball_shape(kRadius), {anchor + turned * Vec3(0, -kLength, 0), turned},
                Motion::dynamic, elastic());
  const Joint hinge = joint_at(w, ceiling, e, JointKind::hinge, anchor, frame_along({0, 0, 1}));
  add_link(w, {ceiling, e, hinge});
  return e;
}

}  // namespace

TEST_CASE("pendulums that bounce off one another or a wall keep their energy") {
  for (const bool wall : {false, true})
    for (const int rate : {60, 240, 960})
      for (const Real angle : {0.3, 0.7, 1.2}) {
        World w;
        w.default_settings.sleep_speed = 0;
        Body fixed;
        fixed.motion = Motion::fixed;
        const Entity ceiling = w.add_body(fixed);
        const Entity first = hang(w, ceiling, 0, angle);
        if (wall)
          add_solid(w, box_shape({0.5, 2, 0.5}), {{kRadius + 0.5 + 0.1, 0, 0}, kIdentity},
                    Motion::fixed, elastic());
        for (int i = 1; !wall && i < 5; ++i) hang(w, ceiling, 2 * kRadius * i, 0);
        const Real mass = w.bodies[first].mass;
        Simulation sim(std::move(w), {1.0 / rate});
        const Real start = measure(sim.world).energy();
        const Real swing = mass * 9.81 * kLength * (1 - std::cos(angle));
        Real most = 0;
        for (int i = 0; i < 6 * rate; ++i) {
          REQUIRE(sim.step().status == Status::ok);
          most = std::max(most, (measure(sim.world).energy() - start) / swing);
        }
        INFO((wall ? "wall, " : "row, ") << rate << " Hz, " << angle << " rad");
        const Real end = (measure(sim.world).energy() - start) / swing;
        UNSCOPED_INFO(most << " " << end);
        CHECK(most < 1e-3);
        CHECK(end > (rate == 60 ? -0.02 : -0.005));
      }
}
