// Claims of the scenes after figures 4 to 6 of [Nelson & Cohen].
#include <cmath>

#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// How fast a fingertip slips on the sheet, which is at rest, m/s.
Real slip(const Body& tip, const SurfaceTouch& at) {
  const Vec3 v = tip.velocity + glm::cross(tip.angular_velocity, at.point - tip.pose.position);
  return glm::length(v - glm::dot(v, at.normal) * at.normal);
}

/// The angle between two pieces that yield at their corner, rad.
Real bend_of(const World& w, const std::string& piece) {
  const Quat q = glm::conjugate(w.bodies[w.find(piece)].pose.rotation) *
                 w.bodies[w.find(piece + "_end")].pose.rotation;
  return 2 * std::atan2(q.z, q.w);
}

}  // namespace

CLAIM("fingertips", "three freedoms of a rolling contact: along u, along v, about the normal") {
  const std::string names[] = {"along_u", "along_v", "spins"};
  Extent x[3], z[3], energy;
  Real worst_slip = 0, worst_gap = 0, turned = 0;
  play("fingertips", [&](const World& w) {
    if (w.tick == 0) return;
    Real sum = 0;
    for (int i = 0; i < 3; ++i) {
      const SurfaceTouch at = surface_touch(w, w.find("contact_" + names[i])).value();
      const Body& tip = w.bodies[w.find(names[i])];
      x[i].add(at.point.x), z[i].add(at.point.z);
      worst_slip = std::max(worst_slip, slip(tip, at));
      worst_gap = std::max(worst_gap, std::abs(at.gap));
      const Vec3 own = glm::conjugate(tip.pose.rotation) * tip.angular_velocity;
      sum += 0.5 * tip.mass * glm::dot(tip.velocity, tip.velocity) +
             0.5 * glm::dot(own, tip.inertia * own);
      if (i == 2) turned += 0.005 * glm::dot(tip.angular_velocity, at.normal);
    }
    energy.add(sum);
  });
  CHECK(x[0].most - x[0].least > 0.05);
  CHECK(z[0].most - z[0].least < 0.02 * (x[0].most - x[0].least));
  CHECK(z[1].most - z[1].least > 0.05);
  CHECK(x[1].most - x[1].least < 0.2 * (z[1].most - z[1].least));
  CHECK(turned > 2 * kPi);
  CHECK(std::hypot(x[2].most - x[2].least, z[2].most - z[2].least) < 0.02);
  CHECK(worst_slip <= 1e-11);
  CHECK(worst_gap <= 1e-11);
  CHECK(energy.most - energy.least <= 1e-7 * energy.most);
}

CLAIM("grasped", "a finger at the middle of the coupler leads the linkage round, twice") {
  Turns crank;
  Real worst = 0;
  const Played p = play("grasped", [&](const World& w) {
    crank.add(angle_of(w, w.find("crank")));
    worst = std::max(worst, glm::distance(w.bodies[w.find("coupler")].pose.position,
                                          w.bodies[w.find("finger")].pose.position));
  });
  // The path of the finger is that of the coupler while the crank turns by 130 degrees a second,
  // from rest within the first.
  CHECK(crank.way == Approx(-130 * 5.5 * kPi / 180).margin(0.02));
  CHECK(worst < 5e-3);
  CHECK(p.worst_gap < 1e-12);
  CHECK(p.last.rows == 17);  // of 18: one degree of freedom
  CHECK(p.last.rank == 17);
}

CLAIM("bendy", "six bent pieces hang between two grounds with five degrees of freedom") {
  Extent middle;
  const Played p = play(
      "bendy", [&](const World& w) { middle.add(w.bodies[w.find("piece_3")].pose.position.y); });
  CHECK(middle.most - middle.least > 0.3);
  CHECK(p.most_energy - p.least_energy < 0.02);
  CHECK(p.last.rows == 31);  // of 36
  CHECK(p.last.rank == 31);
  CHECK(p.worst_gap < 1e-12);
}

CLAIM("bendy_flexible", "two pieces yield at their corners, by no more than 25 degrees") {
  Extent one, two;
  const Played p = play("bendy_flexible", [&](const World& w) {
    one.add(bend_of(w, "piece_1")), two.add(bend_of(w, "piece_4"));
  });
  const Real most = 25 * kPi / 180;
  for (const Extent& bend : {one, two}) {
    CHECK(std::max(std::abs(bend.most), std::abs(bend.least)) > 0.8 * most);
    CHECK(std::max(std::abs(bend.most), std::abs(bend.least)) <= most + 1e-6);
  }
  CHECK(p.most_energy <= p.start_energy + 1e-6);
  CHECK(p.worst_gap < 1e-12);
}
