// Claims of the scenes whose surfaces slide and roll on one another.
#include <cmath>

#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

const SurfaceTouch touch_of(const World& w, const char* joint) {
  return surface_touch(w, w.find(joint)).value();
}

/// How fast two bodies slip on one another where they touch, m/s; the world without a name.
Real slip(const World& w, const char* joint, const char* a, const char* b) {
  const SurfaceTouch at = touch_of(w, joint);
  const auto velocity = [&](const char* name) {
    if (!*name) return Vec3(0);
    const Body& body = w.bodies[w.find(name)];
    return body.velocity + glm::cross(body.angular_velocity, at.point - body.pose.position);
  };
  const Vec3 v = velocity(a) - velocity(b);
  return glm::length(v - glm::dot(v, at.normal) * at.normal);
}

}  // namespace

CLAIM("turntable", "the ball's velocity turns at two sevenths of the table's rate") {
  Turns way, table;
  Real worst_speed = 0, speed = 0, worst_slip = 0;
  play("turntable", [&](const World& w) {
    if (w.tick == 0) return;
    const Vec3 v = w.bodies[w.find("ball")].velocity;
    if (speed == 0) speed = glm::length(v);
    worst_speed = std::max(worst_speed, std::abs(glm::length(v) - speed));
    worst_slip = std::max(worst_slip, slip(w, "contact", "ball", "table"));
    way.add(std::atan2(-v.z, v.x));
    const Vec3 x = w.origin_pose(w.find("table")).rotation * Vec3(1, 0, 0);
    table.add(std::atan2(-x.z, x.x));
  });
  CHECK(table.way > 3 * 2 * kPi);
  CHECK(way.way / table.way == Approx(2.0 / 7).epsilon(1e-5));
  CHECK(worst_speed <= 1e-5);
  CHECK(worst_slip <= 1e-11);
}

CLAIM("rolling_links", "the links touch on the line of their pivots, and turn at the ratio there") {
  Real worst_place = 0, worst_ratio = 0, worst_slip = 0;
  Extent ratio;
  Turns left;
  play("rolling_links", [&](const World& w) {
    if (w.tick == 0) return;
    const SurfaceTouch at = touch_of(w, "contact");
    const Real one = w.bodies[w.find("left")].angular_velocity.z,
               two = w.bodies[w.find("right")].angular_velocity.z;
    worst_place = std::max(worst_place, std::abs(at.point.y - 0.5) + std::abs(at.point.z));
    worst_slip = std::max(worst_slip, slip(w, "contact", "left", "right"));
    left.add(angle_of(w, w.find("left")));
    if (std::abs(one) < 0.1) return;
    ratio.add(-two / one);
    worst_ratio = std::max(worst_ratio, std::abs(two * (0.4 - at.point.x) + one * at.point.x));
  });
  CHECK(left.way > 4 * kPi);
  CHECK(worst_place <= 1e-9);
  CHECK(worst_ratio <= 1e-9);
  CHECK(worst_slip <= 1e-9);
  // Of ellipses with half axes 0.2 and 0.15 about their foci.
  const Real focus = std::sqrt(0.2 * 0.2 - 0.15 * 0.15), most = (0.2 + focus) / (0.2 - focus);
  CHECK(ratio.most == Approx(most).epsilon(0.01));
  CHECK(ratio.least == Approx(1 / most).epsilon(0.01));
}

CLAIM("egg_in_bowl", "it rolls without slip for twenty seconds and keeps its energy") {
  Real worst_slip = 0, worst_gap = 0, start = 0, worst_energy = 0;
  Extent x;
  const Played p = play("egg_in_bowl", [&](const World& w) {
    if (w.tick < 2) return;
    const Real energy = measure(w).energy();
    if (start == 0) start = energy;
    worst_energy = std::max(worst_energy, std::abs(energy - start));
    worst_slip = std::max(worst_slip, slip(w, "contact", "egg", ""));
    worst_gap = std::max(worst_gap, std::abs(touch_of(w, "contact").gap));
    x.add(w.bodies[w.find("egg")].pose.position.x);
  });
  CHECK(p.scene.duration == 20);
  CHECK(x.most - x.least > 0.3);
  const Real scale = p.body("egg").mass * 9.81 * 0.1;
  CHECK(worst_energy <= 5e-5 * scale);
  CHECK(worst_slip <= 1e-11);
  CHECK(worst_gap <= 1e-11);
}

