// Spans of belts as rows.
#include <algorithm>

#include "engine/joints/belt_path.hpp"
#include "engine/solvers/lagrangian/internal.hpp"
#include "engine/world/belt.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// The pulley at an end of a span: 0, 1.
const BeltPulley& pulley_at(const Belt& belt, const Block& b, std::size_t end) {
  PANTIN_ASSERT(b.kind == BlockKind::belt && end < 2 && b.first_place < belt.pulleys.size());
  return belt.pulleys[(b.first_place + end) % belt.pulleys.size()];
}

/// The pulley on a body, with its angle on the revolution nearest to `angle`.
BeltPlace place_in(const Island& m, const BeltPulley& pulley, std::uint32_t body, Real angle) {
  const BodyState& at = m.scratch.body_states[body];
  const Vec3 x = at.rotation_matrix * (pulley.frame * Vec3(1, 0, 0));
  const Real now = angle + std::remainder(std::atan2(x.y, x.x) - angle, 2 * kPi);
  return {pulley.outline, at.position + at.rotation_matrix * pulley.anchor, now, pulley.sense};
}

}  // namespace

Real belt_angle(const World& world, const Island& m, const BeltEnd& of) {
  const BeltPulley& p = pulley_at(world.belts.values()[of.block.source], of.block, of.end);
  return place_in(m, p, of.block.body[of.end], of.before).angle;
}

void write_belt(const World& world, const Island& m, std::size_t block, RowsOut out) {
  const Block& b = m.blocks[block];
  const Belt& belt = world.belts.values()[b.source];
  const Real* counted = m.memory[block].before;
  const BeltPlace places[2] = {place_in(m, pulley_at(belt, b, 0), b.body[0], counted[0]),
                               place_in(m, pulley_at(belt, b, 1), b.body[1], counted[1])};
  const BeltPulley& first = pulley_at(belt, b, 0);
  const BeltSpan span = span_between(places[0], places[1], first.direction);
  if (!span.is_found) {
    if (out.c) *out.c = 0;
    if (out.gamma) *out.gamma = 0;
    if (out.j) std::fill(out.j, out.j + 4, Vec3(0));
    return;
  }
  if (out.c) *out.c = marked_length(places[0], places[1], span) - first.offset;
  const Vec3 u = span.along, across(-u.y, u.x, 0);
  const Vec3 touch[2] = {span.from, span.to};
  Vec3 relative(0);
  Real bends = 0;
  for (int k = 0; k < 2; ++k) {
    const BodyState& at = m.scratch.body_states[b.body[k]];
    const Vec3 arm = Vec3(touch[k].x, touch[k].y, places[k].centre.z) - at.position;
    const Real sign = k == 0 ? -1 : 1;
    if (out.j) out.j[2 * k] = sign * u, out.j[2 * k + 1] = glm::cross(arm, sign * u);
    relative += sign * (at.velocity + glm::cross(at.angular_velocity, arm));
    bends -= sign * at.angular_velocity.z * at.angular_velocity.z * glm::dot(arm, u);
  }
  // The span rotates with the velocity of its ends across it; its tangent points travel on
  // outlines.
  const Real turn = glm::dot(across, relative) / span.length;
  if (out.gamma) *out.gamma = -(span.length * turn * turn + bends);
}

void follow_belts(World& world, Island& m) {
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& first = m.blocks[i];
    if (first.kind != BlockKind::belt || first.first_place != 0) continue;
    Belt& belt = world.belts.values()[first.source];
    Pose poses[kMostPulleys];
    Real angles[kMostPulleys] = {};
    PANTIN_ASSERT(belt.pulleys.size() <= kMostPulleys);
    const auto note = [&](std::size_t pulley, const BeltEnd& of) {
      const BodyState& at = m.scratch.body_states[of.block.body[of.end]];
      poses[pulley] = {at.position, at.rotation};
      angles[pulley] = of.before;
    };
    const std::size_t count = belt.pulleys.size();
    for (std::size_t k = i; k < m.blocks.size(); ++k) {
      const Block& b = m.blocks[k];
      if (b.kind != BlockKind::belt || b.source != first.source) break;
      belt.pulleys[b.first_place].tension = belt.pretension - m.forces[b.first_row];
      note(b.first_place, {b, 0, m.memory[k].before[0]});
      note((b.first_place + 1) % count, {b, 1, m.memory[k].before[1]});
    }
    follow_belt(belt, {poses, count}, {angles, count});
  }
}

}  // namespace pantin::detail::lagrangian
