// Trees in contact: impulses propagate through the joints, which stay closed.
//
// Motions (velocity, spin) and wrenches (force, torque) of a body refer to its joint, where the
// parent has the same velocity. I = (ff, ft; ft^T, tt) is the articulated inertia of a body there,
// m = E (E^T tt E)^-1 E^T the mobility of its joint over the free directions E, and U = (ft, tt)
// the wrench per unit relative spin. Then
//   inwards   f_parent += f - U m torque,  I_parent += I - U m U^T
//   outwards  relative spin = m (torque - U^T v_parent)
// all shifted from the parent's joint to this one. A free ball joint passes no torque on: m tt = 1
// holds exactly.
// [Featherstone 2008, articulated bodies; Tomcin, Sibbing & Kobbelt 2014, impulses in trees]
//
// Between impulses, motions are current only on the path from the root to the node visited last.
// The next visit costs as much as the joints between the two nodes.
#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/impulses/group_threads.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// The inverse of a symmetric positive definite matrix, pivots floored.
Mat3 inverse_of(const Mat3& m) {
  const Real floor = 4 * 2.220446049250313e-16 * (m[0][0] + m[1][1] + m[2][2]);
  const Real i0 = 1 / std::max(m[0][0], floor), l10 = m[0][1] * i0, l20 = m[0][2] * i0;
  const Real i1 = 1 / std::max(m[1][1] - l10 * m[0][1], floor), s = m[1][2] - l20 * m[0][1];
  const Real l21 = s * i1;
  const Real i2 = 1 / std::max(m[2][2] - l20 * m[0][2] - l21 * s, floor);
  const Real u20 = l10 * l21 - l20;
  const Real xx = i0 + l10 * l10 * i1 + u20 * u20 * i2, xy = -l10 * i1 - l21 * u20 * i2;
  const Real xz = u20 * i2, yy = i1 + l21 * l21 * i2, yz = -l21 * i2;
  return Mat3(xx, xy, xz, xy, yy, yz, xz, yz, i2);
}

}  // namespace

Mat3 compliance_of(const Mat3& stiffness, const Vec3 (&free)[3], std::size_t count) {
  if (count == 3) return inverse_of(stiffness);
  if (count == 1)
    return glm::outerProduct(free[0], free[0]) / glm::dot(free[0], stiffness * free[0]);
  if (count == 0) return Mat3(0);
  const Vec3 k0 = stiffness * free[0], k1 = stiffness * free[1];
  const Real a = glm::dot(free[0], k0), b = glm::dot(free[1], k0), d = glm::dot(free[1], k1);
  const Real l = b / a, e = std::max(d - l * b, 1e-15 * d);
  const Vec3 v = free[1] - l * free[0];
  return glm::outerProduct(free[0], free[0]) / a + glm::outerProduct(v, v) / e;
}

