// A puppet is pushed down twenty stairs, tumbles to the floor and comes to rest.
#include <algorithm>

#include "demos/demo.hpp"

using namespace pantin;

namespace {

constexpr Real kRise = 0.17, kRun = 0.29, kTop = 3.4;
constexpr int kStairs = 20;

/// Height of the floor, a stair or the landing at `x`.
Real surface(Real x) {
  const Real stair = std::ceil(kStairs - x / kRun);
  return std::clamp(stair, Real(0), Real(kStairs)) * kRise;
}

struct Fall {
  Real lowest = 1e300;  // m, of a body's centre above what is below it
  Real passed = -1;     // s, when the pelvis was over the floor
  Real moved = -1;      // s, when a body last moved faster than 0.05 m/s
};

void look(const World& w, Fall& fall) {
  for (const Body& b : w.bodies.values()) {
    if (b.motion != Motion::dynamic) continue;
    fall.lowest = std::min(fall.lowest, b.pose.position.y - surface(b.pose.position.x));
    if (glm::length(b.velocity) > 0.05) fall.moved = w.time;
  }
  const Vec3 pelvis = w.bodies[w.find("puppet/pelvis")].pose.position;
  if (fall.passed < 0 && pelvis.x > kStairs * kRun) fall.passed = w.time;
}

}  // namespace

int main(int argc, char** argv) {
  const Scene scene = demos::load("stairs");
  Fall fall;
  demos::Extras extras;
  extras.columns = 5, extras.width = 288;
  extras.last_picture = 2;
  extras.check = [&](const World& w, const demos::Outcome& worst, demos::Findings& f) {
    look(w, fall);
    f.expect("past the last stair after, s", fall.passed, 1, 4);
    f.expect("at rest so long after that, s", fall.moved - fall.passed, 0, 5);
    f.expect("lowest body centre above stair or floor, m", fall.lowest, 0.01, 1);
    f.expect("worst depth of a contact, m", worst.worst_depth, 0, 0.03);
    f.expect("worst turn beyond a limit, rad", worst.worst_violation, 0, 1e-12);
  };
  const auto script = [&](Simulation& sim, int step) {
    if (step == 0) fall = {};
    look(sim.world, fall);
    const Entity chest = sim.world.find("puppet/chest");
    if (step < 18) sim.world.push(chest, {1200, 0, 0}, sim.world.bodies[chest].pose.position);
  };
  return demos::run(argc, argv,
                    {.name = "stairs", .scene = scene, .script = script, .extras = extras});
}
