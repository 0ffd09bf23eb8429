// Claims of the scenes of the exact solver.
#include <optional>

#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// Of the four-bar linkage, m.
constexpr Real kCrank = 0.25, kCoupler = 0.75, kRocker = 0.6, kGround = 0.8, kUp = 0.8;

/// The coupler's far end for a crank angle, by the two circles it lies on.
Vec3 far_end(Real angle) {
  const Vec3 tip(kCrank * std::cos(angle), kCrank * std::sin(angle), 0);
  const Vec3 away = Vec3(kGround, 0, 0) - tip;
  const Real d = glm::length(away);
  const Real open =
      std::acos((kCoupler * kCoupler + d * d - kRocker * kRocker) / (2 * kCoupler * d));
  const Real rotation = std::atan2(away.y, away.x) + open;
  return tip + kCoupler * Vec3(std::cos(rotation), std::sin(rotation), 0) + Vec3(0, kUp, 0);
}

}  // namespace

CLAIM("double_pendulum", "energy sways a little for twenty seconds and never drifts") {
  const Played p = play("double_pendulum");
  CHECK(p.scene.duration == 20);
  CHECK(p.most_energy - p.start_energy < 0.02);
  CHECK(p.start_energy - p.least_energy < 0.2);
  CHECK(p.worst_gap < 1e-12);
}

CLAIM("four_bar", "a motor turns the crank; the coupler's far end is where geometry says") {
  Turns crank;
  Real worst_place = 0;
  const Played p = play("four_bar", [&](const World& w) {
    const Real angle = angle_of(w, w.find("crank"));
    crank.add(angle);
    const Vec3 found = to_world(w.origin_pose(w.find("coupler")), {kCoupler / 2, 0, 0});
    worst_place = std::max(worst_place, glm::length(found - far_end(angle)));
  });
  CHECK(worst_place < 2e-9);
  CHECK((crank.way / (2 * kPi) > 2.5 && crank.way / (2 * kPi) < 3.1));
  CHECK(p.worst_gap < 1e-12);
  CHECK(p.last.rows - p.last.rank == 3);
}

CLAIM("slider_crank", "where the piston is follows from the crank's angle") {
  constexpr Real kArm = 0.3, kRod = 0.8;
  Turns crank;
  Real worst_place = 0;
  const Played p = play("slider_crank", [&](const World& w) {
    const Real angle = angle_of(w, w.find("crank")), across = kArm * std::sin(angle);
    crank.add(angle);
    const Real place = kArm * std::cos(angle) + std::sqrt(kRod * kRod - across * across);
    const Real found = w.origin_pose(w.find("piston")).position.x;
    worst_place = std::max(worst_place, std::abs(found - place));
  });
  CHECK(worst_place < 2e-9);
  CHECK((crank.way / (2 * kPi) > 2.8 && crank.way / (2 * kPi) < 3.5));
  CHECK(p.worst_gap < 1e-12);
}

CLAIM("bricard",
      "six hinges hold thirty freedoms of five rods with one row too many, and it moves") {
  Real way = 0;
  std::optional<World> before;
  const Played p = play("bricard", [&](const World& w) {
    if (before)
      for (std::size_t i = 0; i < w.bodies.size(); ++i)
        way = std::max(way, glm::length(w.bodies.values()[i].pose.position -
                                        before->bodies.values()[i].pose.position));
    if (!before) before = w;
  });
  CHECK(way > 0.3);
  CHECK(p.most_energy - p.least_energy < 4e-3);
  CHECK(p.worst_gap < 1e-12);
  CHECK(p.last.rows == 30);
  CHECK(p.last.rank == 29);
}

CLAIM("stewart", "a plate on six legs with springs is pushed and comes back") {
  Real farthest = 0;
  Vec3 start(0), end(0);
  const Played p = play("stewart", [&](const World& w) {
    end = w.bodies[w.find("platform")].pose.position;
    if (start == Vec3(0)) start = end;
    farthest = std::max(farthest, glm::distance(end, start));
  });
  CHECK(farthest > 0.02);
  // It sinks by its weight over the springs, and is upright again.
  CHECK(glm::length(Vec3(end.x, 0, end.z)) < 1e-2);
  CHECK(end.y < 1.2);
  CHECK(end.y > 1.15);
  CHECK(p.worst_gap < 1e-11);
  CHECK(p.last.rank == p.last.rows);
}

