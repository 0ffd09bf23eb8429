// Joints, limits, actuators and ties of a group at rest (group_rest.cpp), as rows of its convex
// problem.
//
// A joint holds its point and the axes about which it does not rotate, by impulses of either sign.
// Limits and cables act one way. What they may move until then is their goal. Compliances are as
// small as those of contacts. Springs, friction and motors follow their laws at the end of the
// step. At the end the impulses of contacts, limits, actuators, cables and springs act on the trees
// through their joints (group_trees.cpp) and loops (group_loops.cpp), which stay closed exactly.
#include "engine/base/rotation.hpp"
#include "engine/joints/joint_force.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/impulses/group_resting.hpp"
#include "engine/solvers/articulated/impulses/group_ties.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

using Of = RestLink::Of;

Real dot(const Wrench& a, const Wrench& b) {
  return glm::dot(a.force, b.force) + glm::dot(a.torque, b.torque);
}
Wrench times(const Wrench& w, Real by) { return {by * w.force, by * w.torque}; }

Real speed_of(const Group& g, const RestLink& l, Wrench RestBody::*motion) {
  const Real of_a = dot(l.on_a, motion_of(g, l.a, motion));
  return l.a == l.b ? of_a : of_a + dot(l.on_b, motion_of(g, l.b, motion));
}

/// Response of a body without joints to its wrench.
Real response_of(const GroupBody& b, const Wrench& w) {
  return b.per_mass * glm::dot(w.force, w.force) + glm::dot(w.torque, b.response * w.torque);
}

void set_compliance(const Group& g, RestLink& l) {
  Real response = response_of(g.bodies[l.a], l.on_a);
  if (l.b != l.a) response += response_of(g.bodies[l.b], l.on_b);
  l.compliance = kRestCompliance * response;
  l.size = l.on_a.force == Vec3(0) ? size_of(g.bodies[l.a]) : 1;
}

/// Two points, by their arms from the mass centres.
struct Ends {
  std::uint32_t a, b;
  Vec3 arm_a, arm_b;
};

/// The relative velocity of two points along an axis.
RestLink along_axis(const Group& g, const Ends& ends, Vec3 axis) {
  RestLink l;
  l.a = ends.a, l.b = ends.b;
  l.on_a = {axis, glm::cross(ends.arm_a, axis)};
  l.on_b = {-axis, -glm::cross(ends.arm_b, axis)};
  set_compliance(g, l);
  return l;
}

/// The relative spin about an axis.
RestLink about_axis(const Group& g, const Ends& ends, Vec3 axis) {
  RestLink l;
  l.a = ends.a, l.b = ends.b;
  l.on_a.torque = axis, l.on_b.torque = -axis;
  set_compliance(g, l);
  return l;
}

/// Where the next rows of a group go.
struct Rows {
  const Group& g;
  std::size_t next = 0;
  void add(RestLink l) {
    PANTIN_ASSERT(next < g.rest_links.size());
    g.rest_links[next++] = l;
  }
};

/// The rotations that a joint holds: axes across the free ones.
std::size_t held_axes(const GroupNode& n, Quat own, Quat parent, Vec3 (&held)[3]) {
  const Turns turns = n.joint ? turns_of(n.joint->joint.kind) : Turns::freely;
  if (turns == Turns::freely) return 0;
  if (turns != Turns::about_x && turns != Turns::about_two) {
    std::copy(std::begin(kAxes), std::end(kAxes), held);
    return 3;
  }
  const FreeAxes free = free_axes(*n.joint, own, parent);
  if (turns == Turns::about_two) {
    held[0] = glm::normalize(glm::cross(free.first, free.second));
    return 1;
  }
  Vec3 axes[3];
  contact::set_axes(axes, free.first);
  held[0] = axes[1], held[1] = axes[2];
  return 2;
}

/// A step, and the speed that limits and cables may have in it, m/s.
struct Reach {
  const GroupPart& part;
  Real fast;
  Real h = part.h;
};

/// A joint between the bodies of its ends at the start of the step.
struct PlacedJoint {
  const GroupNode& n;
  Ends ends;
  JointTurn at;
};

void add_limits(Rows& rows, const PlacedJoint& joint, const Reach& reach) {
  const auto& [n, ends, at] = joint;
  JointLimit found[4];
  find_limits(*n.joint, at.own, at.parent, found);
  for (std::uint32_t s = 0; s < 4; ++s) {
    if (!found[s].watched) continue;
    RestLink l = about_axis(rows.g, ends, -found[s].along);
    if (!found[s].both_ways && found[s].clearance * l.size > 2 * reach.h * reach.fast) continue;
    l.of = found[s].both_ways ? Of::lock : Of::limit;
    l.number = rows.g.bodies[ends.a].node, l.side = s;
    l.goal = l.of == Of::lock ? 0 : -std::max(Real(0), found[s].clearance) / reach.h;
    l.last = n.limits[s].impulse;
    rows.add(l);
  }
}

