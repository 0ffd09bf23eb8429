// Claims of the scenes whose curves slide and roll on one another.
#include <cmath>

#include "engine/nurbs/closest.hpp"
#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;

CLAIM("cam_follower", "face and roller stand where an eccentric circle puts them") {
  const Real radius = 0.1, arm = 0.04, roller = 0.035;
  Real worst_face = 0, worst_roller = 0;
  Turns cam;
  play("cam_follower", [&](const World& w) {
    if (w.tick == 0) return;
    const Real phi = angle_of(w, w.find("cam")), across = arm * std::sin(phi);
    cam.add(phi);
    const Real face = w.origin_pose(w.find("lifter")).position.y - 0.4;
    const Real slide = w.origin_pose(w.find("slide")).position.x;
    const Real reach = radius + roller;
    worst_face = std::max(worst_face, std::abs(face - (radius + arm * std::sin(phi))));
    worst_roller = std::max(
        worst_roller,
        std::abs(slide - (arm * std::cos(phi) + std::sqrt(reach * reach - across * across))));
    CHECK(surface_touch(w, w.find("lift"))->touches);
    CHECK(surface_touch(w, w.find("lift"))->force.y > 0);  // on the follower, which is b
    CHECK(surface_touch(w, w.find("push"))->force.x > 0);
  });
  CHECK(cam.way > 5 * kPi);
  CHECK(worst_face <= 1e-9);
  CHECK(worst_roller <= 1e-9);
}

CLAIM("spline_cam", "the roller stays on the cam, and the arm rests in both dwells") {
  Real worst = 0;
  Extent low, high, all;
  play("spline_cam", [&](const World& w) {
    if (w.tick == 0) return;
    const detail::SurfaceContact& c = w.surface_contacts[w.find("follow")];
    const Vec3 centre = to_world(w.origin_pose(w.find("rocker")), Vec3(0.2, 0, 0));
    const Vec3 in_cam = to_local(w.origin_pose(w.find("cam")), centre);
    const Real distance = detail::nurbs::closest_point(*c.on_a.curve, in_cam).distance;
    worst = std::max(worst, std::abs(distance - 0.025));
    // The way around the cam that looks at the roller, of one turn; its dwells less their ends.
    Real part = std::atan2(in_cam.y, in_cam.x) / (2 * kPi);
    part -= std::floor(part);
    const Real angle = angle_of(w, w.find("rocker"));
    all.add(angle);
    if (part > 0.05 && part < 0.13) low.add(angle);
    if (part > 0.52 && part < 0.59) high.add(angle);
  });
  CHECK(worst <= 1e-12);
  CHECK(all.most - all.least > 0.2);
  CHECK(low.most - low.least < 0.02 * (all.most - all.least));
  CHECK(high.most - high.least < 0.02 * (all.most - all.least));
}

CLAIM("elliptical_gears", "they turn as ellipses about their foci, and keep their energy") {
  const Real e = 0.12 / 0.2, most = (1 + e) / (1 - e);
  Real worst = 0, worst_ratio = 0, worst_place = 0;
  Extent ratio;
  Turns left, right;
  const Played p = play("elliptical_gears", [&](const World& w) {
    const Real one = angle_of(w, w.find("left")), two = angle_of(w, w.find("right"));
    left.add(one), right.add(two);
    const Real meant = 2 * std::atan2(-most * std::sin(one / 2), std::cos(one / 2));
    worst = std::max(worst, std::abs(std::remainder(two - meant, 2 * kPi)));
    const Real r = 0.2 * (1 - e * e) / (1 - e * std::cos(one));
    const Real now =
        w.bodies[w.find("right")].angular_velocity.z / w.bodies[w.find("left")].angular_velocity.z;
    worst_ratio = std::max(worst_ratio, std::abs(now + r / (0.4 - r)));
    ratio.add(-now);
    if (w.tick == 0) return;
    const Vec3 at = surface_touch(w, w.find("mesh"))->point;
    worst_place = std::max(worst_place, std::abs(at.y - 0.5) + std::abs(at.x - r));
  });
  CHECK(left.way > 6 * kPi);
  CHECK(left.way + right.way == Approx(0).margin(2 * kPi));
  CHECK(worst <= 1e-9);
  CHECK(worst_ratio <= 1e-6);
  CHECK(worst_place <= 1e-9);
  CHECK(ratio.most == Approx(most).epsilon(0.01));
  CHECK(ratio.least == Approx(1 / most).epsilon(0.01));
  CHECK((p.most_energy - p.least_energy) / p.start_energy <= 1e-4);
}

CLAIM("geneva", "the pin turns the wheel as its slot says; between, the disc holds it") {
  const Real centres = 0.24, arm = centres * std::sqrt(0.5);
  Real worst_turn = 0, worst_rest = 0, worst_held = 0;
  Turns crank, wheel;
  play("geneva", [&](const World& w) {
    const Real theta = angle_of(w, w.find("crank"));
    crank.add(theta), wheel.add(angle_of(w, w.find("wheel")));
    const Real along = kPi / 4 + wheel.way;  // of a slot
    if (std::abs(theta) < 0.75) {            // of 0.785, where the pin is in the slot
      const Real pin = kPi - std::atan2(arm * std::sin(theta), centres - arm * std::cos(theta));
      worst_turn = std::max(worst_turn, std::abs(std::remainder(along - pin, kPi / 2)));
      return;
    }
    const Real rest = std::abs(std::remainder(along - kPi / 4, kPi / 2));
    if (std::abs(theta) > 0.82) worst_rest = std::max(worst_rest, rest);
    if (std::abs(theta) > 1.1) worst_held = std::max(worst_held, rest);
  });
  CHECK(crank.way < -2.5 * 2 * kPi);
  CHECK(wheel.way == Approx(3 * kPi / 2).margin(1e-3));
  CHECK(worst_turn <= 1e-9);
  CHECK(worst_rest <= 2e-3);
  CHECK(worst_held <= 2e-4);
}

CLAIM("curve_four_bar", "the ellipses roll without slip, the joints stay closed, energy is kept") {
  Real worst_gap = 0, worst_slip = 0;
  Extent crank;
  const Played p = play("curve_four_bar", [&](const World& w) {
    if (w.tick == 0) return;
    const SurfaceTouch at = surface_touch(w, w.find("contact")).value();
    const auto velocity = [&](const char* name) {
      const Body& body = w.bodies[w.find(name)];
      return body.velocity + glm::cross(body.angular_velocity, at.point - body.pose.position);
    };
    worst_slip = std::max(worst_slip, glm::distance(velocity("crank"), velocity("coupler")));
    worst_gap = std::max(worst_gap, std::abs(at.gap));
    crank.add(angle_of(w, w.find("crank")));
  });
  CHECK(crank.most - crank.least > 0.4);
  CHECK(worst_gap <= 1e-12);
  CHECK(worst_slip <= 1e-11);
  CHECK(p.most_energy - p.least_energy <= 3e-5);
}
