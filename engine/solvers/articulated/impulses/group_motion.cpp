// Motion of trees in contact, once they are placed (group_placing.cpp): velocities at the end,
// energy, joint forces; closing of loops and cables.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/impulses/group_placing.hpp"
#include "engine/solvers/articulated/impulses/group_resting.hpp"
#include "engine/solvers/articulated/impulses/group_threads.hpp"
#include "engine/solvers/articulated/impulses/group_ties.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// The loop equations are rebuilt while a gap exceeds this multiple of GroupLoops::open.
constexpr Real kNearlyClosed = 1.5;
/// Smallest fraction of a loop-closing step; it is halved while it would widen the gap.
constexpr Real kSmallestShare = 0.05;
/// Relative change of velocity by joints from which the prevented motion is lost in full.
constexpr Real kFastWay = 0.05;
/// Fraction of a cable's length: one that is longer by more is shortened by moving bodies.
constexpr Real kTooLong = 1e-5;

/// Angular momentum in the body frame after torque-free rotation for a time h. The midpoint rule
/// for Euler's equations keeps its magnitude and the energy, however thin the body is.
Vec3 turned_momentum(Vec3 momentum, Vec3 inertia, Real h) {
  const Vec3 per = Real(1) / inertia;
  Vec3 next = momentum + h * glm::cross(momentum, per * momentum);
  const Real enough = 1e-26 * glm::dot(momentum, momentum);
  for (int n = 0; n < 4; ++n) {
    const Vec3 mean = 0.5 * (momentum + next), spin = per * mean;
    const Vec3 left = next - momentum - h * glm::cross(mean, spin);
    if (!(glm::dot(left, left) > enough)) break;
    Mat3 part = cross_matrix(mean);
    for (int k = 0; k < 3; ++k) part[k] *= per[k];
    const Mat3 slope = Mat3(1) - 0.5 * h * (part - cross_matrix(spin));
    next -= glm::inverse(slope) * left;
  }
  return next;
}

/// Stores the joints' corrections of positions; keeps the mass centre of a free tree on its path.
void keep_mass_centre(const Group& g, const GroupTree& t, const GroupPart& part) {
  if (t.stands && is_free(g, t)) return keep_standing(g, t);
  Vec3 mean(0), drift(0);
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    GroupNode& n = g.nodes[i];
    n.missed_by = g.bodies[n.body].pose.position - n.goal;
    mean += n.mass / t.mass * n.missed_by;
    drift += n.mass * own_velocity(g.bodies[n.body], n);
  }
  if (!is_free(g, t) || t.is_tied_outside) return;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) g.nodes[i].missed_by -= mean;
  // The mass centre moves by its velocity; in free flight by the mean velocity of the substep,
  // which is exact for a parabola.
  drift /= t.mass;
  if (!t.touched) drift = 0.5 * (t.before + drift);
  Vec3 shift = part.h * drift;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    const GroupNode& n = g.nodes[i];
    const GroupBody& b = g.bodies[n.body];
    shift += n.mass / t.mass * (b.centre + n.arm - b.pose.position);
  }
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i)
    g.bodies[g.nodes[i].body].pose.position += shift;
}

/// The motion of a tree about its mass centre.
struct AngularMomentum {
  Vec3 middle{0}, drift{0}, sum{0};
  Mat3 inertia{0};
};