namespace {

/// The parent's motion at the joint of a child; a wrench on the child at the parent's joint.
Wrench at_child(const GroupNode& n, const GroupBody& parent) {
  return {parent.velocity + glm::cross(parent.spin, n.lever), parent.spin};
}
Wrench at_parent(const GroupNode& n, const Wrench& f) {
  return {f.force, f.torque + glm::cross(n.lever, f.force)};
}

/// The part of a wrench that reaches the parent, at this joint; `relative` is the joint's response.
Wrench passed_on(const GroupNode& n, const Wrench& f, Vec3 relative) {
  const Vec3 force = f.force - n.whole.ft * relative;
  return {force, n.is_ball ? Vec3(0) : f.torque - n.whole.tt * relative};
}

SpatialInertia inertia_of(const GroupNode& n) {
  const Vec3 c = n.arm;
  return {Mat3(n.mass), -n.mass * cross_matrix(c),
          n.world_inertia + n.mass * (Mat3(glm::dot(c, c)) - glm::outerProduct(c, c))};
}

Mat3 mobility_of(const GroupNode& n, Quat parent) {
  const Turns turns = n.joint ? turns_of(n.joint->joint.kind) : Turns::freely;
  PANTIN_ASSERT(turns != Turns::own);
  if (turns == Turns::freely) return compliance_of(n.whole.tt + n.spring, kAxes, 3);
  const FreeAxes axes = free_axes(*n.joint, n.rotation, parent);
  const Vec3 free[3] = {axes.first, axes.second, Vec3(0)};
  const std::size_t count = turns == Turns::about_x ? 1 : turns == Turns::about_two ? 2 : 0;
  return compliance_of(n.whole.tt + n.spring, free, count);
}

/// Adds the articulated inertia that a body passes on to its parent, at the parent's joint.
void add_inertia(SpatialInertia& parent, const GroupNode& n) {
  const Mat3 turned = n.whole.ft * n.mobility;
  const Mat3 ff = n.whole.ff - turned * glm::transpose(n.whole.ft);
  const Mat3 r = cross_matrix(n.lever);
  const Mat3 shifted = ff * r;
  parent.ff += ff, parent.ft -= shifted, parent.tt -= r * shifted;
  if (n.is_ball) return;
  const Mat3 ft = n.whole.ft - turned * n.whole.tt;
  const Mat3 across = r * ft;
  parent.ft += ft;
  parent.tt += n.whole.tt - n.whole.tt * n.mobility * n.whole.tt + across + glm::transpose(across);
}

Response inverse_of(const SpatialInertia& i) {
  const Mat3 per_mass = compliance_of(i.ff, kAxes, 3);
  const Mat3 moved = per_mass * i.ft;
  Response r;
  r.wt = compliance_of(i.tt - glm::transpose(i.ft) * moved, kAxes, 3);
  r.vt = -moved * r.wt;
  r.vf = per_mass - r.vt * glm::transpose(moved);
  return r;
}

/// The motion of a body per motion of its parent, in blocks.
struct Following {
  Mat3 vv{1}, vw{0}, wv{0}, ww{1};
};

/// The body's spin per velocity of the joint, and per spin of the parent.
Mat3 spin_by_velocity(const GroupNode& n) { return -n.mobility * glm::transpose(n.whole.ft); }
Mat3 spin_by_spin(const GroupNode& n) {
  return n.is_ball ? Mat3(0) : Mat3(1) - n.mobility * n.whole.tt;
}

Following following_of(const GroupNode& n) {
  Following x;
  x.vw = -cross_matrix(n.lever);
  x.wv = spin_by_velocity(n), x.ww = spin_by_spin(n) + x.wv * x.vw;
  return x;
}

Following operator*(const Following& x, const Following& y) {
  return {x.vv * y.vv + x.vw * y.wv, x.vv * y.vw + x.vw * y.ww, x.wv * y.vv + x.ww * y.wv,
          x.wv * y.vw + x.ww * y.ww};
}

/// The symmetric part: antisymmetric rounding errors would grow from joint to joint.
Mat3 symmetric(const Mat3& m) { return 0.5 * (m + glm::transpose(m)); }

/// The response of a body: the response with the parent fixed, plus what the parent's own response
/// passes on.
void find_response(const Group& g, GroupNode& n) {
  n.response = {Mat3(0), Mat3(0), n.mobility};
  if (n.parent == kNoNode) return;
  const Response& p = g.nodes[n.parent].response;
  const Mat3 r = cross_matrix(n.lever);
  const Mat3 wr = p.wt * r;
  const Mat3 vt = p.vt + glm::transpose(wr);  // -r wt = (wt r)^T
  Response& own = n.response;
  own.vf = symmetric(p.vf + p.vt * r - r * (glm::transpose(p.vt) + wr));
  const Mat3 by_velocity = spin_by_velocity(n);
  own.vt = own.vf * glm::transpose(by_velocity);
  if (n.is_ball) {
    own.wt += by_velocity * own.vt;
    return;
  }
  const Mat3 by_spin = spin_by_spin(n);
  const Mat3 turned = by_spin * glm::transpose(vt);
  own.vt += glm::transpose(turned);
  own.wt += by_velocity * own.vt +
            (turned * glm::transpose(by_velocity) + by_spin * p.wt * glm::transpose(by_spin));
}

/// Positions and inertias of a tree's bodies, and their momenta at the start of the substep.
void place_nodes(const Group& g, GroupTree& t, Real h) {
  t.before = Vec3(0), t.mass = 0, t.touched = t.stands = false;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    GroupNode& n = g.nodes[i];
    GroupBody& b = g.bodies[n.body];
    b.touched = false;
    n.velocity = b.velocity;
    n.rotation = b.pose.rotation;
    n.arm = n.free_root ? Vec3(0) : -(n.rotation * n.own_anchor);
    b.centre = b.pose.position - n.arm;
    if (n.parent != kNoNode) n.lever = b.centre - g.bodies[g.nodes[n.parent].body].centre;
    n.world_inertia = world_inertia(n.rotation, n.inertia);
    n.whole = inertia_of(n);
    n.whole.ff += n.pressed.ff, n.whole.ft += n.pressed.ft;
    n.whole.tt += n.pressed.tt + n.tautness;
    t.mass += n.mass, t.before += n.mass * b.velocity;
    const Real half = std::exp(-0.5 * h * b.drag);  // see slow_down
    const Vec3 impulse = n.mass * (half * b.velocity + h * b.acceleration);
    const Vec3 moment = half * b.angular_momentum + h * b.torque;
    n.begin = {impulse, moment + glm::cross(n.arm, impulse)};
    n.pending = n.begin, n.load = {}, n.torque = Vec3(0);
  }
  t.before /= t.mass;
}

