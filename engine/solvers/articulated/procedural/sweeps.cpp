// Sweeps: move every body to the joint to its parent, outwards from an anchored or a pulled body.
// [Lee 2000, sec. 3.2, 3.3 and 4.1]
#include "engine/solvers/articulated/procedural/sweeps.hpp"

#include <algorithm>
#include <optional>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/procedural/compulsive.hpp"

namespace pantin::detail::articulated {
namespace {

/// Sets the rotation of a body and places its anchor at its goal.
void turn_about(Island& a, const Pull& held, Quat rotation) {
  a.scratch.work.set(kFinalRotation, held.column, rotation);
  a.scratch.work.set(kFinalPosition, held.column, held.goal - rotation * held.anchor);
}

/// Moves an anchor of a body exactly to its goal, by the least displacement.
void carry(Island& a, std::size_t c, Vec3 anchor, Vec3 goal) {
  const FinalBody body{a.scratch.work, c};
  const Quat q = body.rotation();
  const Vec3 arm = q * anchor;
  const CompulsiveMotion m =
      least_displacement(arm, goal - (body.position() + arm),
                         {a.constants.at(kMass, c), world_inertia(q, a.constants.vec(kInertia, c))},
                         a.settings.rotation_stiffness);
  turn_about(a, {c, anchor, goal}, glm::normalize(m.rotation * q));
}

/// The nearest rotation that the joint of a body allows, if the current one is not allowed.
std::optional<Quat> clamped_rotation(const Island& a, std::size_t c, Quat own, Quat parent) {
  if (a.joints.empty() || !a.joints[c].stiff) return std::nullopt;
  const Quat rotation = joint_rotation(a.joints[c], own, parent),
             allowed = allowed_rotation(a.joints[c].joint, rotation);
  if (allowed == rotation) return std::nullopt;
  return allowed;
}

/// Rotates a body about its joint point to the nearest pose that the joint allows.
void clamp_to_parent(const World& world, Island& a, std::size_t c, Vec3 joint_point) {
  const Quat parent = parent_rotation(world, a, c, kFinalRotation);
  if (const auto allowed = clamped_rotation(a, c, a.scratch.work.quat(kFinalRotation, c), parent))
    turn_about(a, {c, a.constants.vec(kOwnAnchor, c), joint_point},
               own_rotation(a.joints[c], parent, *allowed));
}

/// The same for the parent of a body, about their joint.
void clamp_parent(Island& a, std::size_t c, Vec3 joint_point) {
  const auto p = static_cast<std::size_t>(a.parents[c]);
  const Quat own = a.scratch.work.quat(kFinalRotation, c);
  if (const auto allowed = clamped_rotation(a, c, own, a.scratch.work.quat(kFinalRotation, p)))
    turn_about(a, {p, a.constants.vec(kParentAnchor, c), joint_point},
               inboard_rotation(a.joints[c], own, *allowed));
}

/// Closes the joint of a body to its parent.
void follow_parent(const World& world, Island& a, std::size_t c) {
  PANTIN_ASSERT(a.parents[c] >= 0);
  const FinalBody parent{a.scratch.work, static_cast<std::size_t>(a.parents[c])};
  const Vec3 goal = parent.point(a.constants.vec(kParentAnchor, c));
  carry(a, c, a.constants.vec(kOwnAnchor, c), goal);
  clamp_to_parent(world, a, c, goal);
}

}  // namespace

void lead_parent(Island& a, std::size_t c) {
  PANTIN_ASSERT(a.parents[c] >= 0);
  const Vec3 goal = FinalBody{a.scratch.work, c}.point(a.constants.vec(kOwnAnchor, c));
  carry(a, static_cast<std::size_t>(a.parents[c]), a.constants.vec(kParentAnchor, c), goal);
  clamp_parent(a, c, goal);
}

void sweep_from(const World& world, Island& a, const Tree& tree, const Pull& from) {
  PANTIN_ASSERT(from.column - tree.first < tree.count);
  PANTIN_ASSERT(a.scratch.on_path.size() >= a.count());
  const std::size_t end = tree.first + tree.count;
  std::fill(a.scratch.on_path.begin() + tree.first,
            a.scratch.on_path.begin() + static_cast<std::ptrdiff_t>(end), std::uint8_t(0));
  carry(a, from.column, from.anchor, from.goal);
  for (std::size_t c = from.column;; c = static_cast<std::size_t>(a.parents[c])) {
    a.scratch.on_path[c] = 1;
    if (a.parents[c] < 0) break;
    lead_parent(a, c);
  }
  for (std::size_t c = tree.first; c < end; ++c)
    if (!a.scratch.on_path[c]) follow_parent(world, a, c);
}

void sweep_from_root(const World& world, Island& a, const Tree& tree) {
  if (a.parents[tree.first] == kHeld) {
    carry(a, tree.first, a.constants.vec(kOwnAnchor, tree.first), tree.target);
    clamp_to_parent(world, a, tree.first, tree.target);
  }
  for (std::size_t c = tree.first + 1; c < tree.first + tree.count; ++c) follow_parent(world, a, c);
}

void sweep_closed(const World& world, Island& a) {
  for (const Tree& t : a.trees) sweep_from_root(world, a, t);
}

void place_free_root(Island& a, const Tree& tree, Real h) {
  LaneTable& w = a.scratch.work;
  const std::size_t root = tree.first;
  const Quat q = w.quat(kRotation, root);
  const Vec3 x = w.vec(kPosition, root);
  const Real mass = a.constants.at(kMass, root);
  const Mat3 inertia = world_inertia(q, a.constants.vec(kInertia, root));
  // Mass of the outboard subtree of each body.
  std::vector<Real>& outboard = a.scratch.outboard;
  for (std::size_t c = tree.first; c < tree.first + tree.count; ++c)
    outboard[c] = a.constants.at(kMass, c);
  for (std::size_t c = tree.first + tree.count; c-- > tree.first + 1;)
    outboard[static_cast<std::size_t>(a.parents[c])] += outboard[c];
  Vec3 translation(0), rotation(0);
  Real weight = 0;
  for (std::size_t c = tree.first + 1; c < tree.first + tree.count; ++c) {
    if (a.parents[c] != static_cast<std::int32_t>(root)) continue;
    const Vec3 arm = q * a.constants.vec(kParentAnchor, c);
    const Vec3 own = point_at(a, c, a.constants.vec(kOwnAnchor, c), kPredictedPoses);
    const Vec3 goal = meeting_point(mass, x + arm, outboard[c], own);
    const Vec3 gap = goal - (x + arm);
    CompulsiveMotion m =
        least_displacement(arm, gap, {mass, inertia}, a.settings.rotation_stiffness);
    if (a.settings.solver == Solver::procedural) {
      const Real about = inertia_about_turn(arm, gap, inertia);
      m = literal_rule(arm, gap,
                       a.settings.procedural_reluctance == ProceduralReluctance::literal_step
                           ? about * h * h / (2 * mass)
                           : about / mass);
    }
    translation += outboard[c] * m.translation,
        rotation += outboard[c] * rotation_vector(m.rotation);
    weight += outboard[c];
  }
  w.set(kPosition, root, x + translation / weight);
  w.set(kRotation, root, glm::normalize(from_rotation_vector(rotation / weight) * q));
}

void literal_sweep(Island& a, Real h) {
  LaneTable& w = a.scratch.work;
  auto tree = a.trees.begin();
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Quat q = w.quat(kRotation, c);
    const Vec3 x = w.vec(kPosition, c), anchor = a.constants.vec(kOwnAnchor, c), arm = q * anchor;
    Vec3 goal = x + arm;
    if (a.parents[c] >= 0)
      goal = FinalBody{w, static_cast<std::size_t>(a.parents[c])}.point(
          a.constants.vec(kParentAnchor, c));
    else if (const Tree& t = *tree++; a.parents[c] == kHeld)
      goal = t.target;
    const Vec3 gap = goal - (x + arm);
    const Real mass = a.constants.at(kMass, c);
    const Real about = inertia_about_turn(arm, gap, world_inertia(q, a.constants.vec(kInertia, c)));
    const CompulsiveMotion m =
        literal_rule(arm, gap,
                     a.settings.procedural_reluctance == ProceduralReluctance::literal_step
                         ? about * h * h / (2 * mass)
                         : about / mass);
    turn_about(a, {c, anchor, goal}, glm::normalize(m.rotation * q));
  }
}

}  // namespace pantin::detail::articulated
