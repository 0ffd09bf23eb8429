// Parts deep overlaps of bodies without joints that hardly move, by translations and rotations.
//
// Contact springs cannot part bodies that an impact has wedged into others: what pushes them apart
// presses them against their neighbours, where friction holds them, however hard it pushes. Poses
// are therefore corrected without friction and without change of velocity. [Jakobsen 2001]
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/impulses/group_points.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// m/s: faster bodies are left alone.
constexpr Real kHardlyMoves = 0.05;
/// Fraction of an overlap, beyond a shallow one, that is parted in a step.
constexpr Real kParted = 0.5;
constexpr int kPartingSweeps = 8;
/// Where this fraction of all overlaps is left, or more, there is no room: the poses stay.
constexpr Real kWorthwhile = 0.9;

/// Translates and rotates a body as an impulse changes its velocity and spin; kg m.
void shift(GroupBody& b, Vec3 arm, Vec3 impulse) {
  if (b.per_mass == 0) return;
  b.pose.position += b.per_mass * impulse;
  const Vec3 turn = b.response * glm::cross(arm, impulse);
  b.pose.rotation = glm::normalize(from_rotation_vector(turn) * b.pose.rotation);
}

/// Opens a contact to the gap that is asked for. Returns by how much, m.
Real part(const Group& g, GroupContact& c) {
  place(g, c);
  const Real need = c.asked - c.gap;
  if (!(need > 0)) return 0;
  const auto response = [&](const GroupBody& b, Vec3 arm) {
    const Vec3 moment = glm::cross(arm, c.axes[0]);
    return b.per_mass > 0 ? b.per_mass + glm::dot(moment, b.response * moment) : 0;
  };
  GroupBody &a = g.a(c), &b = g.b(c);
  const Vec3 impulse = need / (response(a, c.arm_a) + response(b, c.arm_b)) * c.axes[0];
  shift(a, c.arm_a, impulse), shift(b, c.arm_b, -impulse);
  return need;
}

/// m: sum of all overlaps beyond shallow ones.
Real sum_of_overlaps(const Group& g) {
  Real sum = 0;
  for (const GroupContact& c : g.contacts) sum += std::max(Real(0), -c.gap - c.shallow);
  return sum;
}

void part_all(const Group& g) {
  for (int n = 0; n < kPartingSweeps; ++n) {
    Real most = 0;
    for (std::size_t i = 0, last = g.contacts.size() - 1; i <= last; ++i)
      most = std::max(most, part(g, g.contacts[n % 2 == 0 ? i : last - i]));
    if (most == 0) break;
  }
}

}  // namespace

void part_overlaps(const Group& g, Real h) {
  if (!g.trees.empty() || !g.ties.empty() || g.has_at_most(kFewBodies)) return;
  if (std::none_of(g.contacts.begin(), g.contacts.end(), is_deep)) return;
  for (const GroupBody& b : g.bodies)
    if (b.per_mass > 0 && !(glm::length(b.velocity) < kHardlyMoves)) return;
  const Real before = sum_of_overlaps(g);
  for (GroupContact& c : g.contacts) {
    const Real beyond = std::max(Real(0), -c.gap - c.shallow);
    c.asked = std::min(Real(0), c.gap) + std::min(kParted * beyond, kPushSpeed * h);
  }
  for (GroupBody& b : g.bodies) b.kept = b.pose;
  part_all(g);
  for (GroupContact& c : g.contacts) place(g, c);
  const bool is_less = sum_of_overlaps(g) < kWorthwhile * before;
  const auto is_near = [&](const GroupBody& b) {
    return glm::distance(b.pose.position, b.kept.position) <= kPushSpeed * h;
  };
  if (!is_less || !std::all_of(g.bodies.begin(), g.bodies.end(), is_near))
    for (GroupBody& b : g.bodies) b.pose = b.kept;
  centre_bodies(g);
  for (GroupBody& b : g.bodies) b.response = inverse_inertia(b, b.pose.rotation);
  for (GroupContact& c : g.contacts) place(g, c);
}

}  // namespace pantin::detail::articulated
