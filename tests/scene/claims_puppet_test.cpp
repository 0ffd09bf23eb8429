// Claims of the scenes with puppets and marionettes.
#include <algorithm>
#include <optional>

#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

Real height(const World& w, const char* body) { return w.bodies[w.find(body)].pose.position.y; }

/// Twenty stairs of 0.17 m by 0.29 m, the top one at x = 0: height of what is below `x`.
Real stairs_below(Real x) {
  constexpr Real kRise = 0.17, kRun = 0.29;
  return std::clamp(std::ceil(20 - x / kRun), Real(0), Real(20)) * kRise;
}

}  // namespace

CLAIM("stairs", "a puppet is pushed down twenty stairs, tumbles to the floor and comes to rest") {
  Extent above;
  Real passed = -1, moved = -1;  // s
  const Played p = play("stairs", [&](const World& w) {
    each_moving(w, [&](const Body& b) {
      above.add(b.pose.position.y - stairs_below(b.pose.position.x));
      if (glm::length(b.velocity) > 0.05) moved = w.time;
    });
    if (passed < 0 && w.bodies[w.find("puppet/pelvis")].pose.position.x > 20 * 0.29)
      passed = w.time;
  });
  CHECK((passed > 1 && passed < 4));
  CHECK(moved - passed < 5);
  CHECK(above.least > 0.01);
  CHECK(p.worst_depth < 0.03);
  CHECK(p.worst_violation < 1e-12);
}

CLAIM("stairs_five", "five puppets fall on the landing above stairs and lie still") {
  const Played p = play("stairs_five");
  int on_landing = 0;
  for (const char* pelvis : {"r0/pelvis", "r1/pelvis", "r2/pelvis", "r3/pelvis", "r4/pelvis"}) {
    CAPTURE(pelvis);
    CHECK(p.start(pelvis).y - p.place(pelvis).y > 0.7);
    on_landing += p.place(pelvis).y > 3.4;
  }
  CHECK(on_landing >= 3);
  CHECK(fastest(p.end) < 0.4);  // an arm may hang over the edge and swing
  CHECK(p.worst_depth < 0.06);
}

CLAIM("standing", "a puppet stands by its muscles, bears a push and falls after a harder one") {
  Real before = 0, lowest = 1, after = 0;  // m, height of the pelvis
  const Played p = play("standing", [&](const World& w) {
    const Real now = height(w, "puppet/pelvis");
    if (w.time < 2.001) before = now;
    if (w.time > 2 && w.time < 5.2) lowest = std::min(lowest, now), after = now;
  });
  const Real start = height(p.scene.world, "puppet/pelvis");
  CHECK(before / start == Approx(1).margin(0.05));
  CHECK(lowest / start > 0.9);
  CHECK(after / start == Approx(1).margin(0.05));
  CHECK(height(p.end, "puppet/pelvis") / start < 0.4);
  CHECK(p.worst_depth < 0.01);
  CHECK(p.worst_violation < 1e-12);
}

CLAIM("bridge", "a marionette is led over a hanging bridge, whose planks give way under its feet") {
  Extent planks, aside;
  Real middle_at_rest = 0, middle_lowest = 1e300, off_pin = 0;
  int carried = 0;  // steps with a foot on a plank
  std::optional<ContactEvents> contacts;
  const Played p = play("bridge", [&](const World& w) {
    for (int i = 0; i < 17; ++i) {
      const Vec3 at = w.bodies[w.find("planks/" + std::to_string(i))].pose.position;
      planks.add(at.y), aside.add(std::abs(at.z));
    }
    const Real middle = height(w, "planks/8");
    if (w.time < 1) middle_at_rest = middle;
    middle_lowest = std::min(middle_lowest, middle);
    for (const Pin& pin : w.pins.values()) off_pin = std::max(off_pin, pin.residual);
    if (!contacts) contacts.emplace(w);
    const auto is_carried = [&](const ContactEvent& e) {
      return e.impulse != Vec3(0) && w.bodies[e.a].motion == Motion::dynamic &&
             w.bodies[e.b].motion == Motion::dynamic;
    };
    const auto events = contacts->update(w);
    carried += std::any_of(events.begin(), events.end(), is_carried);
  });
  CHECK((p.place("pantin/pelvis").x > 1.05 && p.place("pantin/pelvis").x < 1.4));
  CHECK((p.place("pantin/pelvis").y > 0.88 && p.place("pantin/pelvis").y < 1.0));
  CHECK(carried > 100);
  CHECK((middle_at_rest - middle_lowest > 0.001 && middle_at_rest - middle_lowest < 0.1));
  CHECK((planks.least > 0.3 && planks.most < 0.6));
  CHECK(aside.most < 0.05);
  CHECK(off_pin < 2e-4);
  CHECK(p.worst_depth < 0.01);
}

CLAIM("marionette", "it walks on its two feet and waves with a hand, all cables as long as ever") {
  Extent left, right, hand, head;
  const Played p = play("marionette", [&](const World& w) {
    left.add(height(w, "pantin/foot_l")), right.add(height(w, "pantin/foot_r"));
    hand.add(height(w, "pantin/hand_r")), head.add(height(w, "pantin/head"));
    if (w.time == 0) hand = Extent{}, hand.add(height(w, "pantin/hand_r"));
  });
  CHECK(left.most - left.least > 0.02);
  CHECK(right.most - right.least > 0.02);
  CHECK(hand.most - hand.least > 0.1);
  CHECK(head.most - head.least < 0.1);
  CHECK(p.worst_residual < 1e-3);
}

CLAIM("crowd", "a hundred marionettes, each at its own moment of the walk") {
  const Played p = play("crowd", {}, 1.5);
  std::set<Real> feet;
  for (int i = 0; i < 100; ++i)
    feet.insert(height(p.end, ("crowd/" + std::to_string(i) + "/foot_l").c_str()));
  CHECK(feet.size() == 100);
  CHECK(p.worst_residual < 1e-3);
}

CLAIM("overlap", "two puppets that start within each other are pushed apart gently") {
  Real most = 0;
  const Played p = play("overlap", [&](const World& w) {
    if (w.time < 0.3) most = std::max(most, fastest(w));
  });
  CHECK(most < 5);
  CHECK(p.last.worst_depth < 0.02);
}

CLAIM("hit", "a truck takes a puppet along") {
  const Played p = play("hit");
  CHECK(p.place("r/pelvis").x - p.start("r/pelvis").x > 4);
  CHECK(p.worst_violation < 1e-12);
}

CLAIM("tow", "a puppet follows the car by its hand") {
  const Played p = play("tow");
  CHECK(p.place("r/pelvis").x - p.start("r/pelvis").x > 3);
  CHECK(p.place("car").x - p.start("car").x == Approx(4.5));
}

CLAIM("heap", "twenty puppets lie in a heap, none fell through the floor or away") {
  const Played p = play("heap");
  Extent heights, away;
  each_moving(p.end, [&](const Body& b) {
    heights.add(b.pose.position.y), away.add(glm::length(b.pose.position));
  });
  CHECK(heights.least > 0);
  CHECK(heights.most > 0.4);
  CHECK(away.most < 6);
  CHECK(p.last.contacts > 100);
  CHECK(fastest(p.end) < 1.5);
}