void add_actuator(Rows& rows, const PlacedJoint& joint) {
  const auto& [n, ends, at] = joint;
  const auto [axis, angle] = actuated_axis_of(n, at.own, at.parent);
  RestLink l = about_axis(rows.g, ends, axis);
  l.of = Of::actuator, l.number = rows.g.bodies[ends.a].node;
  l.dof = n.actuator.dof, l.angle = angle, l.h = at.part.h;
  rows.add(l);
}

/// Soft zones and the drive. They act as part of the joint's mobility.
void add_springs(Rows& rows, const PlacedJoint& joint) {
  for (const TurnSpring& s : springs_of(joint.n, joint.at)) {
    if (!(s.damping > 0)) continue;
    RestLink l = about_axis(rows.g, joint.ends, s.along);
    l.of = Of::spring, l.number = rows.g.bodies[joint.ends.a].node;
    l.compliance = 1 / s.damping, l.goal = s.torque / s.damping;
    rows.add(l);
  }
}

void add_joint(Rows& rows, const GroupNode& n, const Reach& reach) {
  const Group& g = rows.g;
  const GroupBody& own = g.bodies[n.body];
  Ends ends{n.body, n.body, own.pose.rotation * n.own_anchor, Vec3(0)};
  Quat parent = g.trees[n.tree].held_after.rotation;
  if (n.parent != kNoNode) {
    ends.b = g.nodes[n.parent].body;
    parent = g.bodies[ends.b].pose.rotation;
    ends.arm_b = parent * n.parent_anchor;
  }
  const auto add = [&](RestLink l) {
    l.of = Of::joint;
    rows.add(l);
  };
  for (const Vec3& axis : kAxes) add(along_axis(g, ends, axis));
  Vec3 held[3];
  const std::size_t count = held_axes(n, own.pose.rotation, parent, held);
  for (std::size_t k = 0; k < count; ++k) add(about_axis(g, ends, held[k]));
  const PlacedJoint joint{n, ends, {own.pose.rotation, parent, g.time, reach.part}};
  if (n.is_limited) add_limits(rows, joint, reach);
  if (n.has_spring) add_springs(rows, joint);
  if (n.actuator.dof) add_actuator(rows, joint);
}

/// The stretch of a tie at the start of the step.
struct Stretch {
  Real h, by;
};
/// Gives a row the law of a spring and a damper.
void soften(RestLink& l, const GroupTie& t, const Stretch& s) {
  const Real soft = s.h * (s.h * t.stiffness + t.damping);
  l.compliance = 1 / soft, l.goal = s.h * t.stiffness * s.by / soft;
}

/// A cable that may become taut. Its tension is the impulse.
void add_cable(Rows& rows, std::uint32_t number, const Reach& reach) {
  const Group& g = rows.g;
  GroupTie& t = g.ties[number];
  place_tie(g, t);
  const Real span = glm::length(t.apart), stretch = span - t.length;
  if (stretch < -2 * reach.h * reach.fast || !(span > 0)) return;
  Ends ends{t.a, t.b, t.arm_a, t.arm_b};
  RestLink l = along_axis(g, ends, t.apart / span);
  l.of = Of::cable, l.number = number, l.last = t.impulse.x;
  l.goal = stretch > 0 ? kRestClosed * stretch / reach.h : stretch / reach.h;
  if (t.stiffness > 0) soften(l, t, {reach.h, stretch});
  rows.add(l);
}

/// A rigid tie, whose gap is closed at the end of the step, or a spring between two points.
void add_points(Rows& rows, std::uint32_t number, const Reach& reach) {
  const Group& g = rows.g;
  GroupTie& t = g.ties[number];
  place_tie(g, t);
  for (std::uint32_t k = 0; k < 3; ++k) {
    RestLink l = along_axis(g, {t.a, t.b, t.arm_a, t.arm_b}, kAxes[k]);
    l.of = Of::tie, l.number = number, l.side = k;
    if (t.kind == GroupTie::Kind::spring) soften(l, t, {reach.h, t.apart[static_cast<int>(k)]});
    rows.add(l);
  }
}

/// Rolling and spinning friction of two bodies, bounded by the normal impulses of the last step.
void add_rolling(Rows& rows, std::uint32_t number) {
  const GroupRolling& r = rows.g.rollings[number];
  contact::RollingBounds bounds;
  for (const GroupContact& c : rows.g.contacts.subspan(r.first, r.count))
    bounds.add(c.lengths, c.impulse.x);
  const GroupContact& c = rows.g.contacts[r.first];
  for (std::uint32_t k = 0; k < 3; ++k) {
    const Real most = k == 0 ? bounds.spinning : bounds.rolling;
    if (!(most > 0)) continue;
    RestLink l = about_axis(rows.g, {c.a, c.b, Vec3(0), Vec3(0)}, r.axes[k]);
    l.of = Of::rolling, l.number = number, l.side = k, l.most = most;
    rows.add(l);
  }
}