/// The parent's motion at a node's joint; at a root the anchor's.
Wrench parent_motion(const Group& g, const GroupTree& t, const GroupNode& n) {
  if (n.parent == kNoNode) return {t.anchor_velocity, t.held_spin};
  return at_child(n, g.bodies[g.nodes[n.parent].body]);
}

/// The spin of a node, given the torque at its joint and the parent's motion there.
Vec3 spin_of(const GroupNode& n, Vec3 torque, const Wrench& parent) {
  const Vec3 by_joint = n.mobility * (torque - parent.force * n.whole.ft);
  if (n.is_ball) return by_joint;
  return by_joint + parent.torque - n.mobility * (n.whole.tt * parent.torque);
}

/// Outward step from the parent to the node.
void go_out(const Group& g, const GroupTree& t, const GroupNode& n) {
  if (n.free_root) return;
  GroupBody& b = g.bodies[n.body];
  const Wrench parent = parent_motion(g, t, n);
  b.velocity = parent.force, b.spin = spin_of(n, n.torque, parent);
}

void respond(GroupBody& b, const Response& r, const Wrench& f) {
  b.velocity += r.vf * f.force + r.vt * f.torque;
  b.spin += f.force * r.vt + r.wt * f.torque;
}

/// Adds a wrench at a joint to the parent.
void give_parent(const Group& g, const GroupNode& n, const Wrench& passed) {
  PANTIN_ASSERT(n.parent != kNoNode);
  GroupNode& p = g.nodes[n.parent];
  const Wrench there = at_parent(n, passed);
  p.pending += there;
  respond(g.bodies[p.body], p.response, there);
}

/// Inward step from a node to its parent: passes on the node's pending impulses.
void go_in(const Group& g, GroupNode& n) {
  n.torque += n.pending.torque;
  const Wrench passed = passed_on(n, n.pending, n.mobility * n.pending.torque);
  n.pending = {};
  give_parent(g, n, passed);
}

