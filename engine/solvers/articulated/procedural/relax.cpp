// Relaxation: pins, joints to kinematic bodies and taut cables in turn. [Lee 2000, sec. 4.1]
#include <algorithm>

#include "engine/solvers/articulated/procedural/sweeps.hpp"

namespace pantin::detail::articulated {
namespace {

/// Target of a pin, world.
Vec3 target_of(const Island& a, const PackedPin& h) {
  return h.partner == UINT32_MAX ? h.target : point_at(a, h.partner, h.held_anchor, kFinalPoses);
}

Real residual(const Island& a, const PackedPin& h) {
  return glm::length(target_of(a, h) - point_at(a, h.column, h.anchor, kFinalPoses));
}

/// Goal of a pin in a sweep: its target, or the nearest reachable point if the links cannot fold
/// that far. Sweeps alone would converge to a wrong configuration.
Vec3 goal_of(const Island& a, const PackedPin& h) {
  const Tree& t = a.trees[h.tree];
  if (h.partner != UINT32_MAX) return target_of(a, h);
  const Vec3 way = h.target - t.target;
  const Real span = glm::length(way);
  if (a.parents[t.first] != kHeld || span >= h.dead_reach || !(span > 0)) return h.target;
  return t.target + h.dead_reach / span * way;
}

const Tree& tree_of(const Island& a, std::size_t column) {
  PANTIN_ASSERT(column < a.count());
  std::size_t t = 0;
  while (t + 1 < a.trees.size() && a.trees[t + 1].first <= column) ++t;
  return a.trees[t];
}

/// The end of a cable that is moved if both can move.
enum class MovingEnd : std::uint8_t { a, b };

struct CableEnds {
  Vec3 a, b;
};
CableEnds ends_of(const World& world, const Island& a, const PackedCable& cord) {
  const CableParameters& s = world.cables.values()[cord.cable].joint;
  return {cord.column_a != UINT32_MAX ? point_at(a, cord.column_a, s.anchor_a, kFinalPoses)
                                      : point_on(world, cord.slot_a, s.anchor_a),
          cord.column_b != UINT32_MAX ? point_at(a, cord.column_b, s.anchor_b, kFinalPoses)
                                      : point_on(world, cord.slot_b, s.anchor_b)};
}

/// m: how long a cable may be. An elastic one, whose force does not act here, may not stretch
/// further than at the start of the step: it would store energy that the bodies do not lose. Only
/// `auto` has elastic cables.
Real longest(const World& world, const PackedCable& cord) {
  const CableParameters& s = world.cables.values()[cord.cable].joint;
  if (s.compliance == 0) return s.length;
  const Vec3 before =
      point_on(world, cord.slot_b, s.anchor_b) - point_on(world, cord.slot_a, s.anchor_a);
  return std::max(s.length, glm::length(before));
}

/// Moves the packed end of a taut cable to the nearest point within its length.
void pull_cable(const World& world, Island& a, const PackedCable& cord, MovingEnd preferred) {
  const CableParameters& s = world.cables.values()[cord.cable].joint;
  const bool has_a = cord.column_a != UINT32_MAX, has_b = cord.column_b != UINT32_MAX;
  const auto [pa, pb] = ends_of(world, a, cord);
  const Real span = glm::length(pb - pa), most = longest(world, cord);
  if (!(span > most * (1 + 1e-12))) return;
  PANTIN_ASSERT(has_a || has_b);
  const bool move_b = has_b && (preferred == MovingEnd::b || !has_a);
  const Vec3 way = most / span * (pb - pa);
  if (move_b)
    sweep_from(world, a, tree_of(a, cord.column_b), {cord.column_b, s.anchor_b, pa + way});
  else
    sweep_from(world, a, tree_of(a, cord.column_a), {cord.column_a, s.anchor_a, pb - way});
}

/// One sweep over all pins and cables, forwards or backwards, then the roots.
void sweep_all(World& world, Island& a, int round) {
  const std::size_t holds = a.pins.size(), all = holds + a.cables.size();
  const bool forwards = round % 2 == 0;
  for (std::size_t n = 0; n < all; ++n) {
    const std::size_t i = forwards ? n : all - 1 - n;
    if (i >= holds) {
      pull_cable(world, a, a.cables[i - holds], forwards ? MovingEnd::b : MovingEnd::a);
      continue;
    }
    const PackedPin& h = a.pins[i];
    if (h.compliance == 0)
      sweep_from(world, a, a.trees[h.tree], {h.column, h.anchor, goal_of(a, h)});
  }
  for (const Tree& t : a.trees) sweep_from_root(world, a, t);
}

/// m: largest residual of a pin or stretch of a cable.
Real worst_residual(const World& world, const Island& a) {
  Real worst = 0;
  for (const PackedPin& h : a.pins)
    if (h.compliance == 0) worst = std::max(worst, residual(a, h));
  for (const PackedCable& cord : a.cables) {
    const CableEnds e = ends_of(world, a, cord);
    worst = std::max(worst, glm::length(e.b - e.a) - longest(world, cord));
  }
  return worst;
}

}  // namespace

bool is_in_reach(const Island& a, const PackedPin& h) {
  const Tree& t = a.trees[h.tree];
  if (h.partner != UINT32_MAX || a.parents[t.first] != kHeld) return true;
  const Real span = glm::length(h.target - t.target), slack = 1e-9 * a.size;
  return span <= h.reach + slack && span >= h.dead_reach - slack;
}

void relax(World& world, Island& a) {
  for (PackedPin& h : a.pins) h.reachable = is_in_reach(a, h);
  Real worst = worst_residual(world, a);
  for (int round = 0; round < a.settings.sweeps && worst > a.settings.tolerance * a.size; ++round) {
    sweep_all(world, a, round);
    a.sweeps_used = round + 1;
    const Real now = worst_residual(world, a);
    // Stops when the residual no longer decreases: the target is out of reach.
    const bool stalled = worst - now < a.settings.stall_drop * worst;
    worst = now;
    if (stalled) break;
  }
}

}  // namespace pantin::detail::articulated