CLAIM("n_four_bar", "ten windows stay parallel through positions where they lose rank") {
  Turns first;
  Real worst_angle = 0;
  const Played p = play("n_four_bar", [&](const World& w) {
    const Real angle = angle_of(w, w.find("post0"));
    first.add(angle);
    for (int i = 1; i < 11; ++i) {
      const Real other = angle_of(w, w.find("post" + std::to_string(i)));
      worst_angle = std::max(worst_angle, std::abs(std::remainder(other - angle, 2 * kPi)));
    }
  });
  CHECK(worst_angle < 1e-6);
  CHECK((-first.way / (2 * kPi) > 1 && -first.way / (2 * kPi) < 20));
  CHECK(p.most_energy - p.start_energy < 1e-2);
  CHECK(p.start_energy - p.least_energy < 1e-2);
  CHECK(p.worst_gap < 1e-12);
}

CLAIM("spinning_top", "it walks around as the closed form for fast tops says") {
  Turns around;
  const Played p = play("spinning_top", [&](const World& w) {
    const Vec3 at = w.origin_pose(w.find("top")).position;
    around.add(std::atan2(-at.z, at.x));
  });
  const Real rate = 0.5 * 9.81 * 0.12 / (0.0036 * 150);  // precession m g h / (I3 w3)
  CHECK(around.way / (rate * p.end.time) == Approx(1.025).margin(0.075));
  CHECK(p.most_energy - p.least_energy < 4e-5);
  CHECK(p.worst_gap < 1e-11);
}

CLAIM("gate", "a rope and the gate it is tied to feel each other") {
  Real farthest = 0, pulled = 0;
  const Played p = play("gate", [&](const World& w) {
    const Vec3 corner = to_world(w.origin_pose(w.find("gate")), {0.6, 0.45, 0});
    const Vec3 out = w.bodies[w.find("rope/13")].pose.position - corner;
    farthest = std::max(farthest, std::hypot(out.x, out.z));
    if (w.time == 0) return;
    if (const auto force = pin_force(w, w.find("knot")))
      pulled = std::max(pulled, glm::length(*force));
  });
  CHECK((farthest > 0.1 && farthest < 1));
  CHECK((pulled > 1 && pulled < 60));
  CHECK(p.worst_residual < 1e-4);
  CHECK(p.worst_gap < 1e-11);
  CHECK(std::abs(p.body("gate").angular_velocity.y) < 1.6);
}

CLAIM("chain_1000", "a thousand links are held at both ends until one lets go") {
  Real held = 0;
  // To the end it takes half a minute; what is new happens at 1 s.
  const Played p = play(
      "chain_1000",
      [&](const World& w) {
        if (w.time < 1.0001) held = w.bodies[w.find("chain/999")].pose.position.y;
      },
      1.15);
  CHECK(p.scene.world.pins.size() == 2);
  CHECK(p.end.pins.size() == 1);
  CHECK(held == Approx(p.start("chain/999").y).margin(1e-2));
  CHECK(held - p.place("chain/999").y > 0.05);
  CHECK(p.most_energy - p.start_energy < 1e-6);
  CHECK(p.last.rows == 3000);
  CHECK(p.worst_gap < 1e-12);
}

CLAIM("crane", "the hook rises by half of what the winch hauls in, on half of the load") {
  Extent height, tension;
  const Played p = play("crane", [&](const World& w) {
    if (w.time < 5.6 || w.time > 6.9) return;  // hauled in; the crate swings a little
    height.add(w.origin_pose(w.find("hook")).position.y);
    tension.add(cable_tension(w, w.find("hoist")));
  });
  const Real load = (p.body("hook").mass + p.body("crate").mass) * 9.81;
  const Real hauled = 12.013 - 9;
  CHECK(height.least > p.start("hook").y + hauled / 2 - 0.01);
  CHECK(height.most < p.start("hook").y + hauled / 2 + 0.06);
  CHECK((tension.least > 0.45 * load && tension.most < 0.55 * load));
  CHECK(p.place("hook").y < height.least - 0.6);
  CHECK(p.worst_residual < 1e-9);
}
