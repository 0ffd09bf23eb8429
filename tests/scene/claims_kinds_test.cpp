// Claims of the scenes that show all kinds of joints, an umbrella, and parts that never meet.
#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kDegree = kPi / 180;

}  // namespace

CLAIM("joint_kinds", "each part keeps what its joint holds, and has the freedoms that it leaves") {
  Real worst_driven = 0, worst_held = 0;
  Turns screw;
  const Played p = play("joint_kinds", [&](const World& w) {
    const auto place = [&](const char* name) { return w.origin_pose(w.find(name)).position; };
    const auto driven = [&](Real x) { worst_driven = std::max(worst_driven, std::abs(x)); };
    const auto held = [&](Real x) { worst_held = std::max(worst_held, std::abs(x)); };
    const Real wave = std::sin(kPi * w.time);
    screw.add(joint_angle(w, w.find("screw_joint")));
    driven(joint_angle(w, w.find("hinge_joint")) - 50 * kDegree * wave);
    driven(place("prismatic").x + 1 - 0.12 * wave);
    driven(joint_travel(w, w.find("cylindrical_joint")) - 0.12 * wave);
    driven(screw.way - 160 * kDegree * w.time);
    held(joint_travel(w, w.find("screw_joint")) - 0.02 * screw.way);
    held(glm::distance(place("distance"), place("distance_base")) - std::hypot(0.12, 0.2));
    held(place("planar").z - 0.03);
    held(glm::distance(place("fixed"), Vec3(0.5, 1.02, 0)));
    held(glm::distance(place("ball"), Vec3(-1, 1.125, 0)) - 0.115);
    const Vec3 shaft = place("universal") - place("universal_base");
    held(glm::distance(shaft, Vec3(0.03, 0, 0)) - std::hypot(0.09, 0.02));
  });
  CHECK(worst_driven < 1e-10);
  CHECK(worst_held < 1e-10);
  CHECK(p.place("ball").z != p.start("ball").z);
  CHECK(p.place("spring").y < p.start("spring").y);
  // The plate leaves its part a rotation and two travels, without a force.
  CHECK(glm::distance(p.place("planar") - p.start("planar"), Vec3(0.032, 0.04, 0)) < 1e-10);
  CHECK(p.body("planar").angular_velocity.z == Approx(2));
  CHECK(glm::length(p.body("cylindrical").angular_velocity) < 1e-12);
}

CLAIM("umbrella", "eight stretchers hold the ribs where the runner says, from 20 to 80 degrees") {
  Real worst = 0;
  Extent angles;
  const Played p = play("umbrella", [&](const World& w) {
    // Rib and stretcher make an isosceles triangle with the stick, its equal sides 0.2 m.
    const Real runner = w.origin_pose(w.find("runner")).position.y;
    const Real angle = std::acos((1 - runner) / 0.4);
    angles.add(angle);
    const Vec3 meant(0.02 + 0.25 * std::sin(angle), 1 - 0.25 * std::cos(angle), 0);
    for (int i = 0; i < 8; ++i) {
      const Vec3 at = w.origin_pose(w.find("ribs/" + std::to_string(i) + "/rib")).position;
      const Vec3 found(std::hypot(at.x, at.z), at.y, 0);
      worst = std::max(worst, glm::distance(found, meant));
    }
  });
  CHECK(worst < 1e-10);
  CHECK(angles.least == Approx(20 * kDegree).margin(1e-9));
  CHECK(angles.most == Approx(80 * kDegree).margin(1e-9));
}

CLAIM("apart", "linkage and boxes are solved in the plane, the marionette in space") {
  Turns crank;
  const Played p =
      play("apart", [&](const World& w) { crank.add(angle_of(w, w.find("linkage/crank"))); });
  const auto solver_of = [&](const char* body) {
    const SolverSettings* own = p.end.settings.find(p.end.find(body));
    return own ? own->solver : p.end.default_settings.solver;
  };
  CHECK(solver_of("linkage/crank") == Solver::planar);
  CHECK(solver_of("boxes/b9") == Solver::planar);
  CHECK(solver_of("puppet/pantin/head") == Solver::articulated);
  CHECK(crank.way == Approx(4 * kPi).epsilon(0.03));  // its motor asks for half a turn a second
  Real moved = 0;
  for (int i = 0; i < 10; ++i) {
    const std::string box = "boxes/b" + std::to_string(i);
    moved = std::max(moved, glm::distance(p.place(box.c_str()), p.start(box.c_str())));
  }
  CHECK(moved < 1e-3);
  CHECK(p.place("puppet/pantin/head").y > 0.8 * p.start("puppet/pantin/head").y);
}