/// Restores the angular momentum that a free tree had before it moved, by a rigid rotation of its
/// velocities.
void keep_angular_momentum(const Group& g, const GroupTree& t, Vec3 before) {
  AngularMomentum now;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    const GroupNode& n = g.nodes[i];
    const GroupBody& b = g.bodies[n.body];
    now.middle += n.mass * b.pose.position, now.drift += n.mass * b.velocity;
  }
  now.middle /= t.mass, now.drift /= t.mass;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    const GroupNode& n = g.nodes[i];
    const GroupBody& b = g.bodies[n.body];
    const Vec3 r = b.pose.position - now.middle;
    now.sum += b.angular_momentum + n.mass * glm::cross(r, b.velocity - now.drift);
    now.inertia += world_inertia(b.pose.rotation, n.inertia) +
                   n.mass * (Mat3(glm::dot(r, r)) - glm::outerProduct(r, r));
  }
  const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Vec3 spin = compliance_of(now.inertia, axes, 3) * (before - now.sum);
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    const GroupNode& n = g.nodes[i];
    GroupBody& b = g.bodies[n.body];
    b.velocity += glm::cross(spin, b.pose.position - now.middle);
    b.angular_momentum += world_inertia(b.pose.rotation, n.inertia) * spin;
  }
}

/// Joint impulses of the substep, from the momentum that the bodies outboard of each joint gained.
void add_reactions(const Group& g, const GroupTree& t) {
  for (std::uint32_t i = t.first + t.count; i-- > t.first;) {
    GroupNode& n = g.nodes[i];
    const GroupBody& b = g.bodies[n.body];
    const Vec3 momentum = n.mass * own_velocity(b, n);
    Wrench gained{momentum, (n.world_inertia + n.tautness) * b.spin + glm::cross(n.arm, momentum)};
    gained.force -= n.begin.force + n.load.force;
    gained.torque -= n.begin.torque + n.load.torque;
    n.passing += gained;
    if (n.free_root) continue;
    n.pulled_earlier = n.pulled, n.pulled = n.passing.force;
    n.reaction.force += n.passing.force;
    n.reaction.torque += n.passing.torque - n.actuator.impulse * n.actuator.axis;
    if (n.has_spring) {
      const Vec3 parent = n.parent == kNoNode ? t.held_spin : g.bodies[g.nodes[n.parent].body].spin;
      n.reaction.torque -= n.spring_torque - n.spring * (b.spin - parent);
    }
    if (n.parent == kNoNode) continue;
    g.nodes[n.parent].passing.force += n.passing.force;
    g.nodes[n.parent].passing.torque += n.passing.torque + glm::cross(n.lever, n.passing.force);
  }
}

/// The motion that joints prevented in a substep.
struct Prevented {
  Real way = 0;     // relative to the motion, as speeds weighted by mass
  Real gained = 0;  // J, kinetic energy if velocities followed it
  Real lifted = 0;  // J, by it against weight and applied forces
};

Prevented prevented_in(const Group& g, const GroupTree& t, Real h) {
  Prevented p;
  Real kept = 0, all = 0;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    const GroupNode& n = g.nodes[i];
    const GroupBody& b = g.bodies[n.body];
    const Vec3 change = n.missed_by / h;
    p.gained += n.mass * glm::dot(change, b.velocity + 0.5 * change);
    p.lifted -= n.mass * glm::dot(n.missed_by, b.acceleration);
    kept += n.mass * glm::dot(change, change), all += n.mass * glm::dot(b.velocity, b.velocity);
  }
  p.way = kept > 0 ? std::sqrt(kept / all) : 0;
  return p;
}

/// Moves velocities towards the average velocities of the substep where that removes energy: the
/// motion that joints prevented is lost. Small corrections come from the curvature of paths alone;
/// their share is smaller, so that the loss vanishes with the step.
void slow_to_way(const Group& g, const GroupTree& t, const Prevented& p, Real h) {
  if (!(p.gained < 0)) return;
  PANTIN_ASSERT(h > 0);
  const Real share = std::min(Real(1), p.way / kFastWay) / h;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i)
    g.bodies[g.nodes[i].body].velocity += share * g.nodes[i].missed_by;
}

