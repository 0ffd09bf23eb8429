// The step of islands that have only ball joints and touch nothing, by the energy-momentum
// method: no energy is gained, whatever the masses and shapes. [Betsch & Steinmann 2001]
#include <algorithm>
#include <limits>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/articulated/smooth/conserving_joints.hpp"

namespace pantin::detail::articulated {
namespace {

/// A step that does not converge is halved, down to a 256th.
constexpr Real kParts = 256;
/// Less than that of a step is not left over.
constexpr Real kLeastRest = 1e-6;
/// One that would lose much energy is taken in up to so many parts: rods that snap straight.
constexpr int kResolvingParts = 16;
constexpr int kMostIterations = 8, kMostTiedIterations = 16;
/// Parts tried in a step, converged or not: bounds its cost. Of these, those that may end where a
/// cable becomes taut; those that are divided for losses and bends; those after which loops give
/// way.
constexpr int kMostAttempts = 96, kEndingAttempts = 12, kDividingAttempts = 24, kTiedAttempts = 4;
/// Steps taken by sweeps after one that did not converge: bounds the cost of wild motion.
constexpr int kSweptSteps = 1;
/// rad: the next iteration would rotate by about its square. Free trees have no anchor that would
/// take up a lack of angular momentum.
constexpr Real kTurnTolerance = 3e-4, kFreeTurnTolerance = 1e-6, kLeastTurnTolerance = 1e-11;
/// rad, of what hangs on cables: they take up as much as an anchor.
constexpr Real kHangingTurnTolerance = 5e-7;

/// Anchors over a part of the step.
void set_anchors(const World& world, Island& a, const StepPart& part) {
  StepScratch& r = a.scratch;
  r.targets.clear(), r.ways.clear(), r.anchor_velocities.clear();
  for (const Tree& t : a.trees) {
    const bool jumps = t.held_body != kNoSlot && world.bodies.values()[t.held_body].teleport;
    const Vec3 whole = jumps ? Vec3(0) : t.target - t.target_before;
    Vec3 velocity = whole / part.whole;
    if (part.end == 1 && t.held_body != kNoSlot) {
      const Body& b = world.bodies.values()[t.held_body];
      velocity = b.velocity + glm::cross(b.angular_velocity, b.pose.rotation * t.anchor);
    }
    for (int n = 0; n < 3; ++n) {
      r.targets.push_back(t.target[n] - (1 - part.end) * whole[n]);
      r.ways.push_back((part.end - part.begin) * whole[n]);
      r.anchor_velocities.push_back(velocity[n]);
    }
  }
}

/// Turns over a part of the step, rad: up to these the mid-point rule follows the motion of a body
/// alone, whose spin nothing else shows, and of bodies that joints hold.
constexpr Real kTurnAlone = 0.2, kTurnHeld = 1.6;
constexpr Real kShortestAlone = kParts / 64, kShortestHeld = kParts / 16;

/// Length of the first part of the step: bodies that turn fast need shorter ones. Thin bodies on
/// hinges turn about their axes by what their parents do, and are followed as they are.
Real first_part(const World& world, const Island& a, Real h) {
  if (!a.joints.empty()) return kParts;
  Real spin2 = 0;
  for (const std::uint32_t slot : std::span(a.slots).first(a.count())) {
    const Vec3 w = world.bodies.values()[slot].angular_velocity;
    spin2 = std::max(spin2, glm::dot(w, w));
  }
  const bool alone = a.count() == 1;
  const Real most = alone ? kTurnAlone : kTurnHeld;
  const Real shortest = alone ? kShortestAlone : kShortestHeld;
  Real part = kParts;
  for (Real turn2 = h * h * spin2; turn2 > most * most && part > shortest; turn2 /= 4) part /= 2;
  return part;
}

/// Whether weight alone works on the island: every tree is held by an anchor at rest.
bool is_still(const Island& a) {
  if (has_free_tree(a) || a.forced || a.fresh || a.changed) return false;
  for (const Real v : a.scratch.anchor_velocities)
    if (v != 0) return false;
  for (const Real way : a.scratch.ways)
    if (way != 0) return false;
  return ties_hold_still(a);
}

/// Energy due over energy found from which a part of the step is divided: the projection at its end
/// takes the rest. A cable can turn fast, and little is lost where parts resolve it.
Real most_due(const Island& a, Real part, int attempt) {
  constexpr Real kNoBound = std::numeric_limits<Real>::infinity(), kByTrees = 1.2,
                 kByCables = 1.0001;
  if (!a.pins.empty() || !ties_hold_still(a)) return kNoBound;
  if (!a.cables.empty()) return part > 1 && attempt < kDividingAttempts ? kByCables : kNoBound;
  return part > kParts / kResolvingParts && is_still(a) ? kByTrees : kNoBound;
}

/// What is left of a step, by the rules that always end.
bool finish_otherwise(World& world, Island& a, const StepPart& rest, Entity& lost) {
  const Real h = (rest.end - rest.begin) * rest.whole;
  PANTIN_ASSERT(rest.begin < rest.end && rest.end == 1);
  PANTIN_ASSERT(a.scratch.ways.size() == 3 * a.trees.size() &&
                a.pins.size() <= a.scratch.pins_before.size());
  // The parts done so far have moved bodies and anchors.
  StepScratch& r = a.scratch;
  for (std::size_t i = 0; i < r.ways.size(); ++i) r.ways[i] = r.targets[i] - r.ways[i];
  for (std::size_t i = 0; i < a.pins.size(); ++i)
    r.pins_before[i] =
        a.pins[i].target_before + rest.begin * (a.pins[i].target - a.pins[i].target_before);
  if (rest.begin > 0)
    for (Tree& t : a.trees) t.knows_angular_momentum = false;
  update(world, a, h);
  predict_motion(world, a, h);
  for (std::size_t t = 0; t < a.trees.size(); ++t)
    a.trees[t].target_before = {r.ways[3 * t], r.ways[3 * t + 1], r.ways[3 * t + 2]};
  for (std::size_t i = 0; i < a.pins.size(); ++i) a.pins[i].target_before = r.pins_before[i];
  return close_by_sweeps(world, a, h, lost);
}

/// Whether all bodies are somewhere; `lost` is the first that is not.
bool all_found(const World& world, const Island& a, Entity& lost) {
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    const Vec3 x = b.pose.position;
    if (is_finite(b.pose) && is_finite(b.velocity) && is_finite(b.angular_velocity) &&
        glm::dot(x, x) < kTooFar * kTooFar)
      continue;
    lost = a.bodies[c];
    return false;
  }
  return true;
}

}  // namespace

