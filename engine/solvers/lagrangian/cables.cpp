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
  PANTIN_ASSERT(b.first_place + place < m.places.size());
  return m.scratch.body_states[b.body[m.places[b.first_place + place]]];
}

/// The points of a cable over guides and their motion.
struct Path {
  PathPoint places[kMostPathPoints];
  std::size_t count = 0;
  operator std::span<const PathPoint>() const { return {places, count}; }
};

Path path_of(const Cable& cable, const Island& m, const Block& b) {
  Path path;
  const auto add = [&](const CableGuide& g) {
    PANTIN_ASSERT(path.count < kMostPathPoints);
    PathPoint& place = path.places[path.count];
    place = path_point(body_at(m, b, path.count), g.anchor, g.axis, g.radius);
    place.wrap = g.wrap, ++path.count;
  };
  add({.body = cable.a, .anchor = cable.joint.anchor_a});
  for (const CableGuide& g : cable.guides) add(g);
  add({.body = cable.b, .anchor = cable.joint.anchor_b});
  return path;
}

void write_path_length(const Cable& cable, const Island& m, const Block& b, RowsOut out) {
  const Path path = path_of(cable, m, b);
  PathGradient gradients[kMostPathPoints];
  const PathLength found =
      path_length(path, std::span(gradients).first(out.j ? kMostPathPoints : 0));
  if (out.c) *out.c = found.length;
  if (out.gamma) *out.gamma = -found.second_rate;
  if (!out.j) return;
  std::fill(out.j, out.j + vectors_of(b), Vec3(0));
  for (std::size_t i = 0; i < path.count; ++i) {
    const std::size_t at = m.places[b.first_place + i];
    const Vec3 arm = path.places[i].centre - body_at(m, b, i).position;
    out.j[2 * at] += gradients[i].by_centre;
    out.j[2 * at + 1] += glm::cross(arm, gradients[i].by_centre) + gradients[i].by_turn;
  }
}

/// Excess length, relative to the island's size or 1 m, at which a cable is inconsistent.
constexpr Real kTorn = 1e-4;

/// A step, and a cable after it.
struct Followed {
  const Island& m;
  const Block& block;
  Real h;
  bool is_taut = false;  // an inextensible cable that is taut
};

/// Counts the turns of a cable on its pulleys. Returns its error, m: the excess length, or the
/// overlap of an end with a pulley; 0: none.
Real follow_cable(Cable& cable, const Followed& of) {
  const Island& m = of.m;
  Real wrong = 0;
  if (!cable.guides.empty()) {
    const Path path = path_of(cable, m, of.block);
    Real wraps[kMostPathPoints];
    const Real run_up = follow_path(path, of.h, wraps);
    for (std::size_t i = 0; i < cable.guides.size(); ++i)
      if (cable.guides[i].radius > 0) cable.guides[i].wrap = wraps[i + 1];
    if (of.is_taut ||
        (cable.joint.compliance > 0 && path_length(path, {}).length >= cable.joint.length))
      wrong = run_up;
  }
  if (cable.joint.compliance > 0 || m.settings.stabilisation != Stabilisation::projection)
    return wrong;
  const Real over = -m.scratch.c[of.block.first_row];
  return over > kTorn * std::max(Real(1), m.size) ? std::max(wrong, over) : wrong;
}

}  // namespace

void follow_cables(World& world, Island& m, Real h) {
  const auto follow = [&](const Followed& of, std::size_t number) {
    const Real wrong = follow_cable(world.cables.values()[of.block.source], of);
    if (wrong > 0)
      m.faults.push_back({Fault::inconsistent, static_cast<std::uint32_t>(number), 0, wrong});
  };
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (m.blocks[i].kind == BlockKind::cable) follow({m, m.blocks[i], h, m.memory[i].active}, i);
  for (std::size_t i = 0; i < m.elastic_paths.size(); ++i)
    follow({m, m.elastic_paths[i], h}, m.blocks.size() + i);
}

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
    PANTIN_ASSERT(cable.joint.compliance > 0);
    const Real tension = tension_of(cable.joint, length - cable.joint.length);
    for (std::size_t k = 0; k < b.count; ++k) {
      if (b.body[k] >= m.count()) continue;
      m.scratch.force[2 * b.body[k]] -= tension * j[2 * k];
      m.scratch.force[2 * b.body[k] + 1] -= tension * j[2 * k + 1];
    }
  }
}

}  // namespace pantin::detail::lagrangian