/// J: kinetic energy of a tree relative to its mass centre, if it stands to the ground, from the
/// momenta of its bodies.
Real inner_energy(const Group& g, const GroupTree& t) {
  Vec3 drift(0);
  Real sum = 0;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    const GroupNode& n = g.nodes[i];
    const GroupBody& b = g.bodies[n.body];
    const Vec3 inside = glm::conjugate(b.pose.rotation) * b.angular_momentum;
    drift += n.mass * b.velocity;
    sum += 0.5 * (n.mass * glm::dot(b.velocity, b.velocity) + glm::dot(inside, inside / n.inertia));
  }
  return t.stands ? sum : sum - 0.5 * glm::dot(drift, drift) / t.mass;
}

/// Scales these motions so that moving the tree adds no energy.
void bound_inner_energy(const Group& g, const GroupTree& t, Real before) {
  const Real now = inner_energy(g, t);
  if (!(now > before)) return;
  const Real part = std::sqrt(std::max(Real(0), before / now));
  Vec3 drift(0);
  for (std::uint32_t i = t.first; !t.stands && i < t.first + t.count; ++i)
    drift += g.nodes[i].mass / t.mass * g.bodies[g.nodes[i].body].velocity;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    GroupBody& b = g.bodies[g.nodes[i].body];
    b.velocity = drift + part * (b.velocity - drift), b.angular_momentum *= part;
  }
}

void release_tree(const Group& g, GroupTree& t, const GroupPart& part) {
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) g.nodes[i].passing = {};
  if (part.h > 0) add_reactions(g, t);
  Vec3 middle(0), drift(0), before(0);
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    const GroupNode& n = g.nodes[i];
    GroupBody& b = g.bodies[n.body];
    b.velocity = own_velocity(b, n);
    middle += n.mass * (b.centre + n.arm), drift += n.mass * b.velocity;
  }
  middle /= t.mass, drift /= t.mass;
  for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
    const GroupNode& n = g.nodes[i];
    GroupBody& b = g.bodies[n.body];
    const Vec3 inside = n.inertia * (glm::conjugate(n.rotation) * b.spin);
    before += n.world_inertia * b.spin +
              n.mass * glm::cross(b.centre + n.arm - middle, b.velocity - drift);
    b.angular_momentum = b.pose.rotation * turned_momentum(inside, n.inertia, part.h);
  }
  if (!(part.h > 0)) return;
  const Prevented prevented = prevented_in(g, t, part.h);
  Real energy = inner_energy(g, t);
  if (prevented.way > kFastWay) energy -= std::max(Real(0), prevented.lifted);
  slow_to_way(g, t, prevented, part.h);
  if (is_free(g, t) && !t.stands) keep_angular_momentum(g, t, before);
  bound_inner_energy(g, t, energy);
}

}  // namespace

void move_trees(const Group& g, const GroupPart& part) {
  for_each_tree(g, [&](GroupTree& t) { place_tree(g, t, part); });
  hold_contacts(g, part);
  for_each_tree(g, [&](GroupTree& t) { keep_mass_centre(g, t, part); });
}

bool are_open(const Group& g, Real times) {
  return std::any_of(g.loops.begin(), g.loops.end(),
                     [&](const GroupLoops& l) { return gaps_of(g, l).worst > times * l.open; });
}

bool close_loops(const Group& g, const GroupPart& part) {
  bool moved = false;
  for (const GroupLoops& l : g.loops) {
    const std::span<GroupTree> trees = g.trees.subspan(l.first_tree, l.trees);
    const LoopGaps gaps = gaps_of(g, l);
    if (!(gaps.worst > l.open)) continue;
    for (const GroupTree& t : trees)
      for (std::uint32_t i = t.first; i < t.first + t.count; ++i) g.nodes[i].passing = {};
    push_closing(g, l);
    Real most = 0;
    for (const GroupTree& t : trees) most = std::max(most, respond_to_impulses(g, t));
    // The response is linearised: limit the largest rotation, and halve it while gaps widen.
    Real share = kFarthestTurn / std::max(kFarthestTurn, most);
    LoopGaps now = gaps;
    for (const Real least = kSmallestShare * share; share > least; share *= 0.5) {
      for (const GroupTree& t : trees)
        turn_by(g, t, share), place_by_joints(g, t, place_of(t, part.begin));
      now = gaps_of(g, l);
      if (now.squares < gaps.squares) break;
      for (const GroupTree& t : trees) turn_back(g, t);
    }
    moved = moved || (now.squares < gaps.squares && now.worst > kNearlyClosed * l.open);
  }
  return moved;
}

