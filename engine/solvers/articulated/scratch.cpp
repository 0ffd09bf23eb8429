// Scratch memory of a step, allocated when a step first needs it.
#include <algorithm>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {

bool has_free_tree(const Island& a) {
  return std::any_of(a.trees.begin(), a.trees.end(),
                     [&](const Tree& t) { return a.parents[t.first] == kFree; });
}

namespace {

bool has_colliders(const World& world, const Island& a) {
  return std::any_of(a.bodies.begin(), a.bodies.end(),
                     [&](Entity e) { return world.collisions.find(e) != nullptr; });
}

/// Also for prepared islands, since an unchanged island may get colliders later.
void prepare_contacts(const World& world, Island& a) {
  if (world.collisions.empty() || !has_colliders(world, a)) return;
  a.scratch.contact_rows.reserve(8 * a.count());
  a.scratch.pushes.resize(a.count()), a.scratch.on_path.resize(a.count());
}

}  // namespace

void prepare(const World& world, Island& a) {
  prepare_contacts(world, a);
  if (a.scratch.targets.capacity() > 0) return;  // allocated already
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
  if (shake) r.blocks.assign(kBlockSize * n, 0);
  if (has_rows(a)) r.velocities.assign(n, Vec3(0));
  if (shake) r.translation.assign(n, Vec3(0)), r.rotation = r.turned = r.translation;
  if (has_free_tree(a)) r.outboard.assign(n, 0);
  if (has_rows(a)) r.on_path.assign(n, 0);
  if (!a.joints.empty()) r.conserving_sums.resize(n), r.conserving_nodes.resize(n);
}

void prepare(World& world) {
  Islands& all = world.memory.of<Islands>();
  if (all.scratch.prepared == all.list.size() && all.crowd.is_known) return;
  for (std::size_t i = all.scratch.prepared; i < all.list.size(); ++i) prepare(world, all.list[i]);
  all.scratch.prepared = all.list.size();
  find_crowds(world, all);
}

}  // namespace pantin::detail::articulated
