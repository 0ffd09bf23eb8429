// Claims of the scenes that are solved in a plane.
#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;

CLAIM("planar_stack", "the wall stands until the ball comes, and then falls") {
  Real swayed = 0;
  Vec3 start{0};
  const Played p = play("planar_stack", [&](const World& w) {
    const Vec3 top = w.origin_pose(w.find("b7_0")).position;
    if (w.time == 0) start = top;
    if (w.time < 1.2) swayed = std::max(swayed, glm::length(top - start));
  });
  CHECK(swayed < 0.01);
  CHECK(p.place("b7_0").y < p.start("b7_0").y - 0.5);
  CHECK(p.worst_depth < 0.03);
  each_moving(p.end, [](const Body& b) { CHECK(b.pose.position.z == 0); });
}

CLAIM("planar_four_bar", "the crank goes round, the rocker swings, and all joints stay closed") {
  Turns crank;
  Extent rocker;
  const Played p = play("planar_four_bar", [&](const World& w) {
    crank.add(angle_of(w, w.find("crank")));
    rocker.add(angle_of(w, w.find("rocker")));
  });
  CHECK(crank.way == Approx(6 * kPi).epsilon(0.05));
  CHECK(rocker.most - rocker.least > 0.5);
  CHECK(rocker.most - rocker.least < 2);
  CHECK(p.worst_gap < 1e-12);
}

CLAIM("planar_belts",
      "the large pulley turns half as fast, with the belt crossed the other way round") {
  Turns turns[4];
  const char* names[] = {"open_small", "open_large", "crossed_small", "crossed_large"};
  play("planar_belts", [&](const World& w) {
    for (int i = 0; i < 4; ++i) turns[i].add(angle_of(w, w.find(names[i])));
  });
  CHECK(turns[0].way > 5 * 2 * kPi);
  CHECK(turns[1].way == Approx(0.5 * turns[0].way).margin(1e-9));
  CHECK(turns[2].way > 5 * 2 * kPi);
  CHECK(turns[3].way == Approx(-0.5 * turns[2].way).margin(1e-9));
}
