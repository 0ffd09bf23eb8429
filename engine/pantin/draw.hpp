#pragma once
/// Debug lines for a program's own renderer: joints, limits, contacts and cables.
///
///   draw_debug(simulation.world, {.size = 0.2}, [&](const DebugLine& line) {
///     my_renderer.line(line.from, line.to, line.colour);
///   });
///
/// They show the World after its last step, in world space. Pantin's own renderer shows more:
/// <pantin/render.hpp>.
#include <functional>
#include <pantin/world.hpp>

namespace pantin {

struct DebugLine {
  Vec3 from{0}, to{0};  // m
  Vec3 colour{1};       // sRGB, each 0 to 1
};

/// Selects what is drawn.
struct DebugDraw {
  bool joints = true;    // axes of each joint in its bodies: x red, y green, z blue; red where open
  bool limits = true;    // ranges about axes and along them, cones; white: the present coordinate
  bool contacts = true;  // points, and the normals of active ones
  bool forces = true;    // of contacts, on the first body of each pair
  bool cables = true;    // over their guides; darker where slack
  bool pins = true;      // from the point to its target
  bool bounds = false;   // axis-aligned bounding boxes of shapes
  Real size = 0.1;       // m, of axes and arcs
  Real force_scale = 1e-3;  // m per newton
};

void draw_debug(const World& world, const DebugDraw& what,
                const std::function<void(const DebugLine&)>& line);

}  // namespace pantin
