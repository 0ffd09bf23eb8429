#pragma once
/// Impulses between two bodies of a group, iterated on copies of their motions. The sum propagates
/// through the joints of trees once, at the end.
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
  void push(Vec3 arm, Vec3 impulse) {
    const Vec3 moment = glm::cross(arm, impulse);
    sum.force += impulse, sum.torque += moment;
    if (!response) {
      velocity += body.per_mass * impulse, spin += body.response * moment;
      return;
    }
    velocity += response->vf * impulse + response->vt * moment;
    spin += impulse * response->vt + response->wt * moment;
  }
  void twist(Vec3 moment) {
    sum.torque += moment;
    if (!response) {
      spin += body.response * moment;
      return;
    }
    velocity += response->vt * moment, spin += response->wt * moment;
  }
};

/// Arms from the `centre` of each body to a point.
struct Arms {
  Vec3 a, b;
};

/// Two bodies of a group during the iteration of impulses between them.
struct Pair {
  Side a, b;
  const CrossResponse* cross;  // of two bodies of one tree

  Vec3 speed_of(const Arms& c) const { return a.speed_at(c.a) - b.speed_at(c.b); }
  /// An impulse on a, the opposite on b.
  void push(const Arms& c, Vec3 impulse) {
    a.push(c.a, impulse), b.push(c.b, -impulse);
    if (!cross) return;
    const Vec3 on_a = glm::cross(c.a, impulse), on_b = -glm::cross(c.b, impulse);
    a.velocity += cross->vt * on_b - cross->vf * impulse;
    a.spin += cross->wt * on_b - cross->wf * impulse;
    b.velocity += impulse * cross->vf + on_a * cross->wf;
    b.spin += impulse * cross->vt + on_a * cross->wt;
  }
  /// An impulse of torque on a, the opposite on b.
  void twist(Vec3 moment) {
    a.twist(moment), b.twist(-moment);
    if (!cross) return;
    a.velocity -= cross->vt * moment, a.spin -= cross->wt * moment;
    b.velocity += moment * cross->wf, b.spin += moment * cross->wt;
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
    if (body.looped != kNoNode) push_looped(g, g.looped[body.looped], side.sum);
    return apply(g, body.node, side.sum);
  }
  body.velocity = side.velocity, body.spin = side.spin;
  body.angular_momentum += side.sum.torque;
}

inline void end_pair(const Group& g, const PairOf& c, const Pair& pair) {
  end_side(g, c.a, pair.a), end_side(g, c.b, pair.b);
}

/// Change of the velocity at the arm `seen` by an impulse `d` at `arm`.
inline Vec3 response_at(const Side& s, Vec3 arm, Vec3 d, Vec3 seen) {
  const Vec3 moment = glm::cross(arm, d);
  if (!s.response) return s.body.per_mass * d + glm::cross(s.body.response * moment, seen);
  const Response& r = *s.response;
  return r.vf * d + r.vt * moment + glm::cross(d * r.vt + r.wt * moment, seen);
}

/// Change of the relative velocity at `seen` by an impulse `d` on a and its opposite on b.
inline Vec3 response_of(const Pair& pair, const Arms& c, Vec3 d, const Arms& seen) {
  Vec3 moved = response_at(pair.a, c.a, d, seen.a) + response_at(pair.b, c.b, d, seen.b);
  if (!pair.cross) return moved;
  const CrossResponse& x = *pair.cross;
  const Vec3 on_a = glm::cross(c.a, d), on_b = glm::cross(c.b, d);
  moved -= x.vf * d + x.vt * on_b + glm::cross(x.wf * d + x.wt * on_b, seen.a);
  moved -= d * x.vf + on_a * x.wf + glm::cross(d * x.vt + on_a * x.wt, seen.b);
  return moved;
}

/// The same at the arms of the impulse.
inline Vec3 response_of(const Pair& pair, const Arms& c, Vec3 d) {
  return response_of(pair, c, d, c);
}

}  // namespace pantin::detail::articulated
