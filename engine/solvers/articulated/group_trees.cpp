// Trees in contact: impulses are carried through the joints, which stay closed.
//
// Motions (velocity, spin) and wrenches (force, torque) are those of the tree's centre, so that
// those of a body and its parent need no shift. With the joint at p, a relative spin r moves the
// body by S r, S r = (p x r, r), and an impulse f has the torque S^T f about the joint. With the
// articulated inertia I of a body, U = I S and the joint's mobility m = E (E^T S^T U E)^-1 E^T over
// the free directions E:
//   inwards   f_parent += f - U m S^T f,  I_parent += I - U m U^T
//   outwards  r = m (S^T f - U^T v_parent),  v = v_parent + S r
// [Featherstone 2008, articulated bodies; Tomcin, Sibbing, Kobbelt 2014, impulses in trees]
//
// Between impulses only the way from the root to the node visited last is current: going on to the
// next costs the joints between the two.
#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

Mat3 crossing(Vec3 v) { return Mat3(0, v.z, -v.y, -v.z, 0, v.x, v.y, -v.x, 0); }

/// S^T f.
Vec3 torque_about(Vec3 point, const Wrench& f) { return f.torque - glm::cross(point, f.force); }

/// U^T v.
Vec3 held_back(const GroupNode& n, Vec3 velocity, Vec3 spin) {
  return velocity * n.by_force + spin * n.by_torque;
}

/// U w.
Wrench wrench_of(const GroupNode& n, Vec3 spin) { return {n.by_force * spin, n.by_torque * spin}; }

SpatialInertia inertia_of(const GroupNode& n) {
  const Vec3 c = n.arm;
  return {Mat3(n.mass), -n.mass * crossing(c),
          n.world_inertia + n.mass * (Mat3(glm::dot(c, c)) - glm::outerProduct(c, c))};
}

