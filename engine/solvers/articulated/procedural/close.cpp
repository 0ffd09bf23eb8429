// The adjust stage of the procedural rules: closes joints at the predicted poses, one after the
// other or by SHAKE, several pins by relaxation; then computes velocities. [Lee 2000, sec. 3.2]
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Closes joints one after the other from the root, as if inboard bodies were fixed.
void close_kinematic(Island& a, const IslandView& p, Real h) {
  for (const Tree& t : a.trees)
    if (a.parents[t.first] == kFree && t.count > 1) place_free_root(a, t, h);
  if (a.settings.solver == Solver::procedural) {
    literal_sweep(a, h);
    return;
  }
  const Kernels& k = kernels();
  k.levers(p, kPosition, kRotation);
  k.sweep(p, a.scratch.targets.data(), kPosition, a.settings.rotation_stiffness);
  k.apply_poses(p, kRotation);
}

}  // namespace

bool close_joints(World& world, Island& a, Real h) {
  const IslandView p = view_of(world, a);
  const VelocityInput in{h, rule_of(a)};
  const bool plain = !has_rows(a) && a.joints.empty() && a.scratch.contact_rows.empty();
  const bool one_held_tree = a.trees.size() == 1 && a.parents.front() == kHeld;
  if (a.settings.solver == Solver::sweep && plain && one_held_tree)
    return kernels().sweep_and_update(p, a.scratch.targets.data(), a.settings.rotation_stiffness,
                                      in);
  if (a.settings.solver == Solver::shake2)
    close_shake(world, a, p, h);
  else
    close_kinematic(a, p, h);
  if (!a.joints.empty()) sweep_closed(world, a);
  if (has_rows(a)) relax(world, a);
  if (!a.scratch.contact_rows.empty()) push_out_trees(world, a, h);
  return kernels().update_velocities(p, in);
}

}  // namespace pantin::detail::articulated
