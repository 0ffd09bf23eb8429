// Claims of the scenes of motors and exact drives.
#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;

CLAIM("lamp", "motors without a gain hold the arms within a third of a degree and move them") {
  constexpr Real kDegree = kPi / 180;
  const auto asked = [&](Real t, Real from, Real to, Real at) {
    return (from + (to - from) * std::clamp(t - at, Real(0), Real(1))) * kDegree;
  };
  Real worst_held = 0, worst = 0;
  const Played p = play("lamp", [&](const World& w) {
    const Real t = w.time;
    const Real elbow = t < 4 ? asked(t, 0, -40, 1) : asked(t, -40, 20, 4);
    const Real off[] = {joint_angle(w, w.find("base")) - asked(t, 0, -30, 2.5),
                        joint_angle(w, w.find("elbow")) - elbow,
                        joint_angle(w, w.find("neck")) - asked(t, 0, 40, 1)};
    const bool held = (t > 0.2 && t < 1) || (t > 2.2 && t < 2.5) || t > 5.2;
    for (const Real x : off) {
      worst = std::max(worst, std::abs(x));
      if (held) worst_held = std::max(worst_held, std::abs(x));
    }
  });
  CHECK(worst_held < kDegree / 3);
  CHECK(worst < 3 * kDegree);
  CHECK(fastest(p.end) < 1e-3);
  // The base bears the torque of all weights beyond it.
  Real torque = 0;
  for (const char* name : {"lower", "upper", "head"}) {
    const Body& b = p.body(name);
    torque += 9.81 * b.mass * b.pose.position.x;
  }
  CHECK(motor_force(p.end, p.end.find("base")) == Approx(torque).epsilon(1e-3));
}

CLAIM("driven_crank", "the piston follows from the time alone, to rounding") {
  constexpr Real kArm = 0.3, kRod = 0.8, kStart = 50 * kPi / 180;
  Real worst = 0, wrong_stroke = 0;
  const Played p = play("driven_crank", [&](const World& w) {
    const Real angle = kStart + 4 * w.time, across = kArm * std::sin(angle);
    const Real place = kArm * std::cos(angle) + std::sqrt(kRod * kRod - across * across);
    const Real found = w.origin_pose(w.find("piston")).position.x;
    // The file has nine digits.
    worst = std::max(worst, std::abs(found - place));
  });
  CHECK(worst < 2e-9);
  Scene scene = p.scene;
  REQUIRE(scene.sensors.size() == 2);
  const Real stroke = read_sensor(p.end, scene.sensors[1]).x;
  wrong_stroke = std::abs(stroke - p.place("piston").x);
  CHECK(wrong_stroke < 1e-9);
  CHECK(read_sensor(p.end, scene.sensors[0]).x == motor_force(p.end, p.end.find("shaft")));
  CHECK(p.worst_gap < 1e-12);
}

CLAIM("cam_drives", "lifts of two laws of cams and of a spline, with dwells") {
  Real worst = 0, most = 0;
  play("cam_drives", [&](const World& w) {
    const Real t = std::fmod(w.time, 2);
    const auto lift = [&](auto law) {
      const Real u = t < 0.5 ? 2 * t : t < 1 ? 1 : t < 1.5 ? 2 * (1.5 - t) : 0;
      return 0.2 * law(u);
    };
    const auto off = [&](const char* body, Real x) {
      worst = std::max(worst, std::abs(w.origin_pose(w.find(body)).position.y - 0.2 - x));
    };
    off("cycloidal", lift([](Real u) { return u - std::sin(2 * kPi * u) / (2 * kPi); }));
    off("polynomial", lift([](Real u) { return u * u * u * (10 - 15 * u + 6 * u * u); }));
    const Real spline = w.origin_pose(w.find("spline")).position.y - 0.2;
    most = std::max(most, spline);
    if (std::abs(std::remainder(t, 0.5)) < 1e-6) off("spline", t > 0.4 && t < 1.1 ? 0.2 : 0);
  });
  CHECK(worst < 1e-12);
  // Its rates at the corners are 0.3 m/s: L / 8 (0.3 + 0.3) above the dwell.
  CHECK(most == Approx(0.2375).epsilon(1e-4));
}