LinearisedForce force_of(const RestLink& l, Real speed) {
  return linearise(*l.dof, l.angle + l.h * speed, speed, Slope::tangent);
}
Real impulse_of(const RestLink& l, Real speed) {
  if (l.dof) return l.h * force_of(l, speed).force;
  const Real impulse = (l.goal - speed) / l.compliance;
  return std::clamp(impulse, l.is_one_sided() ? 0 : -l.most, l.most);
}
/// Minus the derivative of an acting row's impulse by the speed.
Real stiffness_of(const RestLink& l) {
  if (!l.dof) return 1 / l.compliance;
  const LinearisedForce f = force_of(l, l.speed);
  return l.h * (l.h * f.stiffness + f.damping);
}

}  // namespace

void begin_links(const Group& g, const GroupPart& part, Real fast) {
  Rows rows{g};
  const Reach reach{part, fast};
  for (const GroupNode& n : g.nodes)
    if (!n.free_root) add_joint(rows, n, reach);
  for (std::uint32_t i = 0; i < g.ties.size(); ++i)
    if (g.ties[i].kind == GroupTie::Kind::cable)
      add_cable(rows, i, reach);
    else
      add_points(rows, i, reach);
  for (std::uint32_t i = 0; i < g.rollings.size(); ++i) add_rolling(rows, i);
  while (rows.next < g.rest_links.size()) rows.add({});
}

void predict_links(const Group& g, Real margin) {
  for (RestLink& l : g.rest_links) {
    if (l.of == Of::nothing) break;
    const Real speed = speed_of(g, l, &RestBody::free);
    l.may_press = l.is_one_sided() && l.size * speed < l.size * l.goal + margin;
  }
}

void add_link_impulses(const Group& g, Acting acting) {
  for (RestLink& l : g.rest_links) {
    if (l.of == Of::nothing) break;
    const Real known = acting == Acting::as_before ? l.last : l.impulse;
    l.speed = speed_of(g, l, &RestBody::motion);
    l.impulse = impulse_of(l, l.speed);
    if (acting != Acting::now && l.is_one_sided())
      l.impulse = known > 0 ? (l.goal - l.speed) / l.compliance : 0;
    if (l.a < g.resting.size()) g.resting[l.a].residual += times(l.on_a, -l.impulse);
    if (l.b != l.a && l.b < g.resting.size()) g.resting[l.b].residual += times(l.on_b, -l.impulse);
  }
}

namespace {

/// block += k x y^T
void add_outer(Real* block, Real k, const Wrench& x, const Wrench& y) {
  for (int i = 0; i < 6; ++i) {
    const Real row = k * (i < 3 ? x.force[i] : x.torque[i - 3]);
    Real* const to = block + static_cast<std::size_t>(i) * kFactorWide;
    for (int j = 0; j < 3; ++j) to[j] += row * y.force[j], to[j + 3] += row * y.torque[j];
  }
}

}  // namespace

void add_link_blocks(const Group& g, const BlockFactor& e) {
  for (RestLink& l : g.rest_links) {
    if (l.of == Of::nothing) break;
    const bool acts = l.is_one_sided() ? l.impulse != 0 || l.presses : std::abs(l.impulse) < l.most;
    l.presses = false;
    if (!acts) continue;
    const Real k = stiffness_of(l);
    const bool moves_a = l.a < g.resting.size(), moves_b = l.b != l.a && l.b < g.resting.size();
    const std::size_t a = moves_a ? g.resting[l.a].row : 0, b = moves_b ? g.resting[l.b].row : 0;
    if (moves_a) add_outer(e.block(a, a), k, l.on_a, l.on_a);
    if (moves_b) add_outer(e.block(b, b), k, l.on_b, l.on_b);
    if (!moves_a || !moves_b) continue;
    if (a > b)
      add_outer(e.block(a, b), k, l.on_b, l.on_a);
    else
      add_outer(e.block(b, a), k, l.on_a, l.on_b);
  }
}

void aim_links(const Group& g) {
  for (RestLink& l : g.rest_links) {
    if (l.of == Of::nothing) break;
    l.change = speed_of(g, l, &RestBody::direction);
  }
}

Real slope_of_links(const Group& g, Real part) {
  Real sum = 0;
  for (const RestLink& l : g.rest_links) {
    if (l.of == Of::nothing) break;
    sum -= impulse_of(l, l.speed + part * l.change) * l.change;
  }
  return sum;
}

