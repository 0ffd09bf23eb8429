#pragma once
/// Lines to look at in a program's own picture: where joints, limits, contacts and cables are.
///
///   draw_debug(simulation.world, {.size = 0.2}, [&](const DebugLine& line) {
///     my_renderer.line(line.from, line.to, line.colour);
///   });
///
/// They show the World as it stands after its last step, in world space. Pictures that pantin draws
/// itself have more: <pantin/render.hpp>.
#include <functional>
#include <pantin/world.hpp>

namespace pantin {

struct DebugLine {
  Vec3 from{0}, to{0};  // m
  Vec3 colour{1};       // sRGB, each 0 to 1
};

/// What is drawn.
struct DebugDraw {
  bool joints = true;    // axes of each joint in its bodies: x red, y green, z blue; red where open
  bool limits = true;    // ranges about axes and along them, cones; white: where the joint stands
  bool contacts = true;  // points, and the normals of those that bear
  bool forces = true;    // of contacts, on the first body of each pair
  bool cables = true;    // over their guides; darker where slack
  bool pins = true;      // from the point to its target
  bool bounds = false;   // boxes about shapes, along the axes of the world
  Real size = 0.1;       // m, of axes and arcs
  Real force_scale = 1e-3;  // m a newton
};

void draw_debug(const World& world, const DebugDraw& what,
                const std::function<void(const DebugLine&)>& line);

}  // namespace pantin
