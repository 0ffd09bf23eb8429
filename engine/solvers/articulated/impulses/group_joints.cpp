// Limits, soft zones and drives of the joints of trees in contact.
//
// Soft zones and drives are springs and dampers at the end of the substep, part of the joint's
// mobility; limits are impulses, iterated with the contacts.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/world/joint_drive.hpp"

namespace pantin::detail::articulated {
namespace {

/// rad: a limit with more clearance is not solved for in a substep.
constexpr Real kWatchedClearance = 0.15;

void list_drive(const GroupNode& n, const JointTurn& at, TurnSprings& list) {
  const auto& [own, parent, time, part] = at;
  const JointDrive& drive = *n.drive;
  const Real until = time + part.end * part.whole, from = time + part.begin * part.whole;
  const Quat to = own_rotation(*n.joint, parent, target_at(drive, until));
  Vec3 ahead(0);  // rad
  if (!drive.keys.empty())
    ahead = rotation_vector(to *
                            glm::conjugate(own_rotation(*n.joint, parent, target_at(drive, from))));
  const Real k = n.drive_share * part.h * drive.stiffness, d = n.drive_share * drive.damping;
  // `to` is the target of the drive at the end of the substep.
  const Vec3 torque = k * rotation_vector(to * glm::conjugate(own)) + d * ahead;
  for (int i = 0; i < 3; ++i) list.add({kAxes[i], part.h * k + part.h * d, torque[i]});
}

}  // namespace

TurnSprings springs_of(const GroupNode& n, const JointTurn& at) {
  PANTIN_ASSERT(n.joint && n.has_spring);
  TurnSprings list;
  const JointLimits& limits = n.joint->joint.limits;
  if (limits.soft_zone > 0) {
    JointLimit found[4];
    find_limits(*n.joint, at.own, at.parent, found);
    for (const JointLimit& limit : found) {
      const Real within = limits.soft_zone - limit.clearance;
      if (!limit.watched || !(within > 0)) continue;
      const Real k = at.part.h * limits.soft_stiffness;
      list.add({limit.along, at.part.h * (k + limits.soft_damping), -k * within});
    }
  }
  if (n.drive) list_drive(n, at, list);
  return list;
}

void prepare_springs(const Group& g, GroupNode& n, const GroupPart& part) {
  n.spring = Mat3(0), n.spring_torque = Vec3(0);
  for (const TurnSpring& s : springs_of(n, {n.rotation, parent_rotation(g, n), g.time, part})) {
    n.spring += s.damping * glm::outerProduct(s.along, s.along);
    n.spring_torque += s.torque * s.along;
  }
}

void bound_drives(const Group& g, Real h) {
  for (GroupNode& n : g.nodes) {
    if (!n.drive || !(h > 0)) continue;
    PANTIN_ASSERT(n.joint);
    const Vec3 parent =
        n.parent == kNoNode ? g.trees[n.tree].held_spin : g.bodies[g.nodes[n.parent].body].spin;
    const Vec3 turning = g.bodies[n.body].spin - parent;
    const Vec3 torque = (n.spring_torque - n.spring * turning) / (h * n.drive_share);
    const Real whole = glm::length(torque);
    n.drive_share = whole > n.drive->max_torque ? n.drive->max_torque / whole : 1;
    n.drive_torque = n.drive_share * whole;
  }
}

void prepare_limits(const Group& g, std::uint32_t node) {
  GroupNode& n = g.nodes[node];
  PANTIN_ASSERT(n.joint && n.is_limited);
  const Quat parent = parent_rotation(g, n);
  const bool acts = std::any_of(std::begin(n.limits), std::end(n.limits),
                                [](const GroupLimit& l) { return l.impulse > 0; });
  if (!acts && is_far_from_limits(*n.joint, n.rotation, parent, kWatchedClearance)) {
    for (GroupLimit& limit : n.limits) limit.listed = false, limit.impulse = limit.before = 0;
    return;
  }
  JointLimit found[4];
  find_limits(*n.joint, n.rotation, parent, found);
  for (int s = 0; s < 4; ++s) {
    GroupLimit& limit = n.limits[s];
    limit.listed = found[s].watched && (found[s].both_ways || limit.impulse > 0 ||
                                        found[s].clearance < kWatchedClearance);
    if (!limit.listed) {
      limit.impulse = limit.before = 0;
      continue;
    }
    // Warm start along the same direction only, and without replaying an impact.
    const Real last = limit.impulse;
    const Real same = std::max(Real(0), glm::dot(limit.along, found[s].along));
    limit.impulse = found[s].both_ways ? last : same * std::min(last, limit.before);
    limit.before = last;
    limit.along = found[s].along, limit.clearance = found[s].clearance;
    limit.both_ways = found[s].both_ways;
    limit.response = glm::dot(limit.along, joint_response(g, n, limit.along));
    // A joint that cannot rotate in this direction does not need the limit.
    if (!(limit.response > 0)) limit.listed = false, limit.impulse = limit.before = 0;
  }
}

void push_limits(const Group& g) {
  for (std::uint32_t i = 0; i < g.nodes.size(); ++i) {
    const GroupNode& n = g.nodes[i];
    if (!n.is_limited) continue;
    Vec3 sum(0);
    for (const GroupLimit& limit : n.limits)
      if (limit.listed) sum -= limit.impulse * limit.along;
    if (sum != Vec3(0)) apply_at_joint(g, i, sum);
  }
}

Real solve_limits(const Group& g, Real h, const LimitSpring& spring) {
  Real largest = 0;
  for (std::uint32_t i = 0; i < g.nodes.size(); ++i) {
    GroupNode& n = g.nodes[i];
    if (!n.is_limited) continue;
    for (GroupLimit& limit : n.limits) {
      if (!limit.listed) continue;
      PANTIN_ASSERT(limit.response > 0);
      const Real speed = glm::dot(limit.along, relative_spin(g, i));
      // Bodies are never rotated beyond a limit (group_motion.cpp). A spring acts a little before
      // the limit: loads of heaps come to rest on it.
      const Real left = limit.clearance - spring.buffer;
      const bool springs = !limit.both_ways && left <= 0 && spring.by;
      const bool holds =
          limit.both_ways || (!spring.by && (left <= 0 || limit.impulse > 0 || limit.before > 0));
      const Softness& by = springs ? *spring.by : Softness{};
      const Real most = holds ? 0 : springs ? spring.by->rate * left : left / h;
      Real impulse = limit.impulse + by.by_mass * (speed - most) / limit.response -
                     by.by_impulse * limit.impulse;
      if (!limit.both_ways) impulse = std::max(Real(0), impulse);
      const Real more = impulse - limit.impulse;
      if (more == 0) continue;
      limit.impulse = impulse;
      apply_at_joint(g, i, -more * limit.along);
      largest = std::max(largest, std::abs(more) * limit.response * glm::length(n.own_anchor));
    }
  }
  return largest;
}

}  // namespace pantin::detail::articulated
