// A motor turns the crank of a four-bar linkage; the coupler's far end is where geometry says.
#include "demos/demo.hpp"

using namespace pantin;

namespace {

constexpr Real kCrank = 0.25, kCoupler = 0.75, kRocker = 0.6, kGround = 0.8, kUp = 0.8;

Real angle_of(const World& w, Entity body) {
  const Vec3 x = w.origin_pose(body).rotation * Vec3(1, 0, 0);
  return std::atan2(x.y, x.x);
}

/// The coupler's far end for a crank angle, by the two circles it lies on.
Vec3 far_end(Real angle) {
  const Vec3 tip(kCrank * std::cos(angle), kCrank * std::sin(angle), 0);
  const Vec3 away = Vec3(kGround, 0, 0) - tip;
  const Real d = glm::length(away);
  const Real open =
      std::acos((kCoupler * kCoupler + d * d - kRocker * kRocker) / (2 * kCoupler * d));
  const Real rotation = std::atan2(away.y, away.x) + open;
  return tip + kCoupler * Vec3(std::cos(rotation), std::sin(rotation), 0) + Vec3(0, kUp, 0);
}

}  // namespace

int main(int argc, char** argv) {
  const Scene scene = demos::load("four_bar");
  const Entity crank = scene.world.find("crank"), coupler = scene.world.find("coupler");
  Real worst_place = 0, way = 0, last = 0;
  demos::Extras extras;
  extras.last_picture = 1.7;
  extras.check = [&](const World&, const demos::Outcome& worst, demos::Findings& f) {
    f.expect("coupler off its place, m", worst_place, 0, 2e-9);
    f.expect("turns of the crank", way / (2 * kPi), 2.5, 3.1);
    f.expect("joints open at the worst, part of the size", worst.worst_gap, 0, 1e-12);
    f.expect("equations that follow from others", worst.last.rows - worst.last.rank, 3, 3);
  };
  const auto script = [&](Simulation& sim, int step) {
    const Real angle = angle_of(sim.world, crank);
    if (step == 0) worst_place = way = 0, last = angle;
    way += std::remainder(angle - last, 2 * kPi), last = angle;
    const Vec3 found = to_world(sim.world.origin_pose(coupler), {kCoupler / 2, 0, 0});
    worst_place = std::max(worst_place, glm::length(found - far_end(angle)));
  };
  return demos::run(argc, argv,
                    {.name = "four_bar", .scene = scene, .script = script, .extras = extras});
}
