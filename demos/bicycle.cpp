// Pedals turn a wheel by a chain: the ring of links is closed, teeth push its rollers.
#include <numbers>

#include "demos/demo.hpp"

using namespace pantin;

namespace {

constexpr Real kWhole = 2 * std::numbers::pi;

/// How far a body has turned about z against an angle it had before, rad.
Real rotated(const World& w, Entity body, Real from) {
  const Quat q = w.origin_pose(body).rotation;
  return std::remainder(2 * std::atan2(q.z, q.w) - from, kWhole);
}

/// The way of the pedals by the keys of the scene, rad: from rest to half a turn a second,
/// anticlockwise.
Real pedalled(Real time) {
  const Real rise = std::min(time, Real(1));
  return kWhole / 2 * (rise * rise / 2 + (time - rise));
}

}  // namespace

int main(int argc, char** argv) {
  const Scene scene = demos::load("bicycle");
  const Entity wheel = scene.world.find("wheel");
  Real angle = 0;  // of the wheel, whole turns counted
  demos::Extras extras;
  extras.last_picture = 2.1;
  extras.check = [&](const World& w, const demos::Outcome& worst, demos::Findings& f) {
    angle += rotated(w, wheel, angle);
    const Real way = pedalled(w.time);
    f.expect("turns of the pedals", way / kWhole, 2, 4);
    f.expect("turns of the wheel over these, by teeth 1.6", angle / way, 1.45, 1.65);
    f.expect("loop open at the worst, part of 1.2 m", worst.worst_residual / 1.2, 0, 1e-4);
    f.expect("worst depth of a contact, m", worst.worst_depth, 0, 0.01);
  };
  const auto script = [&](Simulation& sim, int step) {
    if (step == 0) angle = 0;
    angle += rotated(sim.world, wheel, angle);
  };
  return demos::run(argc, argv,
                    {.name = "bicycle", .scene = scene, .script = script, .extras = extras});
}
