// A chain built through the API, its top dragged along a figure of eight; a user's own component
// and system keep the greatest height its tip has reached.
#include "demos/demo.hpp"

using namespace pantin;

namespace {

struct Highest {
  Real y = -1e30;  // m
  static void fields(auto& self, auto&& field) { field("y", self.y); }
};

Scene dragged_chain(int links, Entity& tip) {
  Scene scene;
  scene.duration = 8;
  World& world = scene.world;
  Body hand;
  hand.motion = Motion::kinematic;
  hand.pose.position = Vec3(0, 2.4, 0);
  Entity before = world.add_body(hand, "hand");
  Lissajous eight;
  eight.centre = hand.pose;
  eight.amplitude = Vec3(0.6, 0.25, 0), eight.frequency = Vec3(0.4, 0.8, 0);
  world.paths.add(before, {eight});

  Shape rod;
  rod.kind = ShapeKind::capsule;
  rod.size = Vec3(0.02, 0.04, 0);  // 0.12 m with its round ends
  const MassProperties m = mass_properties(rod, 600);
  Vec3 top = hand.pose.position, above(0);
  for (int i = 0; i < links; ++i) {
    Body link;
    link.mass = m.mass;
    link.inertia = Vec3(m.inertia[0][0], m.inertia[1][1], m.inertia[2][2]);
    link.pose.position = top - Vec3(0, 0.05, 0);
    tip = world.add_body(link, "link" + std::to_string(i));
    world.shapes.add(tip, {{rod}});
    world.add_link(before, tip, {above, Vec3(0, 0.05, 0)});
    before = tip, above = Vec3(0, -0.05, 0);
    top = link.pose.position - Vec3(0, 0.05, 0);
  }
  world.store<Highest>().add(tip, {});
  return scene;
}

}  // namespace

int main(int argc, char** argv) {
  Entity tip;
  const Scene scene = dragged_chain(20, tip);
  const auto script = [&](Simulation& sim, int step) {
    if (step > 0) return;
    sim.insert(Stage::after_step, [tip](World& world, Real) {
      Highest& highest = world.store<Highest>()[tip];
      highest.y = std::max(highest.y, world.bodies[tip].pose.position.y);
    });
  };
  return demos::run(argc, argv, {.name = "chain", .scene = scene, .script = script});
}
