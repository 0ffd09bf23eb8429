#include "engine/assembly/branches.hpp"

#include "engine/base/disjoint_sets.hpp"
#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"

namespace pantin::detail::assembly {

using lagrangian::Block;
using lagrangian::BlockKind;
using lagrangian::Island;

namespace {

/// The bodies that connect to `body` without a joint; only itself if that includes the joint's
/// other body, or anything that cannot move.
std::vector<std::uint32_t> side_of(const Island& m, const Block& joint, std::uint32_t body,
                                   std::uint32_t other) {
  const auto ground = static_cast<std::uint32_t>(m.count());
  DisjointSets sets(m.count() + 1);
  for (const Block& b : m.blocks) {
    if (lagrangian::is_compliant(b.kind)) continue;
    const bool is_own =
        (b.kind == BlockKind::joint || b.kind == BlockKind::limit) && b.source == joint.source;
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
  const Vec3 centre =
      moves.position + moves.rotation_matrix * (takes_a ? joint.anchor_a : joint.anchor_b);
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

namespace {

/// Places body b of a joint against body a, or a against b.
void place_at(const Joint& joint, const Pose& fixed, int end, Pose& moves) {
  const JointKindInfo& kind = info_of(joint.kind);
  const bool moves_b = end == 1;
  const Pose &a = moves_b ? fixed : moves, &b = moves_b ? moves : fixed;
  const Quat q = allowed_rotation(joint, relative_rotation(joint, a.rotation, b.rotation));
  // R_b F_b = R_a F_a Q
  const Quat turned = moves_b ? a.rotation * joint.frames.a() * q * glm::conjugate(joint.frames.b())
                              : b.rotation * joint.frames.b() * glm::conjugate(q) *
                                    glm::conjugate(joint.frames.a());
  const Vec3 apart_before = residual(joint, a, b);
  moves.rotation = glm::normalize(turned);
  Vec3 apart(0);
  if (kind.find(Coordinate::travel)) {  // along x of a
    const Vec3 x = a.rotation * (joint.frames.a() * Vec3(1, 0, 0));
    const AngleLimit& range = joint.parameters->travel;
    const Real way = glm::dot(apart_before, x);
    apart = (range.on ? std::clamp(way, range.low, range.high) : way) * x;
  }
  const Vec3 now = residual(joint, a, b);
  moves.position += (moves_b ? 1.0 : -1.0) * (apart - now);
}

bool is_tree_joint(const World& world, const Block& b) {
  if (b.kind != BlockKind::joint) return false;
  const JointKindInfo& kind = info_of(world.links.values()[b.source].joint.kind);
  return kind.holds_point || (kind.find(Coordinate::travel) && !kind.is_line);
}

}  // namespace

void lay_out(const World& world, Part& part) {
  Island& m = part.m;
  lagrangian::Motions& s = m.scratch.state;
  std::vector<bool> placed(m.count() + m.frames.size(), false);
  for (std::size_t i = m.count(); i < placed.size(); ++i) placed[i] = true;
  if (m.frames.empty()) placed[0] = true;
  const auto pose = [&](std::uint32_t body) {
    const BodyState& at = m.scratch.body_states[body];
    return body < m.count() ? Pose{s.x[body], s.q[body]} : Pose{at.position, at.rotation};
  };
  for (bool any = true; any;) {
    any = false;
    for (const Block& b : m.blocks) {
      if (!is_tree_joint(world, b) || placed[b.body[0]] == placed[b.body[1]]) continue;
      const int end = placed[b.body[0]] ? 1 : 0;
      const std::uint32_t body = b.body[end];
      Pose at = pose(body);
      place_at(world.links.values()[b.source].joint, pose(b.body[1 - end]), end, at);
      s.x[body] = at.position, s.q[body] = at.rotation;
      placed[body] = any = true;
    }
    // Bodies that only other laws connect stay; what hangs on them is placed from there.
    if (!any)
      for (std::size_t i = 0; i < m.count() && !any; ++i)
        if (!placed[i]) placed[i] = any = true;
  }
  look(world, part), count(world, part);
}

}  // namespace pantin::detail::assembly
