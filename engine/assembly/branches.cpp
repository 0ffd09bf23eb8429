#include "engine/assembly/branches.hpp"

#include "engine/base/disjoint_sets.hpp"
#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"

namespace pantin::detail::assembly {

using lagrangian::Block;
using lagrangian::BlockKind;
using lagrangian::Island;

namespace {

/// The bodies that connect to `body` without a joint; only itself if that includes the joint's other
/// body, or anything that cannot move.
std::vector<std::uint32_t> side_of(const Island& m, const Block& joint, std::uint32_t body,
                                   std::uint32_t other) {
  const auto ground = static_cast<std::uint32_t>(m.count());
  DisjointSets sets(m.count() + 1);
  for (const Block& b : m.blocks) {
    if (lagrangian::is_compliant(b.kind)) continue;
    const bool is_own = (b.kind == BlockKind::joint || b.kind == BlockKind::limit) &&
                        b.source == joint.source;
    for (std::size_t k = 1; k < b.count && !is_own; ++k)
      sets.join(std::min(b.body[0], ground), std::min(b.body[k], ground));
  }
  const auto root = sets.root(body);
  if (root == sets.root(std::min(other, ground)) || root == sets.root(ground)) return {body};
  std::vector<std::uint32_t> side;
  for (std::uint32_t b = 0; b < ground; ++b)
    if (sets.root(b) == root) side.push_back(b);
  return side;
}

}  // namespace

std::vector<std::uint32_t> wrong_branches(const World& world, const Part& part) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t i = 0; i < part.m.blocks.size(); ++i) {
    const Block& b = part.m.blocks[i];
    if (b.kind != BlockKind::joint) continue;
    const auto& at = part.m.scratch.body_states;
    if (!on_right_branch(world.links.values()[b.source].joint, at[b.body[0]].rotation,
                         at[b.body[1]].rotation))
      found.push_back(i);
  }
  return found;
}

void turn_over(const World& world, Part& part, std::uint32_t block) {
  Island& m = part.m;
  const Block& b = m.blocks[block];
  const Joint& joint = world.links.values()[b.source].joint;
  const auto& at = m.scratch.body_states;
  const BodyState &one = at[b.body[0]], &two = at[b.body[1]];
  const auto is_free = [&](int k) { return b.body[k] < m.count(); };
  std::vector<std::uint32_t> side, side_of_a;
  if (is_free(1)) side = side_of(m, b, b.body[1], b.body[0]);
  if (is_free(0)) side_of_a = side_of(m, b, b.body[0], b.body[1]);
  // Whole sides stay closed; of two the smaller one.
  const bool takes_a = side.empty() || (side_of_a.size() > 1 && (side.size() == 1 ||
                                                                side_of_a.size() < side.size()));
  if (takes_a) side = side_of_a;
  const BodyState& moves = takes_a ? one : two;
  const Vec3 centre =
      moves.position + moves.rotation_matrix * (takes_a ? joint.anchor_a : joint.anchor_b);
  const Quat axes = one.rotation * joint.frames.a();
  for (const int axis : {1, 2, 0}) {
    Vec3 unit(0);
    unit[axis] = 1;
    const Quat half = from_rotation_vector(kPi * (axes * unit));
    if (axis != 0 && !on_right_branch(joint, takes_a ? half * one.rotation : one.rotation,
                                      takes_a ? two.rotation : half * two.rotation))
      continue;
    lagrangian::Motions& s = m.scratch.state;
    for (const std::uint32_t body : side) {
      s.x[body] = centre + half * (s.x[body] - centre);
      s.q[body] = glm::normalize(half * s.q[body]);
    }
    break;
  }
  look(world, part), count(world, part);
}

}  // namespace pantin::detail::assembly
