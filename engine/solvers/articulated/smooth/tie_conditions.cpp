// Which islands the energy-momentum method can step with their ties; workspace of ties.
#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr std::uint32_t kNobody = UINT32_MAX;

}  // namespace

bool has_loops(const Island& a) {
  return std::any_of(a.pins.begin(), a.pins.end(), [](const PackedPin& pin) {
    return pin.partner != kNobody && pin.compliance == 0;
  });
}

bool has_rigid_pins(const Island& a) {
  return std::any_of(a.pins.begin(), a.pins.end(),
                     [](const PackedPin& pin) { return pin.compliance == 0; });
}

bool ties_hold_still(const Island& a) {
  return std::all_of(a.scratch.ties.begin(), a.scratch.ties.end(),
                     [](const ConservingTie& t) { return t.still; });
}

bool ties_are_closed(const Island& a) {
  return std::none_of(a.scratch.ties.begin(), a.scratch.ties.end(),
                      [](const ConservingTie& t) { return t.open; });
}

bool ties_are_inner(const Island& a) {
  const auto tree_of = [&](std::uint32_t column) {
    std::size_t t = 0;
    while (t + 1 < a.trees.size() && a.trees[t + 1].first <= column) ++t;
    return t;
  };
  return std::all_of(a.scratch.ties.begin(), a.scratch.ties.end(), [&](const ConservingTie& t) {
    if (t.kind == TieKind::slack) return true;
    return t.a != kNobody && tree_of(t.a) == tree_of(t.b);
  });
}

std::size_t tie_count(const Island& a) { return a.pins.size() + a.cables.size(); }

bool can_tie(const World& world, const Island& a) {
  if (a.scratch.ties.capacity() < tie_count(a)) return false;
  for (const PackedPin& pin : a.pins)
    if (pin.compliance == 0 && !is_in_reach(a, pin)) return false;
  for (const PackedCable& cable : a.cables) {
    const Cable& c = world.cables.values()[cable.cable];
    if (c.joint.compliance > 0) continue;
    // A winch shortens it within the step.
    const Real wound =
        is_reeled(cable.before(), c.joint) ? c.joint.length - cable.length_before : 0;
    const Real over = stretch(c.joint, world.bodies[c.a].pose, world.bodies[c.b].pose) + wound;
    if (!(over <= kNearTie * a.size) || (cable.lambda > 0 && !(over >= -kNearTie * a.size)))
      return false;
  }
  return true;
}

void reserve_ties(Island& a) {
  StepScratch& r = a.scratch;
  const std::size_t ties = tie_count(a), n = a.count();
  const std::size_t rows = ties <= kMostTies ? 3 * ties : 0;
  r.ties.reserve(rows / 3), r.tie_sets.reserve(rows / 3);
  r.tie_blocks.assign(kTieBlock * n, 0), r.tie_factors.assign(kTieFactor * n, 0);
  r.tie_grounded.assign(n, 0);
  for (const PackedPin& pin : a.pins)
    if (pin.partner == kNobody) r.tie_grounded[pin.column] = 1;
  for (const PackedCable& k : a.cables)
    if (k.column_a == kNobody || k.column_b == kNobody)
      r.tie_grounded[k.column_a == kNobody ? k.column_b : k.column_a] = 1;
  r.tie_impulses.assign(n, Vec3(0)), r.tie_torques.assign(n, Vec3(0));
  r.tie_joints.assign(n, Vec3(0));
  if (rows > 0) reserve_tie_rows(a);
  r.tie_matrix.assign(rows * rows, 0), r.tie_solution.assign(rows, 0);
  r.tie_kept.assign(rows * (rows + 1), 0);
  r.tie_order.assign(rows, 0), r.tie_largest.assign(rows, 0);
  r.pins_before.assign(a.pins.size(), Vec3(0)), r.pin_gaps = r.pins_before;
  r.cable_rows.assign(a.cables.size(), CableRow::open), r.cable_rows_before = r.cable_rows;
  r.cable_gaps.assign(a.cables.size(), 0);
  r.velocities_before.assign(a.cables.empty() ? 0 : 2 * n, Vec3(0));
}
}  // namespace pantin::detail::articulated