Mat3 mobility_of(const GroupNode& n, Quat parent) {
  // S^T U.
  const Mat3 stiffness = n.by_torque - crossing(n.point) * n.by_force + n.spring;
  const Turns turns = n.joint ? turns_of(n.joint->joint.kind) : Turns::freely;
  Vec3 free[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (turns == Turns::freely) return compliance_of(stiffness, free, 3);
  const FreeAxes axes = free_axes(*n.joint, n.rotation, parent);
  free[0] = axes.first;
  // Two axes of a universal joint are at right angles.
  free[1] = axes.second;
  return compliance_of(stiffness, free,
                       turns == Turns::about_x     ? 1
                       : turns == Turns::about_two ? 2
                                                   : 0);
}

/// What the parent of a body is given of its inertia.
void add_inertia(SpatialInertia& parent, const GroupNode& n) {
  const Mat3 force = n.by_force * n.mobility, torque = n.by_torque * n.mobility;
  const Mat3 f = glm::transpose(n.by_force), t = glm::transpose(n.by_torque);
  parent.ff += n.whole.ff - force * f;
  parent.ft += n.whole.ft - force * t;
  parent.tt += n.whole.tt - torque * t;
}

Response inverse_of(const SpatialInertia& i) {
  Vec3 free[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Mat3 per_mass = compliance_of(i.ff, free, 3);
  const Mat3 moved = per_mass * i.ft;
  Response r;
  r.wt = compliance_of(i.tt - glm::transpose(i.ft) * moved, free, 3);
  r.vt = -moved * r.wt;
  r.vf = per_mass - r.vt * glm::transpose(moved);
  return r;
}

/// How the motion of a body follows that of its parent: 1 - S m U^T, by blocks.
struct Following {
  Mat3 vv{1}, vw{0}, wv{0}, ww{1};
};

Following following_of(const GroupNode& n) {
  Following x;
  const Mat3 p = crossing(n.point);
  x.wv = -n.mobility * glm::transpose(n.by_force);
  const Mat3 turned = -n.mobility * glm::transpose(n.by_torque);
  x.vv = Mat3(1) + p * x.wv, x.vw = p * turned, x.ww = Mat3(1) + turned;
  return x;
}

Following operator*(const Following& x, const Following& y) {
  return {x.vv * y.vv + x.vw * y.wv, x.vv * y.vw + x.vw * y.ww, x.wv * y.vv + x.ww * y.wv,
          x.wv * y.vw + x.ww * y.ww};
}

/// The response of a body: that of its joint with the parent held, and what the parent gives way.
void find_response(const Group& g, GroupNode& n) {
  const Mat3 p = crossing(n.point);
  const Mat3 moved = p * n.mobility;
  n.response = {-moved * p, moved, n.mobility};  // S m S^T with p^T = -p
  if (n.parent == kNoNode) return;
  const Following x = following_of(n);
  const Response& r = g.nodes[n.parent].response;
  const Mat3 tv = glm::transpose(r.vt);
  const Mat3 vf = x.vv * r.vf + x.vw * tv, vt = x.vv * r.vt + x.vw * r.wt;
  const Mat3 wf = x.wv * r.vf + x.ww * tv, wt = x.wv * r.vt + x.ww * r.wt;
  n.response.vf += vf * glm::transpose(x.vv) + vt * glm::transpose(x.vw);
  n.response.vt += vf * glm::transpose(x.wv) + vt * glm::transpose(x.ww);
  n.response.wt += wf * glm::transpose(x.wv) + wt * glm::transpose(x.ww);
}

/// Where the bodies of a tree are, what they weigh, and what they begin the part with.
void place_nodes(const Group& g, GroupTree& t, Real h) {
  t.centre = g.bodies[t.first_body].pose.position;
  t.before = Vec3(0), t.mass = 0, t.touched = false;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    GroupNode& n = g.nodes[i];
    GroupBody& b = g.bodies[n.body];
    b.centre = t.centre, b.touched = false;
    n.rotation = b.pose.rotation;
    n.arm = b.pose.position - t.centre, n.point = n.arm + n.rotation * n.own_anchor;
    n.world_inertia = world_inertia(n.rotation, n.inertia);
    n.whole = inertia_of(n);
    t.mass += n.mass, t.before += n.mass * b.velocity;
    const Real half = std::exp(-0.5 * h * b.drag);  // of drag before and after
    const Vec3 impulse = half * n.mass * (half * b.velocity + h * b.acceleration);
    const Vec3 moment = half * (half * b.angular_momentum + h * b.torque);
    n.begin = {impulse, moment + glm::cross(n.arm, impulse)};
    n.pending = n.begin, n.load = {}, n.torque = Vec3(0);
  }
  t.before /= t.mass;
}

Quat parent_rotation(const Group& g, const GroupTree& t, const GroupNode& n) {
  return n.parent == kNoNode ? t.held_rotation : g.nodes[n.parent].rotation;
}

/// The motion of what holds a root.
Wrench held_motion(const GroupTree& t, const GroupNode& root) {
  return {t.anchor_velocity - glm::cross(t.held_spin, root.point), t.held_spin};
}

/// The relative spin with the parent moving so.
Vec3 spin_with(const GroupNode& n, Vec3 velocity, Vec3 spin) {
  return n.mobility * (n.torque - held_back(n, velocity, spin));
}

/// From the parent to the node.
void go_out(const Group& g, const GroupTree& t, GroupNode& n) {
  GroupBody& b = g.bodies[n.body];
  if (n.free_root) return;
  Vec3 velocity, spin;
  if (n.parent == kNoNode) {
    const Wrench held = held_motion(t, n);
    velocity = held.force, spin = held.torque;
  } else {
    const GroupBody& p = g.bodies[g.nodes[n.parent].body];
    velocity = p.velocity, spin = p.spin;
  }
  const Vec3 relative = spin_with(n, velocity, spin);
  b.velocity = velocity + glm::cross(n.point, relative), b.spin = spin + relative;
}

void respond(GroupBody& b, const Response& r, const Wrench& f) {
  b.velocity += r.vf * f.force + r.vt * f.torque;
  b.spin += f.force * r.vt + r.wt * f.torque;
}

/// From a node to its parent, which is given what the node received.
void go_in(const Group& g, GroupNode& n) {
  const Vec3 torque = torque_about(n.point, n.pending);
  n.torque += torque;
  const Wrench kept = wrench_of(n, n.mobility * torque);
  GroupNode& p = g.nodes[n.parent];
  const Wrench passed{n.pending.force - kept.force, n.pending.torque - kept.torque};
  n.pending = {};
  p.pending += passed;
  respond(g.bodies[p.body], p.response, passed);
}

void prepare_tree(const Group& g, GroupTree& t, const GroupPart& part) {
  place_nodes(g, t, part.h);
  const Real done = part.begin;
  t.held_rotation =
      done >= 1 ? t.held_after.rotation
                : glm::normalize(fraction_of(t.held_after.rotation *
                                                 glm::conjugate(t.held_before.rotation),
                                             done) *
                                 t.held_before.rotation);
  for (std::uint32_t i = t.first + t.count; i-- > t.first;) {
    GroupNode& n = g.nodes[i];
    if (n.free_root) {
      n.response = inverse_of(n.whole);
      continue;
    }
    const Quat parent = parent_rotation(g, t, n);
    // U = I S.
    const Mat3 p = crossing(n.point);
    n.by_force = n.whole.ff * p + n.whole.ft;
    n.by_torque = glm::transpose(n.whole.ft) * p + n.whole.tt;
    n.spring = Mat3(0), n.spring_torque = Vec3(0);
    if (n.has_spring) prepare_springs(g, n, part);
    n.mobility = mobility_of(n, parent);
    n.torque = torque_about(n.point, n.pending) + n.spring_torque;
    if (n.parent != kNoNode) {
      GroupNode& to = g.nodes[n.parent];
      const Wrench kept = wrench_of(n, n.mobility * n.torque);
      to.pending += {n.pending.force - kept.force, n.pending.torque - kept.torque};
      add_inertia(to.whole, n);
    }
  }
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    GroupNode& n = g.nodes[i];
    GroupBody& b = g.bodies[n.body];
    if (n.free_root)
      b.velocity = b.spin = Vec3(0), respond(b, n.response, n.pending);
    else
      find_response(g, n), go_out(g, t, n);
    n.pending = {};
    if (n.is_limited) prepare_limits(g, i);
  }
  t.at = t.first;
}

}  // namespace

