// Claims of the scenes that are solved in a plane.
#include "engine/solvers/planar/island.hpp"
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
  const Played p = play("planar_belts", [&](const World& w) {
    for (int i = 0; i < 4; ++i) turns[i].add(angle_of(w, w.find(names[i])));
  });
  CHECK(turns[0].way > 5 * 2 * kPi);
  CHECK(turns[1].way == Approx(0.5 * turns[0].way).margin(1e-9));
  CHECK(turns[2].way > 5 * 2 * kPi);
  CHECK(turns[3].way == Approx(-0.5 * turns[2].way).margin(1e-9));
  // 2 D cos b + pi (r + R) + 2 (R - r) b, sin b = (R - r) / D; crossed with R + r.
  const detail::Belt &open = p.end.belts[p.end.find("open_belt")],
                     &crossed = p.end.belts[p.end.find("crossed_belt")];
  const Real b = std::asin(0.25 / 1.5), a = std::asin(0.75 / 1.5);
  CHECK(open.length == Approx(3 * std::cos(b) + 0.75 * kPi + 0.5 * b).epsilon(1e-12));
  CHECK(crossed.length == Approx(3 * std::cos(a) + 0.75 * (kPi + 2 * a)).epsilon(1e-12));
  CHECK(open.travel == Approx(0.25 * turns[0].way).epsilon(1e-6));
}

CLAIM("planar_serpentine",
      "all pulleys run, the pump the other way round, and the belt keeps its length as the "
      "tensioner swings") {
  const char* names[] = {"crank", "alternator", "pump", "steering"};
  const Real radii[] = {0.3, 0.14, 0.22, 0.2};
  Turns turns[4];
  Extent arm;
  Real length = 0, off = 0, least = 1e9;
  play("planar_serpentine", [&](const World& w) {
    for (int i = 0; i < 4; ++i) turns[i].add(angle_of(w, w.find(names[i])));
    arm.add(angle_of(w, w.find("arm")));
    const detail::Belt& belt = w.belts[w.find("belt")];
    if (w.time == 0) length = belt.length;
    off = std::max(off, std::abs(belt.length - length));
    if (w.time > 0.5)
      for (const detail::BeltPulley& p : belt.pulleys) least = std::min(least, p.tension);
  });
  CHECK(std::abs(turns[0].way) > 5 * 2 * kPi);
  // The belt passes from one to the next; spans that swing add a little to what it has run.
  for (int i = 1; i < 4; ++i)
    CHECK((i == 2 ? -1 : 1) * turns[i].way * radii[i] ==
          Approx(turns[0].way * radii[0]).epsilon(0.01));
  CHECK(off < 1e-9);
  CHECK(arm.most - arm.least > 0.01);
  CHECK(least > 0);
}

CLAIM("planar_bicycle", "the chain of links drives its wheel as the ideal belt does") {
  Turns turns[4];
  const char* names[] = {"belt_pedals", "belt_wheel", "chain_pedals", "chain_wheel"};
  const Played p = play("planar_bicycle", [&](const World& w) {
    for (int i = 0; i < 4; ++i) turns[i].add(angle_of(w, w.find(names[i])));
  });
  CHECK(turns[1].way == Approx(2 * turns[0].way).margin(1e-9));
  CHECK(std::abs(turns[3].way) > 2 * 2 * kPi);
  CHECK(turns[3].way == Approx(2 * turns[2].way).epsilon(0.1));
  CHECK(turns[3].way == Approx(turns[1].way).epsilon(0.1));
  CHECK(p.worst_gap < 1e-10);
}

CLAIM("puppet_crank",
      "a puppet of space turns a crank of a belt; a cam of the plane runs beside it") {
  Turns crank, wheel;
  Real worst_face = 0;
  const Played p = play("puppet_crank", [&](const World& w) {
    crank.add(angle_of(w, w.find("crank"))), wheel.add(angle_of(w, w.find("wheel")));
    const Real phi = angle_of(w, w.find("cam"));
    const Real face = w.origin_pose(w.find("follower")).position.y - 0.85;
    if (w.tick > 0) worst_face = std::max(worst_face, std::abs(face - 0.1 - 0.04 * std::sin(phi)));
  });
  CHECK(crank.way > 2.5 * 2 * kPi);
  CHECK(wheel.way == Approx(0.15 / 0.28 * crank.way).margin(1e-9));
  CHECK(worst_face < 1e-9);
  CHECK(p.worst_gap < 1e-11);
  // Both models stand side by side: two bodies of the plane, and the puppet's island in space.
  const auto& plane = p.end.memory.of<detail::planar::Planar>();
  CHECK(plane.mechanisms.size() == 1);
  CHECK(plane.mechanisms.front().bodies.size() == 2);
}
