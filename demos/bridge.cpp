// A hand leads a marionette over a hanging bridge, whose planks give way under its feet.
#include <algorithm>
#include <numbers>
#include <optional>
#include <string>

#include "demos/demo.hpp"

using namespace pantin;

namespace {

constexpr Real kSpan = 2.04, kSag = 0.16;      // m, of the bridge at rest
constexpr Real kPace = 0.21, kStepRate = 0.9;  // m/s, Hz
constexpr int kPlanks = 17;

/// How far the bridge at rest is below the banks at `x`.
Real sag(Real x) { return kSag * std::max(Real(0), 1 - 4 * x * x / (kSpan * kSpan)); }

/// The path of the hand: on along x from rest, down into the sag and up again, while the rocking
/// bar lifts the knees.
void lead(World& w, Real duration) {
  const Real start = w.bodies[w.find("pantin/bar")].pose.position.x;
  for (const char* part : {"bar", "leg_bar", "handle_l", "handle_r"}) {
    const Entity e = w.find(std::string("pantin/") + part);
    const Pose from = w.bodies[e].pose;
    Keyframes path;
    for (Real time = 0; time < duration + 1; time += 0.05) {
      const Real rise = std::min(time, Real(1));
      const Real way = kPace * (rise * rise / 2 + (time - rise));
      const Real stride = 2 * std::numbers::pi * kStepRate * time;
      Pose pose = from;
      pose.position += Vec3(way, -sag(start + way), 0);
      pose.position.y += rise * (0.004 * std::sin(2 * stride) - 0.014);
      pose.position.z += 0.006 * rise * std::sin(stride);
      if (std::string(part) == "leg_bar")
        pose.rotation =
            from_rotation_vector(Vec3(0.6 * rise * std::sin(stride), 0, 0)) * from.rotation;
      path.keys.push_back({time, pose});
    }
    w.paths.add(e, KinematicPath{path});
  }
}

struct Crossing {
  Real lowest = 1e300, highest = -1e300, aside = 0;  // m, of the planks' middles
  Real middle_at_rest = 0, middle_lowest = 1e300;    // m, height of the middle plank
  Real off_pin = 0;                                  // m
  int carried = 0;                                   // steps with a foot on a plank
  std::optional<ContactEvents> contacts = {};
};

void look(const World& w, Crossing& c) {
  for (int i = 0; i < kPlanks; ++i) {
    const Vec3 p = w.bodies[w.find("planks/" + std::to_string(i))].pose.position;
    c.lowest = std::min(c.lowest, p.y), c.highest = std::max(c.highest, p.y);
    c.aside = std::max(c.aside, std::abs(p.z));
  }
  const Real middle = w.bodies[w.find("planks/8")].pose.position.y;
  if (w.time < 1) c.middle_at_rest = middle;
  c.middle_lowest = std::min(c.middle_lowest, middle);
  for (const Pin& pin : w.pins.values()) c.off_pin = std::max(c.off_pin, pin.residual);
  if (!c.contacts) c.contacts.emplace(w);
  c.carried += std::ranges::any_of(c.contacts->update(w), [&](const ContactEvent& e) {
    return e.impulse != Vec3(0) && w.bodies[e.a].motion == Motion::dynamic &&
           w.bodies[e.b].motion == Motion::dynamic;
  });
}

}  // namespace

int main(int argc, char** argv) {
  Scene scene = demos::load("bridge");
  lead(scene.world, scene.duration);
  Crossing crossing;
  demos::Extras extras;
  extras.width = 380, extras.height = 300;
  extras.check = [&](const World& w, const demos::Outcome& worst, demos::Findings& f) {
    look(w, crossing);
    const Vec3 pelvis = w.bodies[w.find("pantin/pelvis")].pose.position;
    f.expect("pelvis along the way at the end, m", pelvis.x, 1.05, 1.4);
    f.expect("height of the pelvis over the far bank, m", pelvis.y - 0.6, 0.28, 0.4);
    f.expect("steps with a foot on a plank", crossing.carried, 100, 720);
    f.expect("middle plank down under it, m", crossing.middle_at_rest - crossing.middle_lowest,
             0.001, 0.1);
    f.expect("lowest plank, m", crossing.lowest, 0.3, 0.59);
    f.expect("highest plank, m", crossing.highest, 0.5, 0.6);
    f.expect("planks to the side, m", crossing.aside, 0, 0.05);
    f.expect("worst distance of a pin from its place, m", crossing.off_pin, 0, 2e-4);
    f.expect("worst depth of a contact, m", worst.worst_depth, 0, 0.01);
  };
  const auto script = [&](Simulation& sim, int step) {
    if (step == 0) crossing = {};
    look(sim.world, crossing);
  };
  return demos::run(argc, argv,
                    {.name = "bridge", .scene = scene, .script = script, .extras = extras});
}