void prepare_trees(const Group& g, const GroupPart& part) {
  for (GroupTree& t : g.trees) prepare_tree(g, t, part);
}

void visit(const Group& g, std::uint32_t node) {
  GroupTree& t = g.trees[g.nodes[node].tree];
  if (t.at == node) return;
  std::uint32_t from = t.at, to = node;
  const auto climb = [&] {
    const std::uint32_t parent = g.nodes[to].parent;
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
  n.pending += impulse, n.load += impulse;
  respond(g.bodies[n.body], n.response, impulse);
}

namespace {

/// The motion of a node's parent, or of what holds a root.
Wrench parent_motion(const Group& g, const GroupNode& n) {
  if (n.parent == kNoNode) return held_motion(g.trees[n.tree], n);
  const GroupBody& p = g.bodies[g.nodes[n.parent].body];
  return {p.velocity, p.spin};
}

/// A held root takes what it has received.
void gather_root(GroupNode& n) {
  n.torque += torque_about(n.point, n.pending);
  n.pending = {};
}

}  // namespace

Vec3 relative_spin(const Group& g, std::uint32_t node) {
  GroupNode& n = g.nodes[node];
  if (n.parent == kNoNode) {
    visit(g, node);
    gather_root(n);
  } else {
    visit(g, n.parent);
  }
  const Wrench parent = parent_motion(g, n);
  return spin_with(n, parent.force, parent.torque);
}

void apply_at_joint(const Group& g, std::uint32_t node, Vec3 torque) {
  GroupNode& n = g.nodes[node];
  if (n.parent == kNoNode) {
    visit(g, node);
    gather_root(n);
    n.torque += torque;
    return go_out(g, g.trees[n.tree], n);
  }
  visit(g, n.parent);
  n.torque += torque;
  const Wrench kept = wrench_of(n, n.mobility * torque);
  const Wrench passed{-kept.force, -kept.torque};
  GroupNode& p = g.nodes[n.parent];
  p.pending += passed;
  respond(g.bodies[p.body], p.response, passed);
}

Vec3 joint_response(const Group& g, const GroupNode& n, Vec3 along) {
  const Vec3 turned = n.mobility * along;
  if (n.parent == kNoNode) return turned;
  const Wrench kept = wrench_of(n, turned);
  const Response& r = g.nodes[n.parent].response;
  const Vec3 velocity = r.vf * kept.force + r.vt * kept.torque,
             spin = kept.force * r.vt + r.wt * kept.torque;
  return turned + n.mobility * held_back(n, velocity, spin);
}

CrossResponse cross_response(const Group& g, std::uint32_t node, std::uint32_t on) {
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

void settle_trees(const Group& g) {
  for (GroupTree& t : g.trees) {
    visit(g, t.first);
    for (std::uint32_t i = t.first + 1; i < t.first + t.count; ++i) go_out(g, t, g.nodes[i]);
  }
}

}  // namespace pantin::detail::articulated
