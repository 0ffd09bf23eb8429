#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/compulsive.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// One body at its final pose.
struct FinalBody {
  LaneTable& work;
  std::size_t column;

  Quat rotation() const { return work.quat(kFinalRotation, column); }
  Vec3 position() const { return work.vec(kFinalPosition, column); }
  Vec3 point(Vec3 anchor) const { return position() + rotation() * anchor; }
};

/// Moves an anchor of a body to its goal by the least displacement, exactly.
void carry(Island& a, std::size_t c, Vec3 anchor, Vec3 goal) {
  const FinalBody body{a.scratch.work, c};
  const Quat q = body.rotation();
  const Vec3 arm = q * anchor;
  const CompulsiveMotion m =
      least_displacement(arm, goal - (body.position() + arm),
                         {a.constants.at(kMass, c), world_inertia(q, a.constants.vec(kInertia, c))},
                         a.settings.rotation_stiffness);
  const Quat rotated = glm::normalize(m.rotation * q);
  a.scratch.work.set(kFinalRotation, c, rotated);
  a.scratch.work.set(kFinalPosition, c, goal - rotated * anchor);
}

bool is_stiff(const Island& a, std::size_t c) { return !a.joints.empty() && a.joints[c].stiff; }

/// Rotates a body about its joint point to the nearest pose that the joint allows.
void clamp_to_parent(const World& world, Island& a, std::size_t c, Vec3 joint_point) {
  if (!is_stiff(a, c)) return;
  const PackedJoint& j = a.joints[c];
  const Quat own = a.scratch.work.quat(kFinalRotation, c);
  const Quat parent = parent_rotation(world, a, c, kFinalRotation);
  const Quat rotation = joint_rotation(j, own, parent),
             allowed = allowed_rotation(j.joint, rotation);
  if (allowed == rotation) return;
  const Quat rotated = own_rotation(j, parent, allowed);
  a.scratch.work.set(kFinalRotation, c, rotated);
  a.scratch.work.set(kFinalPosition, c, joint_point - rotated * a.constants.vec(kOwnAnchor, c));
}

/// The same for the parent of a body, about their joint.
void clamp_parent(Island& a, std::size_t c, Vec3 joint_point) {
  if (!is_stiff(a, c) || a.parents[c] < 0) return;
  const auto p = static_cast<std::size_t>(a.parents[c]);
  const PackedJoint& j = a.joints[c];
  const Quat own = a.scratch.work.quat(kFinalRotation, c),
             parent = a.scratch.work.quat(kFinalRotation, p);
  const Quat rotation = joint_rotation(j, own, parent),
             allowed = allowed_rotation(j.joint, rotation);
  if (allowed == rotation) return;
  PackedJoint seen_from_parent = j;
  seen_from_parent.own_is_a = !j.own_is_a;
  const Quat rotated = own_rotation(seen_from_parent, own, allowed);
  a.scratch.work.set(kFinalRotation, p, rotated);
  a.scratch.work.set(kFinalPosition, p, joint_point - rotated * a.constants.vec(kParentAnchor, c));
}

/// Closes the joint of a body to its parent.
void follow_parent(const World& world, Island& a, std::size_t c) {
  PANTIN_ASSERT(a.parents[c] >= 0);
  const FinalBody parent{a.scratch.work, static_cast<std::size_t>(a.parents[c])};
  const Vec3 goal = parent.point(a.constants.vec(kParentAnchor, c));
  carry(a, c, a.constants.vec(kOwnAnchor, c), goal);
  clamp_to_parent(world, a, c, goal);
}

/// A point of a packed body, in its frame, and where it is to go, world.
struct Pull {
  std::size_t column = 0;
  Vec3 anchor{0}, goal{0};
};

/// A sweep from a pin: from its body to the root, then all other bodies outwards.
void sweep_from(const World& world, Island& a, const Tree& tree, const Pull& from) {
  PANTIN_ASSERT(from.column - tree.first < tree.count);
  PANTIN_ASSERT(a.scratch.on_path.size() >= a.count());
  Vec3 anchor = from.anchor, goal = from.goal;
  const std::size_t end = tree.first + tree.count;
  std::fill(a.scratch.on_path.begin() + tree.first,
            a.scratch.on_path.begin() + static_cast<std::ptrdiff_t>(end), std::uint8_t(0));
  std::size_t child = a.count();
  for (std::size_t c = from.column;;) {
    carry(a, c, anchor, goal);
    if (child < a.count()) clamp_parent(a, child, goal);
    a.scratch.on_path[c] = 1;
    if (a.parents[c] < 0) break;
    goal = FinalBody{a.scratch.work, c}.point(a.constants.vec(kOwnAnchor, c));
    anchor = a.constants.vec(kParentAnchor, c);
    child = c, c = static_cast<std::size_t>(a.parents[c]);
  }
  for (std::size_t c = tree.first; c < end; ++c)
    if (!a.scratch.on_path[c]) follow_parent(world, a, c);
}

/// The closing sweep: the root to its target, then all other bodies outwards.
void sweep_from_root(const World& world, Island& a, const Tree& tree) {
  if (a.parents[tree.first] == kHeld) {
    carry(a, tree.first, a.constants.vec(kOwnAnchor, tree.first), tree.target);
    clamp_to_parent(world, a, tree.first, tree.target);
  }
  for (std::size_t c = tree.first + 1; c < tree.first + tree.count; ++c) follow_parent(world, a, c);
}

/// Where a pin is to be, world.
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

/// The end of a cable that moves where both could.
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

/// Moves the packed end of a taut cable to the nearest point within its length.
void pull_cable(const World& world, Island& a, const PackedCable& cord, MovingEnd preferred) {
  const CableParameters& s = world.cables.values()[cord.cable].joint;
  const bool has_a = cord.column_a != UINT32_MAX, has_b = cord.column_b != UINT32_MAX;
  const auto [pa, pb] = ends_of(world, a, cord);
  const Real span = glm::length(pb - pa);
  if (s.compliance > 0 || !(span > s.length * (1 + 1e-12))) return;
  PANTIN_ASSERT(has_a || has_b);
  const bool move_b = has_b && (preferred == MovingEnd::b || !has_a);
  const Vec3 way = s.length / span * (pb - pa);
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

/// How far the worst pin is from its place, or how much too long the worst cable is, m.
Real worst_residual(const World& world, const Island& a) {
  Real worst = 0;
  for (const PackedPin& h : a.pins)
    if (h.compliance == 0) worst = std::max(worst, residual(a, h));
  for (const PackedCable& cord : a.cables)
    if (const CableParameters& s = world.cables.values()[cord.cable].joint; s.compliance == 0) {
      const CableEnds e = ends_of(world, a, cord);
      worst = std::max(worst, glm::length(e.b - e.a) - s.length);
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
    const Quat rotated = glm::normalize(m.rotation * q);
    w.set(kFinalRotation, c, rotated);
    w.set(kFinalPosition, c, goal - rotated * anchor);
  }
}

}  // namespace pantin::detail::articulated
