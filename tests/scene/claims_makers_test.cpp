// Claims of the scenes whose parts are made by trims, rings, and outlines of machine parts.
#include <cmath>

#include "engine/nurbs/curve_pair.hpp"
#include "engine/nurbs/profiles.hpp"
#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;

CLAIM("trimmed_disc", "one ball leaves the disc at its rim, the other at the edge of its hole") {
  const Real step = 0.005;
  Real out_left = 0, in_left = 0, worst = 0;
  const Played p = play("trimmed_disc", [&](const World& w) {
    const auto on = [&](const char* contact) { return !w.surface_contacts[w.find(contact)].over; };
    const Vec3 out = w.origin_pose(w.find("out")).position,
               in = w.origin_pose(w.find("in")).position;
    if (on("out_on_table")) out_left = out.x, worst = std::max(worst, std::abs(out.y - 1.1));
    if (on("in_on_table")) in_left = in.x, worst = std::max(worst, std::abs(in.y - 1.06));
  });
  // Within the step in which it leaves.
  const Real rim = std::sqrt(0.7 * 0.7 - 0.3 * 0.3), edge = -std::sqrt(0.2 * 0.2 - 0.1 * 0.1);
  CHECK(out_left <= rim + 1e-9);
  CHECK(out_left >= rim - 0.8 * step - 1e-9);
  CHECK(in_left <= edge + 1e-9);
  CHECK(in_left >= edge - 0.6 * step - 1e-9);
  CHECK(worst <= 1e-9);
  CHECK(p.place("out").y < 0.5);
  CHECK(p.place("in").y < 0.9);
}

CLAIM("dominoes", "all stand in a ring, and fall in order") {
  std::array<Real, 24> fell{};
  Real worst = 0;
  const Played p = play("dominoes", [&](const World& w) {
    for (std::size_t i = 0; i < fell.size(); ++i) {
      const Pose at = w.origin_pose(w.find("ring/" + std::to_string(i) + "/block"));
      const Real angle = -15 * kPi / 180 * Real(i);
      const Vec3 meant(0.5 * std::cos(angle), 0.1, -0.5 * std::sin(angle));
      if (w.tick == 0) worst = std::max(worst, glm::distance(at.position, meant));
      const Real up = (at.rotation * Vec3(0, 1, 0)).y;
      if (up < 0.9 && fell[i] == 0) fell[i] = w.time;
    }
  });
  CHECK(worst <= 1e-12);
  CHECK(fell[0] > 0);
  for (std::size_t i = 1; i < fell.size(); ++i) CHECK(fell[i] > fell[i - 1]);
}

CLAIM("gears", "the ratios are those of the teeth, and the flanks stay in touch") {
  using namespace detail::nurbs;
  Teeth pinion, wheel;
  pinion.count = 17, wheel.count = 34;
  const Wire one(*involute_gear(pinion)), two(*involute_gear(wheel));
  Turns turn;
  Real worst_ratio = 0, worst_rack = 0, worst_gap = 0;
  int fewest = 100;
  play("gears", [&](const World& w) {
    const Real angle = angle_of(w, w.find("pinion"));
    turn.add(angle);
    const Real other = angle_of(w, w.find("wheel")) - kPi / 34;
    worst_ratio = std::max(worst_ratio, std::abs(std::remainder(other + turn.way / 2, 2 * kPi)));
    worst_rack =
        std::max(worst_rack, std::abs(w.origin_pose(w.find("rack")).position.x - 0.085 * turn.way));
    if (w.tick % 24 != 0) return;
    const Pose a_in_b =
        compose(inverse(w.origin_pose(w.find("wheel"))), w.origin_pose(w.find("pinion")));
    CurveContact found[24];
    const std::size_t count = find_planar(one, two, a_in_b, {1e-8, found});
    int touches = 0;
    for (std::size_t k = 0; k < count; ++k) {
      if (std::abs(found[k].gap) > 1e-8) continue;
      ++touches, worst_gap = std::max(worst_gap, std::abs(found[k].gap));
    }
    fewest = std::min(fewest, touches);
  });
  CHECK(turn.way > 2.5);
  CHECK(worst_ratio <= 1e-9);
  CHECK(worst_rack <= 1e-10);
  CHECK(fewest >= 2);  // both flanks, without backlash
  CHECK(worst_gap <= 1e-9);
}