bool harden_links(const Group& g, Real most) {
  bool any = false;
  for (RestLink& l : g.rest_links) {
    if (l.of == Of::nothing) break;
    const bool is_tie = l.of == Of::cable || l.of == Of::tie;
    const bool is_elastic =
        l.of == Of::spring || l.of == Of::actuator || (is_tie && g.ties[l.number].stiffness > 0);
    const Real yields = l.size * l.compliance * std::abs(l.impulse);
    if (is_elastic || !(yields > most) || most == 0) continue;
    l.compliance *= 0.5 * most / yields, any = true;
  }
  return any;
}

void set_rest_impulses(const Group& g) {
  for (RestBody& r : g.resting) r.pressed = 0;
  for (GroupRolling& r : g.rollings) r.impulse = Vec3(0);
  for (const RestLink& l : g.rest_links)
    if (l.of == Of::rolling) g.rollings[l.number].impulse[static_cast<int>(l.side)] = l.impulse;
  for (std::size_t i = 0; i < g.contacts.size(); ++i) {
    GroupContact& c = g.contacts[i];
    c.works = g.rest_contacts[i].near;
    c.impulse = c.works ? g.rest_contacts[i].cone.impulse : Vec3(0);
    c.before = c.impulse.x;
    for (const std::uint32_t body : {c.a, c.b})
      if (body < g.resting.size()) g.resting[body].pressed += c.impulse.x;
  }
}

namespace {

/// Writes the impulses of joints and ties that were found.
void set_joint_impulses(const Group& g) {
  for (GroupNode& n : g.nodes) {
    n.actuator.impulse = 0;
    for (GroupLimit& limit : n.limits) limit.impulse = 0;
  }
  for (GroupTie& t : g.ties) t.impulse = Vec3(0);
  for (const RestLink& l : g.rest_links) {
    if (l.of == Of::nothing) break;
    if (l.of == Of::cable) g.ties[l.number].impulse.x = l.impulse;
    if (l.of == Of::tie && g.ties[l.number].kind == GroupTie::Kind::spring)
      g.ties[l.number].impulse[static_cast<int>(l.side)] = -l.impulse;
    if (l.of == Of::actuator) g.nodes[l.number].actuator.impulse = l.impulse;
    // `on_a` is minus the direction of a limit.
    if (l.of == Of::limit || l.of == Of::lock) g.nodes[l.number].limits[l.side].impulse = l.impulse;
    const bool turns = l.of == Of::limit || l.of == Of::lock || l.of == Of::actuator;
    if (turns && l.impulse != 0) apply_at_joint(g, l.number, l.impulse * l.on_a.torque);
  }
}

/// Applies the impulses that were found, through the joints and loops.
void push_trees(const Group& g, Real h) {
  set_joint_impulses(g);
  for (GroupTie& t : g.ties) {
    place_tie(g, t);
    if (t.kind != GroupTie::Kind::rigid) push_tie(g, t);
  }
  for (const GroupContact& c : g.contacts)
    if (c.impulse != Vec3(0)) push(g, c), g.a(c).touched = g.b(c).touched = true;
  for (GroupRolling& r : g.rollings) push(g, r);
  begin_loops(g, h, 0), end_loops(g);
  for (GroupTie& t : g.ties) t.passed += t.impulse;
}

}  // namespace

void keep_standing(const Group& g, const GroupTree& t) {
  Vec3 mean(0);
  Real sum = 0;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    GroupNode& n = g.nodes[i];
    const Real pressed = g.resting[n.body].pressed;
    n.missed_by = g.bodies[n.body].pose.position - n.goal;
    mean += pressed * n.missed_by, sum += pressed;
  }
  PANTIN_ASSERT(sum > 0);
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    GroupNode& n = g.nodes[i];
    n.missed_by -= mean / sum;
    g.bodies[n.body].pose.position -= mean / sum;
  }
}

void push_resting_trees(const Group& g, const GroupPart& part) {
  if (g.nodes.empty()) return;
  prepare_trees(g, part);
  prepare_loops(g);
  for (GroupContact& c : g.contacts)
    if (c.works) place(g, c);
  for (GroupPair& p : g.pairs) {  // responses, for take_up
    const GroupContact& c = g.contacts[p.first];
    if (c.cross != kNoNode) g.crosses[c.cross] = cross_response_of(g, c.a, c.b);
    prepare_pair(g, p);
  }
  set_rest_impulses(g);  // prepare_pair() may have cleared some
  remember_free(g);
  push_trees(g, part.h);
  settle_trees(g);
  bound_drives(g, part.h);
}

void push_trees_again(const Group& g, Real h) {
  PANTIN_ASSERT(g.ties.empty());  // push_trees() adds to what these passed
  restore_free_motions(g);
  set_rest_impulses(g);
  push_trees(g, h);
  settle_trees(g);
}

}  // namespace pantin::detail::articulated