void prepare_tree(const Group& g, GroupTree& t, const GroupPart& part) {
  place_nodes(g, t, part.h);
  t.held_rotation = held_rotation_at(t, part.begin);
  for (std::uint32_t i = t.first + t.count; i-- > t.first;) {
    GroupNode& n = g.nodes[i];
    if (n.free_root) {
      n.response = inverse_of(n.whole);
      continue;
    }
    const Quat parent = parent_rotation(g, n);
    if (n.has_spring) prepare_springs(g, n, part);
    n.is_ball = !n.has_spring && (!n.joint || turns_of(n.joint->joint.kind) == Turns::freely);
    n.mobility = mobility_of(n, parent);
    n.torque = n.pending.torque + n.spring_torque;
    if (n.parent == kNoNode) continue;
    PANTIN_ASSERT(n.parent < i);
    GroupNode& to = g.nodes[n.parent];
    to.pending += at_parent(n, passed_on(n, n.pending, n.mobility * n.torque));
    add_inertia(to.whole, n);
  }
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    GroupNode& n = g.nodes[i];
    GroupBody& b = g.bodies[n.body];
    if (n.free_root)
      b.velocity = b.spin = Vec3(0), respond(b, n.response, n.pending);
    else
      find_response(g, n), go_out(g, t, n);
    n.pending = {};
    if (n.is_limited && part.h > 0) prepare_limits(g, i);
    if (n.actuator.dof && part.h > 0) prepare_actuator(g, i);
  }
  t.at = t.first;
}

}  // namespace

Quat held_rotation_at(const GroupTree& t, Real fraction) {
  PANTIN_ASSERT(is_range(0, fraction));
  if (fraction >= 1) return t.held_after.rotation;
  const Quat before = t.held_before.rotation;
  return glm::normalize(fraction_of(t.held_after.rotation * glm::conjugate(before), fraction) *
                        before);
}

Quat parent_rotation(const Group& g, const GroupNode& n) {
  return n.parent == kNoNode ? g.trees[n.tree].held_rotation : g.nodes[n.parent].rotation;
}

void prepare_trees(const Group& g, const GroupPart& part) {
  for_each_tree(g, [&](GroupTree& t) { prepare_tree(g, t, part); });
}

void visit(const Group& g, std::uint32_t node) {
  PANTIN_ASSERT(node < g.nodes.size());
  GroupTree& t = g.trees[g.nodes[node].tree];
  if (t.at == node) return;
  std::uint32_t from = t.at, to = node;
  const auto climb = [&] {
    const std::uint32_t parent = g.nodes[to].parent;
    PANTIN_ASSERT(parent != kNoNode);
    g.nodes[parent].next = to;
    to = parent;
  };
  while (g.nodes[to].depth > g.nodes[from].depth) climb();
  while (g.nodes[from].depth > g.nodes[to].depth)
    go_in(g, g.nodes[from]), from = g.nodes[from].parent;
  while (from != to) climb(), go_in(g, g.nodes[from]), from = g.nodes[from].parent;
  while (from != node) {
    from = g.nodes[from].next;
    go_out(g, t, g.nodes[from]);
  }
  t.at = node;
}

void apply(const Group& g, std::uint32_t node, const Wrench& impulse) {
  GroupNode& n = g.nodes[node];
  PANTIN_ASSERT(g.trees[n.tree].at == node);
  n.pending += impulse, n.load += impulse;
  respond(g.bodies[n.body], n.response, impulse);
}

namespace {

/// Applies the pending impulses of an anchored root.
void gather_root(GroupNode& n) {
  n.torque += n.pending.torque;
  n.pending = {};
}

/// Updates the motion of a joint's parent with all impulses so far, and returns it at the joint.
Wrench visit_parent(const Group& g, std::uint32_t node) {
  GroupNode& n = g.nodes[node];
  visit(g, n.parent == kNoNode ? node : n.parent);
  if (n.parent == kNoNode) gather_root(n);
  return parent_motion(g, g.trees[n.tree], n);
}

/// The wrench that reaches the parent from an impulse of torque at the joint.
Wrench passed_of_torque(const GroupNode& n, Vec3 torque) {
  const Vec3 relative = n.mobility * torque;
  return {-(n.whole.ft * relative), n.is_ball ? -torque : -(n.whole.tt * relative)};
}

}  // namespace

