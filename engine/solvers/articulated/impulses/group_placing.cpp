// Placement of trees in contact: bodies rotate by their spins, then joints place them.
#include "engine/solvers/articulated/impulses/group_placing.hpp"

#include <algorithm>
#include <span>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// m, in a substep: tolerance between the integrated pose and the pose that the joints allow, and
/// of contacts.
constexpr Real kPoseTolerance = 1e-5;
constexpr int kMostRounds = 4;

/// The axis about which a body is most nearly symmetric.
int symmetry_axis(Vec3 inertia) {
  const Vec3 apart(std::abs(inertia.y - inertia.z), std::abs(inertia.z - inertia.x),
                   std::abs(inertia.x - inertia.y));
  return apart.x <= apart.y && apart.x <= apart.z ? 0 : apart.y <= apart.z ? 1 : 2;
}

/// Rotates a body by its spin. The spin about its symmetry axis is carried along with the axis, so
/// that a body rolling on its side stays there.
Quat turned(const GroupBody& b, const GroupNode& n, Real h) {
  const int k = symmetry_axis(n.inertia);
  Vec3 inside = glm::conjugate(n.rotation) * b.spin, about(0);
  about[k] = inside[k], inside[k] = 0;
  return glm::normalize(n.rotation * from_rotation_vector(h * inside) *
                        from_rotation_vector(h * about));
}

/// The rotation of a body, projected to what the kind and limits of its joint allow.
Quat as_allowed(const GroupNode& n, Quat q, Quat parent) {
  if (!n.joint) return q;
  const Joint& joint = n.joint->joint;
  if (turns_of(joint.kind) == Turns::freely && !n.is_limited) return q;
  const Quat turned = joint_rotation(*n.joint, q, parent);
  const Quat allowed = allowed_rotation(joint, turned);
  return allowed == turned ? q : own_rotation(*n.joint, parent, allowed);
}

}  // namespace

Moved place_of(const GroupTree& t, Real fraction) {
  return {held_rotation_at(t, fraction), t.from + fraction * (t.to - t.from)};
}

void place_by_joints(const Group& g, const GroupTree& t, const Moved& to) {
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    const GroupNode& n = g.nodes[i];
    GroupBody& b = g.bodies[n.body];
    if (n.free_root) {
      b.pose.rotation = n.turned;
      continue;
    }
    PANTIN_ASSERT(n.parent == kNoNode || n.parent < i);
    const GroupBody* p = n.parent == kNoNode ? nullptr : &g.bodies[g.nodes[n.parent].body];
    b.pose.rotation = as_allowed(n, n.turned, p ? p->pose.rotation : to.held);
    b.pose.position =
        (p ? to_world(p->pose, n.parent_anchor) : to.anchor) - b.pose.rotation * n.own_anchor;
  }
}

Real respond_to_impulses(const Group& g, const GroupTree& t) {
  for (std::uint32_t i = t.first + t.count; i-- > t.first;) gather_impulse(g, i);
  Real most = 0;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    GroupNode& n = g.nodes[i];
    follow_impulse(g, i);
    n.kept = g.bodies[n.body].pose;
    most = std::max(most, glm::length(n.passing.torque));
  }
  return most;
}

void turn_by(const Group& g, const GroupTree& t, Real part) {
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    GroupNode& n = g.nodes[i];
    GroupBody& b = g.bodies[n.body];
    n.turned = glm::normalize(from_rotation_vector(part * n.passing.torque) * b.pose.rotation);
    if (n.free_root) b.pose.position += part * n.passing.force;
  }
}

void turn_back(const Group& g, const GroupTree& t) {
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i)
    g.bodies[g.nodes[i].body].pose = g.nodes[i].kept;
}

namespace {

/// Distances between the bodies and their goals: the largest, m, and the sum of mass times
/// distance squared.
struct Miss {
  Real largest = 0, sum = 0;
};

Miss miss_of(const Group& g, const GroupTree& t) {
  Miss miss;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    const GroupNode& n = g.nodes[i];
    const Real way = glm::length(n.goal - g.bodies[n.body].pose.position);
    miss.largest = std::max(miss.largest, way), miss.sum += n.mass * way * way;
  }
  return miss;
}

/// Impulses towards the goals, weighted by mass, so that light links do not throw about the heavy
/// bodies that hang on them.
void push_towards_goals(const Group& g, const GroupTree& t) {
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    GroupNode& n = g.nodes[i];
    const Vec3 impulse = n.mass * (n.goal - g.bodies[n.body].pose.position);
    n.passing = {impulse, glm::cross(n.arm, impulse)};
  }
}

/// Places the bodies by their joints, then minimises the mass-weighted distances to their goals by
/// rotations (Gauss-Newton steps). They would turn bodies on which a tree stands.
void close_joints(const Group& g, const GroupTree& t, const Moved& to) {
  place_by_joints(g, t, to);
  if (t.stands) return;
  Miss miss = miss_of(g, t);
  for (int round = 0; round < kMostRounds && miss.largest > kPoseTolerance; ++round) {
    push_towards_goals(g, t);
    // The response is linearised: limit the largest rotation.
    turn_by(g, t, kFarthestTurn / std::max(kFarthestTurn, respond_to_impulses(g, t)));
    place_by_joints(g, t, to);
    const Miss now = miss_of(g, t);
    if (!(now.sum < miss.sum)) return turn_back(g, t);
    miss = now;
  }
}

