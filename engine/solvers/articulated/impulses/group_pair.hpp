#pragma once
/// Impulses between two bodies of a group, iterated on copies of their motions. The sum propagates
/// through the joints of trees once, at the end.
#include "engine/base/compiler.hpp"
#include "engine/solvers/articulated/impulses/contact_groups.hpp"

namespace pantin::detail::articulated {

/// A body of a pair during the iteration: its motion and the sum of the impulses on it.
struct Side {
  const GroupBody& body;
  const Response* response;  // of a body in a tree
  Vec3 velocity, spin;
  Wrench sum;

  Side(const Group& g, std::uint32_t i)
      : body(g.bodies[i]),
        response(body.node == kNoNode ? nullptr : &g.nodes[body.node].response),
        velocity(body.velocity),
        spin(body.spin) {
    PANTIN_ASSERT(body.looped == kNoNode || body.node != kNoNode);
    if (body.looped == kNoNode || !g.looped[body.looped].known) return;
    const LoopedBody& looped = g.looped[body.looped];
    response = &looped.response;
    const Wrench change = change_by_loops(g, looped);
    velocity += change.force, spin += change.torque;
  }
  Vec3 speed_at(Vec3 arm) const { return velocity + glm::cross(spin, arm); }
  /// Change of its velocity and spin by an impulse and its moment.
  Wrench response_to(const Wrench& impulse) const {
    if (body.per_mass == 0) return {};
    if (!response) return {body.per_mass * impulse.force, body.response * impulse.torque};
    return {response->vf * impulse.force + response->vt * impulse.torque,
            impulse.force * response->vt + response->wt * impulse.torque};
  }
  void add(const Wrench& impulse, const Wrench& change) {
    sum += impulse, velocity += change.force, spin += change.torque;
  }
};

/// Arms from the `centre` of each body to a point.
struct Arms {
  Vec3 a, b;
};

/// Impulses on two bodies, or changes of their motions.
struct BothWrenches {
  Wrench a, b;
  BothWrenches& operator+=(const BothWrenches& o) {
    a += o.a, b += o.b;
    return *this;
  }
};
/// An impulse on a at its arm, and the opposite on b; the same of a torque.
inline BothWrenches opposed(const Arms& c, Vec3 impulse) {
  return {{impulse, glm::cross(c.a, impulse)}, {-impulse, -glm::cross(c.b, impulse)}};
}
inline BothWrenches opposed(Vec3 torque) { return {{Vec3(0), torque}, {Vec3(0), -torque}}; }

/// Two bodies of a group during the iteration of impulses between them.
struct Pair {
  Side a, b;
  const CrossResponse* cross;  // of two bodies of one tree

  Vec3 speed_of(const Arms& c) const { return a.speed_at(c.a) - b.speed_at(c.b); }
  /// Changes of both motions by impulses on both bodies.
  PANTIN_INLINE BothWrenches response_to(const BothWrenches& on) const {
    BothWrenches moved{a.response_to(on.a), b.response_to(on.b)};
    if (!cross) return moved;
    moved.a.force += cross->vf * on.b.force + cross->vt * on.b.torque;
    moved.a.torque += cross->wf * on.b.force + cross->wt * on.b.torque;
    moved.b.force += on.a.force * cross->vf + on.a.torque * cross->wf;
    moved.b.torque += on.a.force * cross->vt + on.a.torque * cross->wt;
    return moved;
  }
  void push(const BothWrenches& impulses) {
    const BothWrenches change = response_to(impulses);
    a.add(impulses.a, change.a), b.add(impulses.b, change.b);
  }
};

/// Numbers of two bodies of a group, and of the cross response if both are of one tree.
struct PairOf {
  std::uint32_t a, b, cross = kNoNode;
};

inline Pair begin_pair(const Group& g, const PairOf& c) {
  if (c.cross == kNoNode) {
    for (const std::uint32_t i : {c.a, c.b})
      if (g.bodies[i].node != kNoNode) visit(g, g.bodies[i].node);
    return {{g, c.a}, {g, c.b}, nullptr};
  }
  PANTIN_ASSERT(g.bodies[c.a].node != kNoNode && g.bodies[c.b].node != kNoNode);
  visit(g, g.bodies[c.b].node);
  const Side b(g, c.b);
  visit(g, g.bodies[c.a].node);
  return {{g, c.a}, b, &g.crosses[c.cross]};
}

inline void end_side(const Group& g, std::uint32_t i, const Side& side) {
  GroupBody& body = g.bodies[i];
  if (body.node != kNoNode) {
    visit(g, body.node);
    if (body.looped != kNoNode && g.looped[body.looped].known)
      push_looped(g, g.looped[body.looped], side.sum);
    return apply(g, body.node, side.sum);
  }
  body.velocity = side.velocity, body.spin = side.spin;
  body.angular_momentum += side.sum.torque;
}

inline void end_pair(const Group& g, const PairOf& c, const Pair& pair) {
  end_side(g, c.a, pair.a), end_side(g, c.b, pair.b);
}

/// Change of the relative velocity at an arm by an impulse `d` there on a and its opposite on b.
inline Vec3 response_of(const Pair& pair, const Arms& c, Vec3 d) {
  const BothWrenches moved = pair.response_to(opposed(c, d));
  return moved.a.force + glm::cross(moved.a.torque, c.a) -
         (moved.b.force + glm::cross(moved.b.torque, c.b));
}

}  // namespace pantin::detail::articulated
