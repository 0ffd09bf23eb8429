// Scratch memory of a step, allocated when a step first needs it.
#include <algorithm>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {

void reserve_general_solve(Island& a) {
  StepScratch& r = a.scratch;
  const std::size_t n = a.count(), rows = 3 * a.pins.size() + a.cables.size();
  if (r.forces_in.empty() && a.iterates) r.forces_in.assign(n, {}), r.torques_in.assign(n, {});
  if (r.joint_nodes.size() == n) return;
  r.joint_nodes.assign(n, {}), r.base.assign(n, {}), r.joint_blocks.assign(n, {});
  r.terms.assign(a.joints.empty() ? 0 : n, {});
  r.translation.assign(n, Vec3(0)), r.rotation.assign(n, Vec3(0)), r.levers.assign(n, Vec3(0));
  r.gaps.assign(n, Vec3(0)), r.lambdas.assign(n, Vec3(0));
  r.rotations.assign(n, kIdentity);
  if (rows == 0) return;
  r.forces_in.assign(n, {}), r.torques_in.assign(n, {});
  r.on_path.assign(std::max(n, rows), 0);
  r.rows.reserve(rows), r.response.assign(rows * rows, 0);
  r.factor.assign(rows * rows, 0), r.solved.assign(rows, 0);
}

bool has_free_tree(const Island& a) {
  return std::any_of(a.trees.begin(), a.trees.end(),
                     [&](const Tree& t) { return a.parents[t.first] == kFree; });
}

namespace {

bool has_colliders(const World& world, const Island& a) {
  return std::any_of(a.bodies.begin(), a.bodies.end(),
                     [&](Entity e) { return world.collisions.find(e) != nullptr; });
}

}  // namespace

void prepare(World& world) {
  Islands& all = world.memory.of<Islands>();
  if (all.scratch.prepared) return;  // a copy of a World has no scratch memory
  all.scratch.prepared = true;
  for (Island& a : all.list) {
    if (a.scratch.targets.capacity() > 0) continue;  // allocated already
    const std::size_t n = a.count(), padded = a.slots.size();
    const bool shake = a.settings.solver == Solver::shake2;
    StepScratch& r = a.scratch;
    r.work.resize(kWorkRows, n);
    for (std::size_t c = n; c < padded; ++c)
      r.work.at(kAppliedRotation + 3, c) = 1;  // padding: identity rotation
    r.nodes.assign(kNodeSize * n, 0);
    r.targets.reserve(3 * a.trees.size());
    r.ways.reserve(3 * a.trees.size()), r.anchor_velocities.reserve(3 * a.trees.size());
    if (!world.forces.empty()) r.forces.resize(6, n);
    if (has_rows(a) || !a.joints.empty()) reserve_ties(a);
    if (!a.is_chain || shake || has_rows(a) || !a.joints.empty())
      r.blocks.assign(std::max<std::size_t>(kBlockSize, kConservingBlock) * n, 0);
    if (shake) r.translation.assign(n, Vec3(0)), r.rotation.assign(n, Vec3(0));
    if (shake || has_free_tree(a)) r.lambdas.assign(n, Vec3(0));  // also outboard masses
    if (has_rows(a) || !a.joints.empty()) reserve_general_solve(a);
    if (!a.joints.empty()) r.conserving_sums.resize(n), r.conserving_nodes.resize(n);
    if (!world.collisions.empty() && has_colliders(world, a)) {
      r.contact_rows.reserve(8 * n), r.mean_forces.reserve(8 * n);
      r.step_targets.reserve(2 * a.trees.size());
      reserve_general_solve(a);
    }
  }
}

}  // namespace pantin::detail::articulated
