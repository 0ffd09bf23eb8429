// An arm and a leg whose joint drives pull beyond the ranges of their joints: the joints stop
// there.
#include <algorithm>
#include <numbers>

#include "demos/demo.hpp"

using namespace pantin;

namespace {

constexpr Real kDegree = std::numbers::pi / 180;

struct Range {
  Real least = 1e300, most = -1e300;
  void add(Real x) { least = std::min(least, x), most = std::max(most, x); }
};

struct Reached {
  Range elbow, knee, ankle_first, ankle_second, shoulder_twist;
  Real shoulder_swing = 0, hip_swing = 0;  // hip: 1 is on the rim of its elliptic cone
};

void look(const World& w, Reached& r) {
  r.elbow.add(joint_angle(w, w.find("elbow")));
  r.knee.add(joint_angle(w, w.find("knee")));
  r.ankle_first.add(joint_angle(w, w.find("ankle")));
  r.ankle_second.add(joint_second_angle(w, w.find("ankle")));
  const Entity shoulder = w.find("shoulder"), hip = w.find("hip");
  r.shoulder_twist.add(joint_angle(w, shoulder));
  r.shoulder_swing = std::max(r.shoulder_swing, glm::length(joint_swing(w, shoulder)));
  const Vec3 part = joint_swing(w, hip) / Vec3(1, 70 * kDegree, 25 * kDegree);
  r.hip_swing = std::max(r.hip_swing, glm::length(part));
}

}  // namespace

int main(int argc, char** argv) {
  const Scene scene = demos::load("joint_ranges");
  Reached reached;
  demos::Extras extras;
  extras.joints = true;
  extras.check = [&](const World& w, const demos::Outcome& worst, demos::Findings& f) {
    look(w, reached);
    const auto stops = [&](const char* what, Real found, Real degrees) {
      const Real limit = degrees * kDegree;
      f.expect(what, found / kDegree, (limit - 1e-9) / kDegree, (limit + 1e-9) / kDegree);
    };
    stops("elbow straight, degrees", reached.elbow.least, 0);
    stops("elbow bent, degrees", reached.elbow.most, 145);
    stops("knee bent, degrees", reached.knee.least, -140);
    stops("knee straight, degrees", reached.knee.most, 0);
    stops("ankle, toes up or down, least", reached.ankle_first.least, -25);
    stops("ankle, toes up or down, most", reached.ankle_first.most, 45);
    stops("ankle to one side, degrees", reached.ankle_second.least, -15);
    stops("ankle to the other side, degrees", reached.ankle_second.most, 15);
    stops("shoulder swung, degrees", reached.shoulder_swing, 50);
    stops("shoulder twisted inwards, degrees", reached.shoulder_twist.least, -30);
    stops("shoulder twisted outwards, degrees", reached.shoulder_twist.most, 45);
    f.expect("hip swung, part of its cone", reached.hip_swing, 1 - 1e-9, 1 + 1e-9);
    f.expect("worst turn beyond a limit, rad", worst.worst_violation, 0, 1e-12);
  };
  const auto script = [&](Simulation& sim, int step) {
    if (step == 0) reached = {};
    look(sim.world, reached);
  };
  return demos::run(argc, argv,
                    {.name = "joint_ranges", .scene = scene, .script = script, .extras = extras});
}