/// Integrates poses without regard to joints: goals of positions and rotations.
void set_goals(const Group& g, GroupTree& t, const GroupPart& part) {
  t.can_be_held = !t.stands && !t.has_loops && (!is_free(g, t) || t.is_tied_outside);
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    GroupNode& n = g.nodes[i];
    GroupBody& b = g.bodies[n.body];
    n.goal = b.pose.position + part.h * own_velocity(b, n);
    n.turned = turned(b, n, part.h);
    if (n.free_root) b.pose.position = n.goal;
    t.touched = t.touched || b.touched;
  }
}

/// m: how much deeper two bodies are than their velocities say, where they press on each other.
Real pressed_in(const Group& g, const GroupContact& c, Real h) {
  if (!c.works || !(c.impulse.x > 0)) return 0;
  const GroupBody &a = g.a(c), &b = g.b(c);
  const Vec3 n = c.axes[0];
  const Vec3 on_a = a.pose.position + c.on_a.at(a.pose.rotation, -n),
             on_b = b.pose.position + c.on_b.at(b.pose.rotation, n);
  const Real parted = c.gap + h * glm::dot(n, speed_at(a, c.arm_a) - speed_at(b, c.arm_b));
  return std::min(parted, Real(0)) - glm::dot(n, on_a - on_b);
}

/// An end of a contact, as hold_contacts() moves it.
struct HeldEnd {
  const Group& g;
  const GroupBody& body;
  GroupTree* const tree;  // null: the body stays

  HeldEnd(const Group& group, const GroupBody& b) : g(group), body(b), tree(tree_of(group, b)) {}

  /// 1/kg: response to an impulse at a point.
  Real response(Vec3 arm, Vec3 along) const {
    if (!tree) return 0;
    const Response& r = g.nodes[body.node].response;
    const Vec3 torque = glm::cross(arm, along);
    const Vec3 velocity = r.vf * along + r.vt * torque, spin = along * r.vt + r.wt * torque;
    return glm::dot(along, velocity + glm::cross(spin, arm));
  }
  /// Adds an impulse to `passing`, and marks the tree.
  void push(Vec3 arm, Vec3 impulse) const {
    if (!tree) return;
    for (std::uint32_t i = 0; !tree->is_held && i < tree->count; ++i)
      g.nodes[tree->first + i].passing = {};
    tree->is_held = true;
    g.nodes[body.node].passing += {impulse, glm::cross(arm, impulse)};
  }

 private:
  static GroupTree* tree_of(const Group& g, const GroupBody& b) {
    if (b.node == kNoNode) return nullptr;
    GroupTree& t = g.trees[g.nodes[b.node].tree];
    return t.can_be_held ? &t : nullptr;
  }
};

/// Whether a contact presses trees that can be held, and no others.
bool are_held(const HeldEnd& a, const HeldEnd& b) {
  const auto other = [](const HeldEnd& e) { return e.body.node != kNoNode && !e.tree; };
  return (a.tree || b.tree) && !other(a) && !other(b);
}

/// Calls `act(contact, depth, number of such points of the pair)` for all points at which trees are
/// pressed in by more than the tolerance. Returns the sum of squares of depths, m^2.
template <class Act>
Real each_pressed(const Group& g, Real h, const Act& act) {
  Real sum = 0;
  for (const GroupPair& p : g.pairs) {
    if (p.working == 0) continue;
    const std::span<GroupContact> contacts = g.contacts.subspan(p.first, p.count);
    if (!are_held(HeldEnd(g, g.a(contacts[0])), HeldEnd(g, g.b(contacts[0])))) continue;
    Real deep[kMostPoints], points = 0;
    for (std::size_t i = 0; i < contacts.size(); ++i)
      deep[i] = pressed_in(g, contacts[i], h), points += deep[i] > kPoseTolerance;
    for (std::size_t i = 0; points > 0 && i < contacts.size(); ++i)
      if (deep[i] > kPoseTolerance) sum += deep[i] * deep[i], act(contacts[i], deep[i], points);
  }
  return sum;
}

}  // namespace

void place_tree(const Group& g, GroupTree& t, const GroupPart& part) {
  set_goals(g, t, part);
  close_joints(g, t, place_of(t, part.end));
}

// Joints that are closed by least squares straighten a chain that a heavy body pulls taut around an
// obstacle: its links would be pulled into the obstacle, whatever impulses act there. Not for free
// trees, which are shifted afterwards to keep their mass centres, and for loops, which would open.
// What presses these is not moved alone, as a wheel in a chain.
void hold_contacts(const Group& g, const GroupPart& part) {
  bool any = false;
  for (GroupTree& t : g.trees) any = any || t.can_be_held, t.is_held = false;
  if (!any || g.contacts.empty() || !(part.h > 0)) return;
  const Real before = each_pressed(g, part.h, [&](const GroupContact& c, Real deep, Real points) {
    const HeldEnd a(g, g.a(c)), b(g, g.b(c));
    const Real along = a.response(c.arm_a, c.axes[0]) + b.response(c.arm_b, c.axes[0]);
    if (!(along > 0)) return;
    const Vec3 impulse = deep / (points * along) * c.axes[0];
    a.push(c.arm_a, impulse), b.push(c.arm_b, -impulse);
  });
  if (before == 0) return;
  for (const GroupTree& t : g.trees) {
    if (!t.is_held) continue;
    turn_by(g, t, kFarthestTurn / std::max(kFarthestTurn, respond_to_impulses(g, t)));
    place_by_joints(g, t, place_of(t, part.end));
  }
  const auto looks = [](const GroupContact& /*c*/, Real /*deep*/, Real /*points*/) {};
  if (each_pressed(g, part.h, looks) <= before) return;
  for (const GroupTree& t : g.trees)
    if (t.is_held) turn_back(g, t);
}

}  // namespace pantin::detail::articulated
