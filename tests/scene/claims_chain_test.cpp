// Claims of the scenes with chains, and of other jointed things that touch nothing.
#include <algorithm>

#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kDegree = kPi / 180;

/// Time at which a pendulum first swings through, s.
Real first_passage(const std::string& scene, const char* body) {
  Real passed = -1;
  play(scene, [&](const World& w) {
    if (passed < 0 && w.bodies[w.find(body)].pose.position.x < 0) passed = w.time;
  });
  return passed;
}

}  // namespace

CLAIM("pendulum", "one rod released at 30 degrees swings as the closed form says") {
  // A uniform rod of length L: 4 K(sin 15 degrees) sqrt(2 L / (3 g)), a quarter of it to the
  // middle.
  const World world = play("pendulum", {}, 0.02).scene.world;
  const Vec3 hook = world.links.values()[0].joint.anchor_a;
  const Real half = glm::length(world.bodies[world.find("rod")].pose.position - hook);
  const Real quarter = 1.598142 * std::sqrt(2 * 2 * half / (3 * 9.81));
  CHECK(first_passage("pendulum", "rod") == Approx(quarter).margin(1.5 / 60));
  CHECK(std::atan2(world.bodies[world.find("rod")].pose.position.x - hook.x,
                   hook.y - world.bodies[world.find("rod")].pose.position.y) ==
        Approx(30 * kDegree));
}

CLAIM("chain10", "ten rods, 1 m together, released at 30 degrees, keep their energy") {
  const Played p = play("chain10");
  CHECK(p.most_energy - p.start_energy < 1e-6);
  CHECK(p.start_energy - p.least_energy < 1e-2 * std::abs(p.start_energy));
  const Vec3 way = p.start("chain/9") - p.place("chain/9");
  CHECK(glm::length(way) > 0.01);
}

CLAIM("bench_chain200", "two hundred links of 0.1 m swing, closed to rounding") {
  const Played p = play("bench_chain200");
  CHECK(p.end.bodies.size() >= 200);
  CHECK(p.worst_gap < 1e-13);
  CHECK(p.most_energy - p.start_energy < 1e-5 * std::abs(p.start_energy));
}

CLAIM("heavy_tip", "five rods, each ten times as heavy as the one above, hold together") {
  const Played p = play("heavy_tip");
  for (int i = 1; i < 5; ++i) {
    const Real above = p.body(("chain/" + std::to_string(i - 1)).c_str()).mass;
    CHECK(p.body(("chain/" + std::to_string(i)).c_str()).mass / above == Approx(10));
  }
  CHECK(p.worst_gap < 1e-13);
  CHECK(p.most_energy - p.start_energy < 1e-5 * std::abs(p.start_energy));
}

CLAIM("chain", "a light chain is dragged by its top link") {
  Extent top, tip;
  const Played p = play("chain", [&](const World& w) {
    top.add(w.bodies[w.find("top")].pose.position.x);
    tip.add(w.bodies[w.find("chain/19")].pose.position.x);
  });
  CHECK(top.most - top.least > 0.5);
  CHECK(tip.most - tip.least > 0.5);
  CHECK(p.worst_gap < 1e-13);
}

CLAIM("chain_heavy", "on the same path a heavy and damped chain") {
  const Played light = play("chain", {}, 1), heavy = play("chain_heavy", {}, 8);
  CHECK(light.scene.world.bodies.values()[0].pose.position ==
        heavy.scene.world.bodies.values()[0].pose.position);
  CHECK(heavy.body("chain/0").mass > 2 * light.body("chain/0").mass);
  CHECK(heavy.body("chain/0").drag > light.body("chain/0").drag);
}

CLAIM("pinned_chain", "a chain held at both ends sags between its posts") {
  const Played p = play("pinned_chain");
  CHECK(p.place("chain/11").y < 1.2);
  CHECK(p.place("chain/0").y == Approx(p.place("chain/23").y).margin(0.02));
}

