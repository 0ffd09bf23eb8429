// Claims of the scenes about contact.
#include <algorithm>

#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// The farthest that a dynamic body has moved, and aside, m.
struct Moved {
  Real most = 0, aside = 0;
};
Moved moved(const Played& p) {
  Moved m;
  for (std::size_t i = 0; i < p.end.bodies.size(); ++i) {
    if (p.end.bodies.values()[i].motion != Motion::dynamic) continue;
    const Vec3 way =
        p.end.bodies.values()[i].pose.position - p.scene.world.bodies.values()[i].pose.position;
    m.most = std::max(m.most, glm::length(way));
    m.aside = std::max({m.aside, std::abs(way.x), std::abs(way.z)});
  }
  return m;
}

}  // namespace

CLAIM("rolling_ball", "a ball rolls on the flat at constant speed") {
  const Played p = play("rolling_ball");
  CHECK(p.body("ball").velocity.x == Approx(1).epsilon(1e-6));
  CHECK(p.body("ball").angular_velocity.z == Approx(-10).epsilon(1e-6));
  CHECK(p.place("ball").x == Approx(5).epsilon(1e-3));
}

CLAIM("skidding_ball", "a ball skids down a slope until it rolls") {
  const Played p = play("skidding_ball");
  // It grips after 3 / (7/2 mu g cos - g sin) s, and gains 5/7 g sin from then on.
  const Real down = 9.81 * std::sin(20 * kPi / 180), rubs = 0.5 * 9.81 * std::cos(20 * kPi / 180);
  const Real grips = 3 / (3.5 * rubs - down);
  const Real speed = 2.5 * rubs * grips + 5 * down / 7 * (2 - grips);
  CHECK(glm::length(p.body("ball").velocity) == Approx(speed).epsilon(1e-3));
  CHECK(p.body("ball").angular_velocity.z == Approx(-speed / 0.1).epsilon(1e-3));
}

CLAIM("incline", "on 27 degrees a box slides, just steeper than friction holds it") {
  const Played p = play("incline");
  // g (sin 27 - 0.5 cos 27), after 5 s; the slope descends along x.
  const Real speed = 9.81 * (std::sin(27 * kPi / 180) - 0.5 * std::cos(27 * kPi / 180)) * 5;
  CHECK(glm::length(p.body("box").velocity) == Approx(speed).epsilon(0.02));
}

CLAIM("bounce", "a ball that loses nothing comes up as high each time") {
  Extent late;
  const Played p = play("bounce", [&](const World& w) {
    if (w.time > 3.5) late.add(w.bodies[w.find("ball")].pose.position.y);
  });
  CHECK(late.most == Approx(1.1).margin(0.03));
  CHECK(p.most_energy < p.start_energy + 1e-3);
}

CLAIM("two_balls", "a ball hits its like and hands its speed on") {
  const Played p = play("two_balls");
  CHECK(p.body("a").velocity.x == Approx(0).margin(1e-3));
  CHECK(p.body("b").velocity.x == Approx(2).epsilon(1e-3));
}

CLAIM("stack", "ten boxes stay where they are and fall asleep") {
  const Played p = play("stack");
  CHECK(moved(p).aside < 2e-3);
  CHECK(p.last.asleep == 10);
  CHECK(p.worst_depth < 2e-3);
}

CLAIM("stack_askew", "boxes laid askew stand") {
  const Played p = play("stack_askew");
  CHECK(moved(p).most < 0.02);
  CHECK(fastest(p.end) < 0.05);
}

CLAIM("masonry", "what stands without mortar moves by no hair, but for the arch that a ball hits") {
  const auto way = [](const Played& p, const std::string& prefix) {
    Real most = 0;
    for (const Entity e : p.end.bodies.owners())
      if (const std::string* name = p.end.names.find(e); name && name->rfind(prefix, 0) == 0)
        most = std::max(most, glm::distance(p.place(name->c_str()), p.start(name->c_str())));
    return most;
  };
  const Played before = play("masonry", {}, 2.5);
  CHECK(before.last.asleep == 144);  // all but the ball
  for (const char* prefix : {"stone", "brick", "block", "card", "deck"})
    CHECK(way(before, prefix) < 1e-5);
  const Played after = play("masonry");
  CHECK(after.place("stone7").y < 0.5);
  for (const char* prefix : {"block", "card", "deck"}) CHECK(way(after, prefix) < 1e-5);
  CHECK(way(after, "brick") < 1e-2);
}