CLAIM("cam_law", "the roller follows the polynomial, and rests above and below") {
  detail::nurbs::Cam cam;
  const Real d = kPi / 180;
  cam.law = detail::nurbs::CamLaw::polynomial_345, cam.base = 0.06, cam.roller = 0.02;
  cam.lifts = {{0, 0}, {60 * d, 0}, {170 * d, 0.04}, {210 * d, 0.04}, {330 * d, 0}};
  Real worst = 0;
  Turns turn;
  Extent above, below;
  play("cam_law", [&](const World& w) {
    const Real angle = angle_of(w, w.find("cam"));
    turn.add(angle);
    if (w.tick == 0) return;
    CHECK(surface_touch(w, w.find("lift"))->touches);
    const Real seen = kPi / 2 - angle;  // the direction of the lift, from the cam
    const Real lift = w.origin_pose(w.find("lifter")).position.y - 0.48;
    worst = std::max(worst, std::abs(lift - cam.lift(seen)[0]));
    const Real part = seen < 0 ? seen + 2 * kPi : seen;
    if (part > 171 * d && part < 209 * d) above.add(lift);
    if (part > 1 * d && part < 59 * d) below.add(lift);
  });
  CHECK(turn.way < -3 * kPi);
  CHECK(worst <= 1e-7);
  CHECK(above.most - above.least <= 1e-7);
  CHECK(below.most - below.least <= 1e-7);
  CHECK(above.least == Approx(0.04).margin(1e-7));
}

CLAIM("geneva_six", "the wheel turns as its slot says for a third of the crank's turn, and rests") {
  const Real centres = 0.24, arm = centres / 2, half = kPi / 3;
  Real worst_turn = 0, worst_rest = 0, moving = 0, all = 0;
  Turns crank, wheel;
  play("geneva_six", [&](const World& w) {
    const Real theta = angle_of(w, w.find("crank"));
    crank.add(theta), wheel.add(angle_of(w, w.find("wheel")));
    const Real speed = std::abs(w.bodies[w.find("wheel")].angular_velocity.z);
    ++all, moving += speed > 1e-3;
    const Real along = kPi / 6 + wheel.way;  // of a slot
    if (std::abs(theta) < half - 0.03) {
      const Real pin = kPi - std::atan2(arm * std::sin(theta), centres - arm * std::cos(theta));
      worst_turn = std::max(worst_turn, std::abs(std::remainder(along - pin, kPi / 3)));
    }
    if (std::abs(theta) > half + 0.3)
      worst_rest = std::max(worst_rest, std::abs(std::remainder(along - kPi / 6, kPi / 3)));
  });
  CHECK(crank.way < -2.9 * 2 * kPi);
  CHECK(wheel.way == Approx(3 * kPi / 3).margin(1e-3));
  CHECK(worst_turn <= 1e-9);
  CHECK(worst_rest <= 1e-3);
  CHECK(moving / all == Approx(1.0 / 3).margin(0.02));
}

CLAIM("carousel",
      "all seats swing out by the angle of a conical pendulum, and stay in their ring") {
  const Played p = play("carousel");
  const Real speed = p.body("wheel").angular_velocity.y, arm = 0.5, rod = 0.6;
  // tan(a) = w^2 (arm + rod sin(a)) / g, less the inertia of the seat about its own centre:
  // (m rod^2 + I) w^2 sin(a) cos(a) + m rod arm w^2 cos(a) = m g rod sin(a), I_x = I_y = I_z.
  Real angle = 0.3;
  for (int i = 0; i < 200; ++i)
    angle = std::atan2(speed * speed * (arm + rod * std::sin(angle)), 9.81);
  CHECK(speed == Approx(3).margin(0.05));
  for (int k = 0; k < 6; ++k) {
    const Vec3 at = p.place(("seats/" + std::to_string(k) + "/seat").c_str());
    CHECK(std::hypot(at.x, at.z) == Approx(arm + rod * std::sin(angle)).margin(1e-4));
    CHECK(at.y == Approx(1.2 - rod * std::cos(angle)).margin(1e-4));
  }
}
