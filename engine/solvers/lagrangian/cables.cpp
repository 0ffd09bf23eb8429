// Lengths of cables as rows: from end to end, or along guides.
#include <algorithm>

#include "engine/joints/cable_path.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// A cable as a joint whose travel is the distance of its ends.
Joint joint_of_cable(const CableParameters& cable) {
  Joint j;
  j.kind = JointKind::spring, j.anchor_a = cable.anchor_a, j.anchor_b = cable.anchor_b;
  return j;
}

/// The body of a place, counted from a to b.
const BodyState& body_at(const Island& m, const Block& b, std::size_t place) {
  return m.scratch.body_states[b.body[m.places[b.first_place + place]]];
}

void write_path_length(const Cable& cable, const Island& m, const Block& b, RowsOut out) {
  PathPoint path[kMostPathPoints];
  std::size_t count = 0;
  const auto add = [&](const CableGuide& g) {
    path[count] = path_point(body_at(m, b, count), g.anchor, g.axis, g.radius);
    ++count;
  };
  add({.body = cable.a, .anchor = cable.joint.anchor_a});
  for (const CableGuide& g : cable.guides) add(g);
  add({.body = cable.b, .anchor = cable.joint.anchor_b});
  PathGradient gradients[kMostPathPoints];
  const PathLength found =
      path_length({path, count}, std::span(gradients).first(out.j ? kMostPathPoints : 0));
  if (out.c) *out.c = found.length;
  if (out.gamma) *out.gamma = -found.second_rate;
  if (!out.j) return;
  std::fill(out.j, out.j + vectors_of(b), Vec3(0));
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = m.places[b.first_place + i];
    const Vec3 arm = path[i].centre - body_at(m, b, i).position;
    out.j[2 * at] += gradients[i].by_centre;
    out.j[2 * at + 1] += glm::cross(arm, gradients[i].by_centre) + gradients[i].by_turn;
  }
}

}  // namespace

void write_cable_length(const World& world, const Island& m, const Block& block, RowsOut out) {
  const Cable& cable = world.cables.values()[block.source];
  if (!cable.guides.empty()) return write_path_length(cable, m, block, out);
  const Joint joint = joint_of_cable(cable.joint);
  write_coordinate(
      {joint, m.scratch.body_states[block.body[0]], m.scratch.body_states[block.body[1]]},
      Coordinate::travel, out);
}

void add_path_forces(const World& world, Island& m) {
  for (const Block& b : m.elastic_paths) {
    const Cable& cable = world.cables.values()[b.source];
    Vec3 j[2 * kMostBlockBodies];
    Real length = 0;
    write_path_length(cable, m, b, {&length, j, nullptr});
    if (!(length > cable.joint.length)) continue;
    const Real tension = (length - cable.joint.length) / cable.joint.compliance;
    for (std::size_t k = 0; k < b.count; ++k) {
      if (b.body[k] >= m.count()) continue;
      m.scratch.force[2 * b.body[k]] -= tension * j[2 * k];
      m.scratch.force[2 * b.body[k] + 1] -= tension * j[2 * k + 1];
    }
  }
}

}  // namespace pantin::detail::lagrangian