CLAIM("pyramid", "none of twenty-one boxes moves by a millimetre") {
  const Played p = play("pyramid");
  CHECK(moved(p).most < 1e-3);
  CHECK(fastest(p.end) < 1e-4);
  CHECK(p.worst_depth < 1e-3);
}

CLAIM("balls", "a hundred balls dropped into a bin stay in it, and what they fell with is gone") {
  const Played p = play("balls");
  Extent height, away;
  each_moving(p.end, [&](const Body& b) {
    height.add(b.pose.position.y);
    away.add(std::max(std::abs(b.pose.position.x), std::abs(b.pose.position.z)));
  });
  CHECK((height.least > 0.05 && height.least < 0.2));
  CHECK(away.most < 0.5);
  CHECK(fastest(p.end) < 0.05);
  CHECK(p.worst_depth < 0.04);
}

CLAIM("drape", "a chain dropped over a box and a ball is held there by friction") {
  const Played p = play("drape");
  Real squares = 0;
  int links = 0, over_box = 0, over_ball = 0;
  const Vec3 box = p.place("box"), ball = p.place("ball");
  each_moving(p.end, [&](const Body& b) {
    const Vec3 at = b.pose.position;
    squares += glm::dot(b.velocity, b.velocity), ++links;
    over_box += std::abs(at.x - box.x) < 0.22 && std::abs(at.z - box.z) < 0.25 && at.y > 0.5;
    over_ball += glm::length(at - ball) < 0.42 && at.y > ball.y + 0.28;
  });
  CHECK((over_box >= 8 && over_box <= 11));
  CHECK((over_ball >= 10 && over_ball <= 16));
  CHECK(std::sqrt(squares / links) < 5e-3);
  CHECK(p.worst_depth < 5e-3);
}

CLAIM("curtain", "a ball is driven through ropes, which give way and swing back") {
  constexpr int kRopes = 16;
  Real farthest[kRopes] = {}, now[kRopes] = {};
  World start;
  const Played p = play("curtain", [&](const World& w) {
    if (w.time == 0) start = w;
    for (int i = 0; i < kRopes; ++i) {
      const Entity end = w.find("rope" + std::to_string(i) + "/13");
      now[i] = glm::length(w.bodies[end].pose.position - start.bodies[end].pose.position);
      farthest[i] = std::max(farthest[i], now[i]);
    }
  });
  CHECK(*std::min_element(farthest, farthest + kRopes) > 0.15);
  CHECK(*std::max_element(now, now + kRopes) < 0.05);
  CHECK(p.worst_depth < 0.01);
  CHECK(p.worst_violation < 1e-12);
}

CLAIM("conveyor", "crates are carried along three belts, balls roll back off the second") {
  const std::string things[] = {"crate", "parcel", "ball", "second_ball", "chain/0"};
  Extent along[5], across[5];
  const Played p = play("conveyor", [&](const World& w) {
    for (int i = 0; i < 5; ++i) {
      const Vec3 at = w.bodies[w.find(things[i])].pose.position;
      if (at.y > 0.5) along[i].add(at.x), across[i].add(at.z);
    }
  });
  for (int i = 0; i < 2; ++i) {
    CAPTURE(things[i]);
    CHECK(along[i].most > 3);       // up the second
    CHECK(across[i].least < -2.5);  // and along the third
  }
  for (int i = 2; i < 4; ++i) {
    CAPTURE(things[i]);
    CHECK((along[i].most > 0 && along[i].most < 2));  // beyond the first
  }
  CHECK(along[4].most > 0);  // the chain goes up where its end happens to lie on the second
  CHECK(p.place("ball").x < -1);
}

