// The step of islands that have only free ball joints and touch nothing, by the energy-momentum
// method: no energy is gained, whatever the masses and shapes. [Betsch & Steinmann 2001]
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// A step that does not converge is halved, down to a 256th.
constexpr int kParts = 256;
constexpr int kMostIterations = 8;
/// Parts tried in a step, converged or not: bounds its cost.
constexpr int kMostAttempts = 48;
/// Steps taken by projection after one that did not converge: bounds the cost of wild motion.
constexpr int kProjectedSteps = 30;
/// rad: the next iteration would rotate by about its square. Free trees have no anchor that would
/// take up a lack of angular momentum.
constexpr Real kEnough = 3e-4, kEnoughFree = 1e-6;

/// A part of the step, by the fractions of it at which it begins and ends.
struct StepPart {
  Real begin, end;
};

/// Anchors over a part of the step of length h.
void set_anchors(const World& world, Island& a, Real h, const StepPart& part) {
  StepScratch& r = a.scratch;
  r.targets.clear(), r.ways.clear(), r.anchor_velocities.clear();
  for (const Tree& t : a.trees) {
    const bool jumps = t.held_body != kNoSlot && world.bodies.values()[t.held_body].teleport;
    const Vec3 whole = jumps ? Vec3(0) : t.target - t.target_before;
    Vec3 velocity = whole / h;
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

/// Whether weight alone works on the island: every tree is held by an anchor at rest.
bool is_still(const Island& a) {
  if (has_free_tree(a) || a.forced || a.fresh || a.changed) return false;
  for (const Real v : a.scratch.anchor_velocities)
    if (v != 0) return false;
  for (const Real way : a.scratch.ways)
    if (way != 0) return false;
  return true;
}

/// The last parts of a step that does not converge in small ones either: by the rules that always
/// end.
bool finish_otherwise(World& world, Island& a, Real h, Entity& lost) {
  a.projected_steps = kProjectedSteps;
  // The parts done so far have moved bodies and anchors.
  StepScratch& r = a.scratch;
  for (std::size_t i = 0; i < r.ways.size(); ++i) r.ways[i] = r.targets[i] - r.ways[i];
  for (Tree& t : a.trees) t.knows_angular_momentum = false;
  update(world, a, h);
  predict_motion(world, a, h);
  for (std::size_t t = 0; t < a.trees.size(); ++t)
    a.trees[t].target_before = {r.ways[3 * t], r.ways[3 * t + 1], r.ways[3 * t + 2]};
  begin_step(world, a, h);
  return finish_step(world, a, h, lost);
}

}  // namespace

bool conserves(const Island& a) {
  return a.finite && a.settings.solver == Solver::articulated && a.settings.tension_stiffness &&
         a.projected_steps == 0 && !a.follows && a.cables.empty() && a.pins.empty() &&
         a.joints.empty() && a.scratch.contact_rows.empty();
}

bool step_conserving(World& world, Island& a, Real h, Entity& lost) {
  const bool follows = !a.fresh && !a.changed && a.last_step == h;
  const Real enough = has_free_tree(a) ? kEnoughFree : kEnough;
  const IslandView p = view_of(world, a);
  int left = kParts;
  for (int part = kParts, attempt = 1; left > 0; ++attempt) {
    set_anchors(world, a, h, {Real(kParts - left) / kParts, Real(kParts - left + part) / kParts});
    const ConservingInput in{h * part / kParts,
                             {world.gravity.x, world.gravity.y, world.gravity.z},
                             a.scratch.targets.data(),
                             a.scratch.ways.data(),
                             a.scratch.anchor_velocities.data(),
                             a.scratch.blocks.data(),
                             kMostIterations,
                             enough,
                             is_still(a),
                             follows && part == kParts};
    if (kernels().conserve(p, in)) {
      left -= part;
    } else if (part > 1 && attempt < kMostAttempts) {
      part /= 2;
    } else {
      return finish_otherwise(world, a, h * left / kParts, lost);
    }
  }
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    const Vec3 x = b.pose.position;
    if (is_finite(b.pose) && is_finite(b.velocity) && is_finite(b.angular_velocity) &&
        glm::dot(x, x) < kTooFar * kTooFar)
      continue;
    lost = a.bodies[c];
    return false;
  }
  for (Tree& t : a.trees)
    if (a.parents[t.first] == kFree) keep_angular_momentum(world, a, t, h);
  a.in_contact = a.contact_active = a.limited = a.disturbed = false;
  a.force_share = 1, a.reserve = 0;
  remember_step(world, a, h);
  a.calm_steps = 0;  // the other rules have no history to go on
  return true;
}

}  // namespace pantin::detail::articulated