namespace {

/// A body that a cable which is too long pulls, or the tree that it is part of.
class Pulled {
 public:
  Pulled(const Group& g, std::uint32_t body) : g_(g), body_(g.bodies[body]), kept_(body_.pose) {
    if (body_.node == kNoNode) return;
    tree_ = &g.trees[g.nodes[body_.node].tree];
    for (std::uint32_t i = tree_->first; i < tree_->first + tree_->count; ++i)
      g.nodes[i].passing = {};
  }
  GroupTree* tree() const { return tree_; }
  void pull(Vec3 impulse, Vec3 arm) {
    const Vec3 moment = glm::cross(arm, impulse);
    if (tree_)
      g_.nodes[body_.node].passing += {impulse, moment};
    else
      move_ = body_.per_mass * impulse, turn_ = body_.response * moment;
  }
  /// Finds its motion. Returns the largest rotation, rad.
  Real respond() { return tree_ ? respond_to_impulses(g_, *tree_) : glm::length(turn_); }
  void move_by(Real share, Real at) {
    if (tree_) return turn_by(g_, *tree_, share), place_by_joints(g_, *tree_, place_of(*tree_, at));
    body_.pose.position += share * move_;
    body_.pose.rotation = glm::normalize(from_rotation_vector(share * turn_) * body_.pose.rotation);
  }
  void move_back() {
    if (tree_) return turn_back(g_, *tree_);
    body_.pose = kept_;
  }

 private:
  const Group& g_;
  GroupBody& body_;
  Pose kept_;
  GroupTree* tree_ = nullptr;
  Vec3 move_{0}, turn_{0};
};

Real excess_of(const GroupTie& t) { return glm::length(t.apart) - t.length; }

/// Moves the bodies that a cable connects, in proportion to their responses, until it is as long as
/// it may be. Returns whether that shortened it.
bool shorten(const Group& g, GroupTie& t, const GroupPart& part) {
  const Real excess = excess_of(t);
  const Vec3 impulse = excess / t.along * glm::normalize(t.apart);
  Pulled a(g, t.a), b(g, t.b);
  const bool same = a.tree() && a.tree() == b.tree();
  a.pull(impulse, t.arm_a), b.pull(-impulse, t.arm_b);
  Real most = a.respond();
  if (!same) most = std::max(most, b.respond());
  // The response is linearised: limit the largest rotation, and halve it while the gap widens.
  Real share = kFarthestTurn / std::max(kFarthestTurn, most);
  for (const Real least = kSmallestShare * share; share > least; share *= 0.5) {
    a.move_by(share, part.begin);
    if (!same) b.move_by(share, part.begin);
    place_tie(g, t);
    if (std::abs(excess_of(t)) < excess) return true;
    a.move_back();
    if (!same) b.move_back();
    place_tie(g, t);
  }
  return false;
}

}  // namespace

bool shorten_cables(const Group& g, const GroupPart& part) {
  bool moved = false;
  for (GroupTie& t : g.ties) {
    // Closed loops would be opened.
    if (!is_inextensible(t) || g.bodies[t.a].looped != kNoNode || g.bodies[t.b].looped != kNoNode)
      continue;
    place_tie(g, t);
    if (!(excess_of(t) > kTooLong * t.length)) continue;
    prepare_tie(g, t, part.whole);
    moved = (t.along > 0 && shorten(g, t, part)) || moved;
  }
  return moved;
}

void release_trees(const Group& g, const GroupPart& part) {
  for_each_tree(g, [&](GroupTree& t) { release_tree(g, t, part); });
}

}  // namespace pantin::detail::articulated
