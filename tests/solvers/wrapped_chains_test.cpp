// A chain that a heavy ball pulls taut around an obstacle: closing its joints must not pull the
// links into the obstacle.
#include <catch2/catch.hpp>

#include "engine/contact/contact.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr int kLinks = 14;
constexpr Real kLink = 0.25;  // m

/// A chain of light links on a hook, a ball of 2 t at its end that flies past a post beside the
/// chain, and a row of loose blocks on the post's other side.
World ball_round_post(bool loose) {
  World w;
  Collision how;
  how.friction = 0.3, how.others = true, how.self = false;
  Body hook;
  hook.motion = Motion::fixed;
  Entity before = w.add_body(hook);
  Vec3 there(0);
  for (int i = 0; i < kLinks; ++i) {
    const Shape rod = rod_shape(0.04, kLink / 2);
    const Entity e =
        add_solid(w, rod, {{0, -kLink * (i + 0.5), 0}, kIdentity}, Motion::dynamic, how);
    add_link(w, {before, e, {there, Vec3(0, kLink / 2, 0)}});
    before = e, there = Vec3(0, -kLink / 2, 0);
  }
  const Entity ball = add_solid(w, ball_shape(0.4), {{0, -kLink * kLinks - 0.4, 0}, kIdentity},
                                Motion::dynamic, how, 7800);
  add_link(w, {before, ball, {there, Vec3(0, 0.4, 0)}});
  for (Body& b : w.bodies.values())
    if (b.motion == Motion::dynamic) b.velocity.x = -7 * b.pose.position.y / (kLink * kLinks);
  const Motion motion = loose ? Motion::dynamic : Motion::fixed;
  add_solid(w, box_shape({0.2, 0.3, 0.4}), {{0.3, -2.2, 0}, kIdentity}, motion, how, 500);
  return w;
}

/// m: the largest depth of a contact.
Real deepest(const World& world, Real h) {
  Simulation sim = Simulation::copy_of(world, {h});
  Real most = 0;
  for (int i = 0; i < std::lround(0.8 / h); ++i) {
    REQUIRE(sim.step().status == Status::ok);
    each_contact(sim.world, [&](const Contact& c) { most = std::max(most, c.depth); });
  }
  return most;
}

}  // namespace

TEST_CASE("a chain pulled taut around a post stays out of it but for the impact") {
  struct Case {
    Real h, fixed, loose;  // s, m, m
  };
  for (const auto& [h, fixed, loose] :
       {Case{1.0 / 60, 0.1, 0.02}, Case{1.0 / 240, 0.06, 0.01}, Case{1.0 / 480, 0.012, 0.004}}) {
    CAPTURE(h);
    CHECK(deepest(ball_round_post(false), h) < fixed);
    CHECK(deepest(ball_round_post(true), h) < loose);
  }
}