Vec3 relative_spin(const Group& g, std::uint32_t node) {
  PANTIN_ASSERT(!g.nodes[node].free_root);
  const Wrench parent = visit_parent(g, node);
  return spin_of(g.nodes[node], g.nodes[node].torque, parent) - parent.torque;
}

void apply_at_joint(const Group& g, std::uint32_t node, Vec3 torque) {
  GroupNode& n = g.nodes[node];
  visit_parent(g, node);
  PANTIN_ASSERT(!n.free_root);
  n.torque += torque;
  if (n.parent == kNoNode)
    go_out(g, g.trees[n.tree], n);
  else
    give_parent(g, n, passed_of_torque(n, torque));
}

Vec3 joint_response(const Group& g, const GroupNode& n, Vec3 along) {
  const Vec3 turned = n.mobility * along;
  if (n.parent == kNoNode) return turned;
  const Wrench there = at_parent(n, passed_of_torque(n, along));
  const Response& r = g.nodes[n.parent].response;
  const Vec3 spin = there.force * r.vt + r.wt * there.torque;
  const Vec3 velocity = r.vf * there.force + r.vt * there.torque + glm::cross(spin, n.lever);
  const Vec3 follows = n.mobility * (velocity * n.whole.ft);
  // The body's spin, which follows the joint, minus the parent's.
  return turned - follows - (n.is_ball ? spin : n.mobility * (n.whole.tt * spin));
}

CrossResponse cross_response(const Group& g, std::uint32_t node, std::uint32_t on) {
  PANTIN_ASSERT(g.nodes[node].tree == g.nodes[on].tree);
  Following to, from;
  const auto climb = [&](std::uint32_t& i, Following& x) {
    x = x * following_of(g.nodes[i]);
    i = g.nodes[i].parent;
  };
  while (g.nodes[node].depth > g.nodes[on].depth) climb(node, to);
  while (g.nodes[on].depth > g.nodes[node].depth) climb(on, from);
  while (node != on) climb(node, to), climb(on, from);
  const Response& r = g.nodes[node].response;
  const Mat3 tv = glm::transpose(r.vt);
  const Mat3 vf = to.vv * r.vf + to.vw * tv, vt = to.vv * r.vt + to.vw * r.wt;
  const Mat3 wf = to.wv * r.vf + to.ww * tv, wt = to.wv * r.vt + to.ww * r.wt;
  const Mat3 fv = glm::transpose(from.vv), fw = glm::transpose(from.vw);
  const Mat3 gv = glm::transpose(from.wv), gw = glm::transpose(from.ww);
  return {vf * fv + vt * fw, vf * gv + vt * gw, wf * fv + wt * fw, wf * gv + wt * gw};
}

void gather_impulse(const Group& g, std::uint32_t node) {
  const GroupNode& n = g.nodes[node];
  if (n.parent == kNoNode) return;
  const Vec3 relative = n.mobility * n.passing.torque;
  g.nodes[n.parent].passing += at_parent(n, passed_on(n, n.passing, relative));
}

void follow_impulse(const Group& g, std::uint32_t node) {
  GroupNode& n = g.nodes[node];
  const Wrench f = n.passing;
  if (n.free_root) {
    const Response& r = n.response;
    n.passing = {r.vf * f.force + r.vt * f.torque, f.force * r.vt + r.wt * f.torque};
    return;
  }
  Wrench parent;
  if (n.parent != kNoNode) {
    const Wrench& p = g.nodes[n.parent].passing;
    parent = {p.force + glm::cross(p.torque, n.lever), p.torque};
  }
  n.passing = {parent.force, spin_of(n, f.torque, parent)};
}

void settle_tree(const Group& g, GroupTree& t) {
  visit(g, t.first);
  for (std::uint32_t i = t.first + 1; i < t.first + t.count; ++i) go_out(g, t, g.nodes[i]);
}

void settle_trees(const Group& g) {
  for (GroupTree& t : g.trees) settle_tree(g, t);
}

}  // namespace pantin::detail::articulated
