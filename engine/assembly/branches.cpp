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

namespace {

/// One body of a joint.
struct JointEnd {
  std::uint32_t block;
  int end;  // 0: a, 1: b
};

/// The half turn of that body, world axes, after which the joint is on the right branch.
Quat half_turn(const World& world, const Part& part, const JointEnd& of) {
  const Block& b = part.m.blocks[of.block];
  const Joint& joint = world.links.values()[b.source].joint;
  const auto& at = part.m.scratch.body_states;
  const Quat one = at[b.body[0]].rotation, two = at[b.body[1]].rotation;
  const Quat axes = one * joint.frames.a();
  Quat half;
  for (const int axis : {1, 2, 0}) {
    Vec3 unit(0);
    unit[axis] = 1;
    half = from_rotation_vector(kPi * (axes * unit));
    if (on_right_branch(joint, of.end == 0 ? half * one : one, of.end == 1 ? half * two : two))
      break;
  }
  return half;
}

void turn(Part& part, std::span<const std::uint32_t> side, Quat by, Vec3 centre) {
  lagrangian::Motions& s = part.m.scratch.state;
  for (const std::uint32_t body : side) {
    s.x[body] = centre + by * (s.x[body] - centre);
    s.q[body] = glm::normalize(by * s.q[body]);
  }
}

}  // namespace

void turn_over(const World& world, Part& part, std::uint32_t block) {
  Island& m = part.m;
  const Block& b = m.blocks[block];
  const Joint& joint = world.links.values()[b.source].joint;
  const auto side = [&](int end) {
    return b.body[end] < m.count() ? side_of(m, b, b.body[end], b.body[1 - end])
                                   : std::vector<std::uint32_t>{};
  };
  const std::vector<std::uint32_t> of_a = side(0), of_b = side(1);
  // Whole sides stay closed; of two the smaller one.
  const bool takes_a =
      of_b.empty() || (of_a.size() > 1 && (of_b.size() == 1 || of_a.size() < of_b.size()));
  const int end = takes_a ? 0 : 1;
  const BodyState& moves = m.scratch.body_states[b.body[end]];
  const Vec3 centre = moves.position +
                      moves.rotation_matrix * (takes_a ? joint.anchor_a : joint.anchor_b);
  turn(part, takes_a ? of_a : of_b, half_turn(world, part, {block, end}), centre);
  look(world, part), count(world, part);
}

int face(const World& world, Part& part) {
  constexpr int kPasses = 3;
  int turned = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    const std::vector<std::uint32_t> wrong = wrong_branches(world, part);
    for (const std::uint32_t i : wrong) {
      const Block& b = part.m.blocks[i];
      const auto& at = part.m.scratch.body_states;
      if (on_right_branch(world.links.values()[b.source].joint, at[b.body[0]].rotation,
                          at[b.body[1]].rotation))
        continue;
      const int end = b.body[1] < part.m.count() ? 1 : 0;
      const std::uint32_t body = b.body[end];
      turn(part, {&body, 1}, half_turn(world, part, {i, end}), part.m.scratch.state.x[body]);
      ++turned;
      lagrangian::update_kinematics(part.m);
    }
    if (wrong.empty()) break;
  }
  if (turned > 0) look(world, part), count(world, part);
  return turned;
}

}  // namespace pantin::detail::assembly