CLAIM("rattleback", "spun one way it rocks, stops and turns back; its energy stays") {
  Extent spin;
  Real first = 0, last = 0, start = 0, worst_energy = 0, most_lift = 0;
  const Played p = play("rattleback", [&](const World& w) {
    const Body& stone = w.bodies[w.find("stone")];
    if (w.tick == 1) first = stone.angular_velocity.y, start = measure(w).energy();
    if (w.tick >= 1) worst_energy = std::max(worst_energy, std::abs(measure(w).energy() - start));
    spin.add(stone.angular_velocity.y);
    const Vec3 up = stone.pose.rotation * Vec3(0, 1, 0);
    most_lift = std::max(most_lift, std::acos(std::min(up.y, 1.0)));
    last = stone.angular_velocity.y;
  });
  CHECK(first == Approx(4.57).epsilon(0.01));
  CHECK(last < -4.5);
  CHECK(spin.least == Approx(last).epsilon(0.05));
  CHECK(most_lift > 0.06);
  CHECK(worst_energy <= 2e-4 * start);
}

CLAIM("spatial_cam", "the follower is where the ellipsoid's support says") {
  Real worst = 0, most = 0;
  Extent height;
  int touching = 0, steps = 0;
  play("spatial_cam", [&](const World& w) {
    if (w.tick == 0) return;
    ++steps;
    if (!touch_of(w, "contact").touches) return;
    ++touching;
    const Vec3 n = glm::conjugate(w.bodies[w.find("cam")].pose.rotation) * Vec3(0, 1, 0);
    const Real support = glm::length(Vec3(0.16, 0.1, 0.13) * n);
    const Real found = w.origin_pose(w.find("follower")).position.y - 0.5;
    worst = std::max(worst, std::abs(found - support));
    height.add(found);
    most = std::max(most, std::abs(touch_of(w, "contact").point.z));
  });
  CHECK(touching > 0.9 * steps);
  CHECK(worst <= 1e-9);
  CHECK(height.most - height.least > 0.03);
  CHECK(most > 0.01);  // the contact wanders along the shaft too
}

CLAIM("parking", "no wheel slips while the car is steered to the kerb") {
  Real worst_slip = 0, worst_gap = 0;
  const Played p = play("parking", [&](const World& w) {
    if (w.tick == 0) return;
    for (const char* name : {"front", "left", "right"}) {
      const std::string joint = std::string(name) + "_contact";
      worst_slip = std::max(worst_slip, slip(w, joint.c_str(), name, ""));
      worst_gap = std::max(worst_gap, std::abs(touch_of(w, joint.c_str()).gap));
    }
  });
  CHECK(worst_slip <= 1e-9);
  CHECK(worst_gap <= 1e-9);
  CHECK(p.place("car").x > 4);
  CHECK(p.place("car").z < -1.2);  // it has been steered to its left
  const Vec3 ahead = p.end.origin_pose(p.end.find("car")).rotation * Vec3(1, 0, 0);
  CHECK(std::abs(std::atan2(ahead.z, ahead.x)) < 0.25);
}

CLAIM("knee", "the shin swings on both condyles, held by its ligaments, and comes to rest") {
  Extent angle;
  Real worst_gap = 0;
  const Played p = play("knee", [&](const World& w) {
    if (w.tick == 0) return;
    for (const char* joint : {"inner", "outer"})
      worst_gap = std::max(worst_gap, std::abs(touch_of(w, joint).gap));
    angle.add(angle_of(w, w.find("shin")));
  });
  CHECK(worst_gap <= 1e-11);
  CHECK(angle.most - angle.least > 0.1);
  CHECK(p.place("shin").y > 0.45);
}
