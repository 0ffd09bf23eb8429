#include "engine/solvers/articulated/impulses/meetings.hpp"

#include <algorithm>

#include "engine/contact/detect.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/impulses/group_scratch.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::articulated {
namespace {

bool is_mutual(const World& world, const Contact& c) {
  return is_own(world, c.slot_a) && is_own(world, c.slot_b);
}

/// The islands of both bodies of a contact.
struct BothIslands {
  std::uint32_t a, b;
};
BothIslands islands_at(const World& world, const Contact& c) {
  const Partition& partition = partition_of(world);
  return {owner_of(partition, c.slot_a).island, owner_of(partition, c.slot_b).island};
}

/// m/s: at which the bodies of a contact approach each other there.
Real approach_of(const World& world, const Contact& c) {
  const auto velocity = [&](std::uint32_t slot, Vec3 point) {
    const Body& b = world.bodies.values()[slot];
    return b.velocity + glm::cross(b.angular_velocity, b.pose.rotation * point);
  };
  return glm::dot(velocity(c.slot_b, c.point_b) - velocity(c.slot_a, c.point_a), c.normal);
}

/// Bounds on the speeds of groups of awake islands in a step.
class SpeedBounds {
 public:
  SpeedBounds(const World& world, GroupScratch& r, Real h) : world_(world), r_(r), h_(h) {
    const Islands& all = world.memory.of<Islands>();
    r.speeds.assign(all.list.size(), 0), r.flags.assign(all.list.size(), 0);
    for (const Contact& c : contacts_of(world)) note(c);
    for (const std::uint32_t i : all.rest.awake) {
      const std::uint32_t root = r.sets.root(i);
      const Real fall = (r.flags[i] & kBorne) != 0 ? 0 : fall_of(world, all.list[i], h);
      r.speeds[root] = std::max(r.speeds[root], speed_bound(world, all.list[i]) + fall);
      r.flags[root] |= (r.flags[root] & kOne) == 0 ? kOne : kSeveral;
    }
    for (const Contact& c : contacts_of(world)) {
      if (!strikes(c)) continue;
      const std::uint32_t i = islands_at(world, c).a;
      Real& most = r.speeds[r.sets.root(i)];
      most = std::max(most, speed_bound(world, all.list[i]) + approach_of(world, c));
    }
  }
  /// Whether an awake island may meet a sleeping one at a contact. One body that touches no other
  /// awake one, and strikes nothing, moves as it does now; in a group another may strike it first.
  bool may_meet(const Contact& c, std::uint32_t awake, std::uint32_t asleep) const {
    const IslandVector& list = islands_of(world_);
    const Island& a = list[awake];
    const std::uint32_t root = r_.sets.root(awake);
    const bool is_alone = (r_.flags[root] & kSeveral) == 0 && a.count() == 1;
    const bool is_steady = (r_.flags[awake] & (kBorne | kStruck)) == kBorne;
    const Real speed =
        is_alone && is_steady ? std::max(Real(0), approach_of(world_, c)) : r_.speeds[root];
    const Real near = kWakes * (touching_gap(a, list[asleep]) + h_ * speed);
    return c.lambda != Vec3(0) || c.gap < near || has_power(world_, a) || !can_join(a);
  }

 private:
  /// Flags of a group's first island: it has one, or several. Of any: contacts bear it, and it
  /// strikes what is fixed or is struck by what moves.
  static constexpr std::uint8_t kOne = 1, kSeveral = 2, kBorne = 4, kStruck = 8;

  /// Whether a body meets in the step one that no solver here moves.
  bool strikes(const Contact& c) const {
    if (!is_own(world_, c.slot_a) || is_own(world_, c.slot_b)) return false;
    return h_ * approach_of(world_, c) > std::max(Real(0), c.gap) + h_ * kSlow ||
           contact::moves(world_.bodies.values()[c.slot_b]);
  }
  void note(const Contact& c) {
    if (!is_own(world_, c.slot_a)) return;
    const auto [a, b] = islands_at(world_, c);
    if (c.lambda != Vec3(0)) r_.flags[a] |= kBorne;
    if (c.lambda != Vec3(0) && is_own(world_, c.slot_b)) r_.flags[b] |= kBorne;
    if (strikes(c)) r_.flags[a] |= kStruck;
  }
  static constexpr Real kSlow = 0.05;  // m/s: slower impacts throw nothing aside
  const World& world_;
  GroupScratch& r_;
  Real h_;
};

}  // namespace

bool can_join(const Island& a) {
  return !a.unfit && a.finite && a.settings.solver == Solver::articulated;
}

bool has_power(const World& world, const Island& a) {
  if (a.forced || !a.pins.empty() || !a.cables.empty()) return true;
  for (const Tree& t : a.trees)
    if (t.target != t.target_before) return true;
  for (std::size_t c = 0; c < a.joints.size(); ++c)
    if (a.joints[c].stiff && is_driven(world, a, c)) return true;
  return false;
}

Real speed_bound(const World& world, const Island& a) {
  Real most = 0;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    most = std::max(most, glm::length(b.velocity) + a.size * glm::length(b.angular_velocity));
  }
  return most;
}

Real fall_of(const World& world, const Island& a, Real h) {
  Real most = 0;
  for (std::size_t c = 0; c < a.count(); ++c)
    most = std::max(most, std::abs(a.constants.at(kGravityScale, c)));
  return most * h * glm::length(world.gravity);
}

void join_touching(const World& world, std::span<const Contact> contacts, DisjointSets& sets) {
  for (const Contact& c : contacts) {
    if (!is_mutual(world, c)) continue;
    const auto [a, b] = islands_at(world, c);
    sets.join(a, b);
  }
}

bool is_idle(const World& world, const Contact& c) {
  if (!is_mutual(world, c)) return false;
  const auto [a, b] = islands_at(world, c);
  return islands_of(world)[a].asleep != islands_of(world)[b].asleep;
}

void join_islands(const World& world, GroupScratch& r, Real h) {
  bool mixed = false;
  for (const Contact& c : contacts_of(world)) {
    if (!is_mutual(world, c)) continue;
    const auto [a, b] = islands_at(world, c);
    if (is_idle(world, c))
      mixed = true;
    else
      r.sets.join(a, b);
  }
  if (!mixed) return;
  const SpeedBounds bounds(world, r, h);
  for (const Contact& c : contacts_of(world)) {
    if (!is_idle(world, c)) continue;
    auto [awake, asleep] = islands_at(world, c);
    if (islands_of(world)[awake].asleep) std::swap(awake, asleep);
    if (bounds.may_meet(c, awake, asleep)) r.sets.join(awake, asleep);
  }
}

}  // namespace pantin::detail::articulated
