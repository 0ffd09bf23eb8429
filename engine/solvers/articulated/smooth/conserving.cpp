// The step of islands without contacts, by the energy-momentum method: it adds no energy, whatever
// the masses and shapes. [Betsch & Steinmann 2001]
#include <algorithm>
#include <limits>

#include "engine/contact/detect.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/articulated/smooth/conserving_joints.hpp"

namespace pantin::detail::articulated {
namespace {

/// Shortest units of a step: a step that does not converge is halved, down to a 256th.
constexpr Real kParts = 256;
/// A shorter remainder, in these units, is merged into the substep before.
constexpr Real kLeastRest = 1e-6;
/// Most substeps for a step that would lose much energy, as when rods snap straight.
constexpr int kResolvingParts = 16;
constexpr int kMostIterations = 8, kMostTiedIterations = 16;
/// Most substeps tried in a step, converged or not: bounds its cost. Of these, those that may end
/// where a cable becomes taut; those that may be divided for energy losses; those after which loops
/// may become compliant.
constexpr int kMostAttempts = 96, kEndingAttempts = 12, kDividingAttempts = 24, kTiedAttempts = 4;
/// Steps taken by sweeps after one that did not converge: bounds the cost of wild motion.
constexpr int kSweptSteps = 1;
/// rad: tolerances of the last rotation; the next iteration would rotate by about its square. Free
/// trees need a smaller one, since no anchor absorbs an error of angular momentum.
constexpr Real kTurnTolerance = 3e-4, kFreeTurnTolerance = 1e-6, kLeastTurnTolerance = 1e-11;
/// rad: tolerance of bodies hanging on cables, which absorb such errors as an anchor does.
constexpr Real kHangingTurnTolerance = 5e-7;

/// Sets the motion of the anchors over a substep.
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

/// rad: largest rotations in a substep for which the mid-point rule is accurate, of a body alone
/// and of bodies on joints.
constexpr Real kTurnAlone = 0.2, kTurnHeld = 1.6;
constexpr Real kShortestAlone = kParts / 64, kShortestHeld = kParts / 16;

/// Length of the first substep of bodies on free ball joints: fast rotations need shorter ones. Not
/// with hinges, where thin bodies follow the rotation of their parents about their axes.
Real first_part(const World& world, const Island& a, Real h) {
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

/// Whether weight alone does work on the island: every tree hangs on an anchor at rest.
bool is_still(const Island& a) {
  if (has_free_tree(a) || a.forced || a.fresh || a.changed) return false;
  for (const Real v : a.scratch.anchor_velocities)
    if (v != 0) return false;
  for (const Real way : a.scratch.ways)
    if (way != 0) return false;
  return ties_hold_still(a);
}

/// Ratio of due to computed energy above which a substep is divided: the velocity projection at its
/// end removes the difference. Cables can rotate fast, and lose little where substeps resolve that.
Real most_due(const Island& a, const PartedStep& s) {
  constexpr Real kNoBound = std::numeric_limits<Real>::infinity(), kByTrees = 1.2,
                 kByCables = 1.0001;
  if (s.hurries || !a.pins.empty() || !ties_hold_still(a)) return kNoBound;
  if (!a.cables.empty()) return s.part > 1 && s.attempt < kDividingAttempts ? kByCables : kNoBound;
  return s.part > kParts / kResolvingParts && is_still(a) ? kByTrees : kNoBound;
}

/// Largest accepted gain of a substep's energy, as a fraction: free trees keep it. What a body does
/// that leads a joint by its rotation is known roughly only.
constexpr Real kGain = 1e-3, kGainOfLed = 1e-2;

bool has_led_turns(const World& world, const Island& a) {
  if (a.joints.empty()) return false;
  return std::any_of(a.trees.begin(), a.trees.end(), [&](const Tree& t) {
    return a.parents[t.first] == kHeld && a.joints[t.first].stiff && t.held_body != kNoSlot &&
           contact::moves(world.bodies.values()[t.held_body]);
  });
}

/// Takes the rest of a step by sweeps, which always terminate.
bool finish_otherwise(World& world, Island& a, const StepPart& rest, Entity& lost) {
  const Real h = (rest.end - rest.begin) * rest.whole;
  PANTIN_ASSERT(rest.begin < rest.end && rest.end == 1);
  PANTIN_ASSERT(a.scratch.ways.size() == 3 * a.trees.size() &&
                a.pins.size() <= a.scratch.pins_before.size());
  // The substeps so far have moved bodies and anchors.
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

/// Whether all bodies are finite and not too far away; `lost` is the first that is not.
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

/// Whether blows at limits are followed in time.
bool follows_blows(const PartedStep& s) { return !s.hurries && 2 * s.attempt < kMostAttempts; }

}  // namespace

bool conserves(const World& world, const Island& a) {
  return a.finite && a.settings.solver == Solver::articulated && a.swept_steps == 0 &&
         (a.joints.empty() || can_limit(world, a)) && (!has_rows(a) || can_tie(world, a));
}

PartedStep begin_parts(World& world, Island& a, Real h) {
  PartedStep s;
  s.h = h, s.follows = !a.fresh && !a.changed && a.last_step == h;
  begin_joints(world, a);
  s.closes_gaps = begin_closing(world, a, h);
  s.takes_up = std::any_of(a.scratch.cable_gaps.begin(), a.scratch.cable_gaps.end(),
                           [](Real gap) { return gap > 0; });
  std::fill(a.scratch.cable_rows.begin(), a.scratch.cable_rows.end(), CableRow::open);
  s.opens = opens_limits(a);
  s.left = s.bent = kParts;
  s.longest = s.part = s.usual = a.joints.empty() || s.opens ? first_part(world, a, h) : kParts;
  return s;
}

ConservingInput begin_part(World& world, Island& a, PartedStep& s) {
  PANTIN_ASSERT(s.part > 0 && s.part <= s.left);
  if (s.hurries) s.part = s.bent = std::min(s.usual, s.left);
  if (s.left - s.part < kLeastRest) s.part = s.left;
  s.now = {1 - s.left / kParts, s.part < s.left ? 1 - (s.left - s.part) / kParts : 1, s.h,
           s.yields};
  set_anchors(world, a, s.now);
  if (is_tied(a)) begin_ties(world, a, s.now);
  const bool stiff = a.scratch.stiff = !a.joints.empty() && !s.opens;
  if (stiff) begin_limits(world, a, s.now, follows_blows(s) ? Blows::followed : Blows::within_part);
  const Real enough =
      has_free_tree(a) || has_rows(a) || stiff ? kFreeTurnTolerance : kTurnTolerance;
  const bool hangs = !a.cables.empty() && a.pins.empty() && !stiff;
  return {s.h * s.part / kParts,
          {world.gravity.x, world.gravity.y, world.gravity.z},
          a.scratch.targets.data(),
          a.scratch.ways.data(),
          a.scratch.anchor_velocities.data(),
          stiff || has_rows(a) ? kMostTiedIterations : kMostIterations,
          std::max(enough * std::min(s.part, Real(1)), kLeastTurnTolerance),
          hangs && !ties_are_inner(a) ? kHangingTurnTolerance : 0,
          a.is_even && !stiff && !has_rows(a),
          is_still(a),
          ties_are_closed(a),
          !stiff && s.part > kShortestHeld,
          s.follows && s.part == kParts,
          nullptr,
          nullptr,
          nullptr,
          most_due(a, s),
          has_led_turns(world, a) ? kGainOfLed : kGain};
}

TiedPart tied_part(const PartedStep& s) {
  return {s.now, s.part, !s.hurries && s.attempt < kEndingAttempts, follows_blows(s)};
}

void end_part(World& world, Island& a, PartedStep& s, const TiedPart& with) {
  s.bent = with.longest < kParts ? with.longest : s.taken ? 2 * s.bent : s.bent;
  if (s.taken) {
    if (is_tied(a)) store_ties(a, s.now);
    if (!a.joints.empty() && !s.opens) store_joints(world, a, s.now);
    s.inner = s.inner && with.inner;
    s.left -= s.part;
    if (with.struck) s.usual = s.longest;
    s.part = std::min({s.usual, s.bent, s.left});
    std::fill(a.scratch.cable_rows.begin(), a.scratch.cable_rows.end(), CableRow::open);
  } else if (with.shorter > 0 && s.attempt < kMostAttempts) {
    s.part = with.shorter;
  } else if (s.part > 1 && s.attempt < kMostAttempts) {
    s.part = s.usual = s.part / 2;
    // Loops that shorter substeps cannot close either become compliant for the rest of the step.
    if (!s.yields && has_loops(a) && s.attempt >= kTiedAttempts)
      s.yields = true, s.part = s.usual = s.left;
  } else if (!s.yields && has_rigid_pins(a)) {
    s.yields = true, s.part = s.usual = s.left, s.attempt = kMostAttempts / 2;
  } else {
    s.fails = true;
  }
  ++s.attempt;
}

bool end_parts(World& world, Island& a, const PartedStep& s, Entity& lost) {
  a.scratch.attempts = s.attempt - 1, a.scratch.hurried = s.hurries;
  if (s.fails) {
    a.swept_steps = kSweptSteps;
    return finish_otherwise(world, a, {s.now.begin, 1, s.h}, lost);
  }
  if (!all_found(world, a, lost)) return false;
  for (Tree& t : a.trees) {
    t.knows_angular_momentum = t.knows_angular_momentum && s.inner;
    if (a.parents[t.first] == kFree && s.inner) keep_angular_momentum(world, a, t, s.h);
  }
  a.contact_active = a.limited = false;
  a.sweeps_used = 0;
  a.knows_torques = true;
  if (s.closes_gaps) end_closing(world, a, s.h);
  remember_step(world, a, s.h);
  return true;
}

void take_part(World& world, Island& a, PartedStep& s) {
  if (s.opens) a.scratch.cable_rows_before = a.scratch.cable_rows;
  ConservingInput in = begin_part(world, a, s);
  OpenPart open{world, a, s.now};
  const OpenLimits limits = open_limits(open);
  if (s.opens) in.limits = &limits;
  TiedPart with = tied_part(s);
  const bool has_hooks = has_rows(a) || a.scratch.stiff;
  s.taken =
      has_hooks ? conserve_tied(world, a, in, with) : kernels().conserve(view_of(world, a), in);
  if (open.are_clear) return end_part(world, a, s, with);
  s.opens = false;  // again, with limits
  a.scratch.cable_rows = a.scratch.cable_rows_before;
  take_part(world, a, s);
}

bool step_conserving(World& world, Island& a, Real h, Entity& lost) {
  PartedStep s = begin_parts(world, a, h);
  while (s.goes_on()) {
    s.hurries = s.hurries || has_to_hurry(a);
    take_part(world, a, s);
  }
  return end_parts(world, a, s, lost);
}

}  // namespace pantin::detail::articulated