CLAIM("cut", "a chain held at both ends is cut in the middle: its halves hang from their posts") {
  Real sag = 0;
  const Played p = play("cut", [&](const World& w) {
    if (w.time < 0.5) sag = w.bodies[w.find("chain/11")].pose.position.y;
  });
  CHECK(p.scene.world.links.size() == p.end.links.size() + 1);
  CHECK(sag - p.place("chain/11").y > 0.1);
  CHECK(p.place("chain/11").x < -0.5);
  CHECK(p.place("chain/12").x > 0.5);
}

CLAIM("free_chain", "thrown spinning without gravity it keeps its momenta") {
  const Played p = play("free_chain");
  const Measures before = measure(p.scene.world), after = measure(p.end);
  CHECK(glm::length(after.momentum - before.momentum) < 1e-9 * glm::length(before.momentum));
  CHECK(glm::length(after.angular_momentum - before.angular_momentum) <
        1e-3 * glm::length(before.angular_momentum));
}

CLAIM("mobile", "arms that balance on one another sway in gusts of wind and stay level") {
  Extent across, tilt;
  const Played p = play("mobile", [&](const World& w) {
    across.add(w.bodies[w.find("moon")].pose.position.z);
    tilt.add((w.bodies[w.find("arm_top")].pose.rotation * Vec3(1, 0, 0)).y);
  });
  CHECK(across.most - across.least > 0.3);
  CHECK(std::max(tilt.most, -tilt.least) < 0.2);
  // Where no drag feels the wind it only turns.
  Extent calm, swung;
  for (const bool windy : {false, true}) {
    Simulation sim = Simulation::copy_of(p.scene.world, {p.scene.step, p.scene.substeps});
    if (!windy)
      for (const Entity e : p.scene.world.bodies.owners()) sim.world.bodies[e].drag = 0;
    for (int i = 0; i < 240; ++i) {
      sim.step();
      (windy ? swung : calm).add(sim.world.bodies[sim.world.find("wire_top")].pose.position.x);
    }
  }
  CHECK(swung.most - swung.least > 3 * (calm.most - calm.least));
}

CLAIM("unreachable", "a pin beyond the reach of its chain is named, with how far it is off") {
  const Played p = play("unreachable");
  const Pin& pin = p.end.pins[p.end.find("pull")];
  CHECK_FALSE(pin.reachable);
  CHECK(pin.residual == Approx(0.2263).margin(0.01));
  CHECK(fastest(p.end) < 0.1);
}

CLAIM("joint_ranges", "an arm and a leg are driven into every stop of their joints, never beyond") {
  Extent elbow, knee, first, second, twist, shoulder, hip;
  const Played p = play("joint_ranges", [&](const World& w) {
    elbow.add(joint_angle(w, w.find("elbow"))), knee.add(joint_angle(w, w.find("knee")));
    first.add(joint_angle(w, w.find("ankle"))), second.add(joint_second_angle(w, w.find("ankle")));
    twist.add(joint_angle(w, w.find("shoulder")));
    shoulder.add(glm::length(joint_swing(w, w.find("shoulder"))));
    hip.add(glm::length(joint_swing(w, w.find("hip")) / Vec3(1, 70 * kDegree, 25 * kDegree)));
  });
  const auto stops = [](const char* what, Real found, Real degrees) {
    CAPTURE(what);
    CHECK(found == Approx(degrees * kDegree).margin(1e-9));
  };
  stops("elbow straight", elbow.least, 0), stops("elbow bent", elbow.most, 145);
  stops("knee bent", knee.least, -140), stops("knee straight", knee.most, 0);
  stops("ankle down", first.least, -25), stops("ankle up", first.most, 45);
  stops("ankle left", second.least, -15), stops("ankle right", second.most, 15);
  stops("shoulder swung", shoulder.most, 50), stops("shoulder in", twist.least, -30);
  stops("shoulder out", twist.most, 45);
  CHECK(hip.most == Approx(1).margin(1e-9));
  CHECK(p.worst_violation < 1e-12);
}