CLAIM("shapes", "a drum rolls down, a cone round its tip, an egg rocks, a tower stands") {
  Turns round;
  Extent tip, rocking, late;
  const Played p = play("shapes", [&](const World& w) {
    const Pose cone = w.origin_pose(w.find("cone"));
    const Vec3 at = to_world(cone, {0, 0.18, 0});
    tip.add(std::hypot(at.x + 0.35, at.z - 0.9));
    round.add(std::atan2(at.z - cone.position.z, cone.position.x - at.x));
    const Vec3 along = w.origin_pose(w.find("egg")).rotation * Vec3(1, 0, 0);
    (w.time < 2 ? rocking : late).add(std::atan2(along.y, along.x));
  });
  // Once round takes 2 pi / 1.5 s.
  CHECK(std::abs(round.way) > 1.5 * 2 * kPi);
  CHECK(tip.most < 0.03);
  CHECK(rocking.most > 0.4);
  CHECK(rocking.least < -0.3);
  CHECK(late.most < rocking.most);
  // It rolls on over the floor, its axis across its way.
  CHECK(p.place("drum").x > 1.5);
  CHECK(std::abs(p.place("drum").z + 0.9) < 0.01);
  CHECK(p.place("drum").y == Approx(0.15).margin(1e-3));
  for (const char* name : {"tower_1", "tower_2", "tower_3", "roof"}) {
    CAPTURE(name);
    CHECK(glm::distance(p.place(name), p.start(name)) < 2e-3);
  }
  CHECK(p.worst_depth < 5e-3);
}

CLAIM("capstan", "a turn and a half around a drum hold four times the pull, not nine times") {
  const Played p = play("capstan");
  CHECK(std::abs(p.place("holds_heavy").y - p.start("holds_heavy").y) < 0.02);
  CHECK(p.start("slips_heavy").y - p.place("slips_heavy").y > 0.1);
}

CLAIM("falling_chain", "a chain falls in a heap on the floor and lies still") {
  const Played p = play("falling_chain");
  Extent height;
  each_moving(p.end, [&](const Body& b) { height.add(b.pose.position.y); });
  CHECK((height.least > 0 && height.most < 0.1));
  CHECK(fastest(p.end) < 0.05);
}

CLAIM("rope", "two hundred links fall to the floor, all of them above it") {
  const Played p = play("rope");
  Extent height;
  each_moving(p.end, [&](const Body& b) { height.add(b.pose.position.y); });
  CHECK((height.least > 0 && height.most < 0.3));
}

CLAIM("rope_bridge", "crates fall on a rope bridge and are carried") {
  const Played p = play("rope_bridge");
  int carried = 0;
  for (int i = 0; i < 10; ++i) carried += p.place(("crate" + std::to_string(i)).c_str()).y > 0.5;
  CHECK(carried >= 5);
  CHECK(p.start("planks/15").y - p.place("planks/15").y > -0.1);
}

CLAIM("wrecking_ball", "five tonnes on a light chain go through a wall") {
  Real gone = 0;
  const Played p = play("wrecking_ball");
  for (int row = 0; row < 5; ++row)
    for (int i = 0; i < 5; ++i) {
      const std::string block = "b" + std::to_string(row) + "_" + std::to_string(i);
      gone += glm::length(p.place(block.c_str()) - p.start(block.c_str())) > 0.3;
    }
  CHECK(gone >= 10);
  CHECK(glm::length(p.place("ball") - Vec3(0, 6, 0)) < 6);
}

CLAIM("net", "a net of rods catches a ball, every knot shut") {
  const Played p = play("net");
  CHECK((p.place("ball").y > 0.5 && p.place("ball").y < 1.6));
  CHECK(glm::length(p.body("ball").velocity) < 0.5);
}

CLAIM("car", "motors in its wheels drive it over bumps, upright") {
  const Played p = play("car");
  CHECK(p.place("chassis").x > 7.8);  // past the fourth
  CHECK((p.body("chassis").pose.rotation * Vec3(0, 1, 0)).y > 0.9);
}

CLAIM("tank", "a track of 52 links carries it along on driven wheels") {
  const Played p = play("tank");
  CHECK(std::abs(p.place("chassis").x - p.start("chassis").x) > 1);
  CHECK((p.body("chassis").pose.rotation * Vec3(0, 1, 0)).y > 0.9);
  int links = 0;
  for (const Entity e : p.end.bodies.owners()) links += p.end.name_of(e).starts_with("track/");
  CHECK(links == 52);
}

CLAIM("bicycle", "pedals turn the wheel by a closed chain, as the teeth say") {
  Turns wheel;
  const Played p = play("bicycle", [&](const World& w) {
    const Quat q = w.origin_pose(w.find("wheel")).rotation;
    wheel.add(2 * std::atan2(q.z, q.w));
  });
  const Real rise = 1, way = kPi * (rise / 2 + (p.end.time - rise));
  CHECK((way / (2 * kPi) > 2 && way / (2 * kPi) < 4));
  CHECK((wheel.way / way > 1.45 && wheel.way / way < 1.65));
  CHECK(p.worst_residual / 1.2 < 1e-4);
  CHECK(p.worst_depth < 0.01);
}