bool conserves(const World& world, const Island& a) {
  return a.finite && a.settings.solver == Solver::articulated && a.swept_steps == 0 &&
         (a.joints.empty() || can_limit(world, a)) && (!has_rows(a) || can_tie(world, a));
}

bool step_conserving(World& world, Island& a, Real h, Entity& lost) {
  const bool follows = !a.fresh && !a.changed && a.last_step == h;
  const Real enough =
      has_free_tree(a) || has_rows(a) || !a.joints.empty() ? kFreeTurnTolerance : kTurnTolerance;
  Real left = kParts;
  bool yields = false, inner = true;
  begin_joints(world, a);
  const bool closes_gaps = begin_closing(world, a, h);
  const bool is_tied = has_rows(a) || !a.joints.empty();
  const bool hangs = !a.cables.empty() && a.pins.empty() && a.joints.empty();
  const auto forget_rows = [&] {
    std::fill(a.scratch.cable_rows.begin(), a.scratch.cable_rows.end(), CableRow::open);
  };
  forget_rows();
  const Real longest = first_part(world, a, h);
  Real part = longest, usual = longest;  // the second but for ends at blows
  Real bent = kParts;                    // as far as cones let the way be straight
  for (int attempt = 1; left > 0; ++attempt) {
    PANTIN_ASSERT(part > 0 && part <= left);
    if (left - part < kLeastRest) part = left;
    const StepPart now{1 - left / kParts, part < left ? 1 - (left - part) / kParts : 1, h, yields};
    set_anchors(world, a, now);
    if (is_tied) begin_ties(world, a, now);
    if (!a.joints.empty())
      begin_limits(world, a, now,
                   2 * attempt < kMostAttempts ? Blows::followed : Blows::within_part);
    const ConservingInput in{h * part / kParts,
                             {world.gravity.x, world.gravity.y, world.gravity.z},
                             a.scratch.targets.data(),
                             a.scratch.ways.data(),
                             a.scratch.anchor_velocities.data(),
                             a.scratch.blocks.data(),
                             is_tied ? kMostTiedIterations : kMostIterations,
                             std::max(enough * std::min(part, Real(1)), kLeastTurnTolerance),
                             hangs && !ties_are_inner(a) ? kHangingTurnTolerance : 0,
                             is_still(a),
                             ties_are_closed(a),
                             a.joints.empty() && part > kShortestHeld,
                             follows && part == kParts,
                             nullptr,
                             nullptr,
                             most_due(a, part, attempt)};
    TiedPart with{now, part, attempt < kEndingAttempts, 2 * attempt < kMostAttempts};
    const bool is_taken =
        is_tied ? conserve_tied(world, a, in, with) : kernels().conserve(view_of(world, a), in);
    bent = with.longest < kParts ? with.longest : is_taken ? 2 * bent : bent;
    if (is_taken) {
      if (is_tied) store_ties(a, now);
      if (!a.joints.empty()) store_joints(world, a, now);
      inner = inner && with.inner;
      left -= part;
      if (with.struck) usual = longest;
      part = std::min({usual, bent, left});
      forget_rows();
    } else if (with.shorter > 0 && attempt < kMostAttempts) {
      part = with.shorter;
    } else if (part > 1 && attempt < kMostAttempts) {
      part = usual = part / 2;
      // Loops that cannot be closed in shorter parts either give way in what is left.
      if (!yields && has_loops(a) && attempt >= kTiedAttempts) yields = true, part = usual = left;
    } else if (!yields && has_rigid_pins(a)) {
      yields = true, part = usual = left, attempt = kMostAttempts / 2;
    } else {
      a.swept_steps = kSweptSteps;
      return finish_otherwise(world, a, {now.begin, 1, h}, lost);
    }
  }
  if (!all_found(world, a, lost)) return false;
  for (Tree& t : a.trees) {
    t.knows_angular_momentum = t.knows_angular_momentum && inner;
    if (a.parents[t.first] == kFree && inner) keep_angular_momentum(world, a, t, h);
  }
  a.contact_active = a.limited = false;
  a.sweeps_used = 0;
  a.knows_torques = true;
  if (closes_gaps) end_closing(world, a, h);
  remember_step(world, a, h);
  return true;
}

}  // namespace pantin::detail::articulated
