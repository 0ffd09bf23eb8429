// Finds groups of touching bodies and trees, writes back their steps (step_group.cpp), their sleep.
#include <algorithm>
#include <optional>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/resting.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/impulses/group_points.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::articulated {
namespace {

/// Error of Contact::rest at which bodies may fall asleep, as a fraction of the shallow overlap.
constexpr Real kSettled = 5e-4;
/// Sleep freezes forces: it waits until speeds fall below this fraction of the sleep speed, or for
/// this time, s; in heaps of free bodies for the last.
constexpr Real kDead = 1e-3, kPatience = 3, kPatienceInHeap = 1;
/// In a heap, bodies spinning in place may sleep at a spin this many times larger.
constexpr Real kSpinsInHeap = 10;
/// Threads share a group of so many pairs.
constexpr std::size_t kManyPairs = 128;

/// Flags of a group.
constexpr std::uint8_t kOtherMethod = 1, kAwake = 2;

bool can_join(const Island& a) {
  return !a.unfit && a.finite && a.settings.solver == Solver::articulated;
}

}  // namespace

namespace {

bool is_mutual(const World& world, const Contact& c) {
  return is_own(world, c.slot_a) && is_own(world, c.slot_b);
}

/// Joins the islands of both bodies of each contact.
void join_touching(const World& world, std::span<const Contact> contacts, DisjointSets& sets) {
  const Partition& partition = partition_of(world);
  for (const Contact& c : contacts)
    if (is_mutual(world, c))
      sets.join(owner_of(partition, c.slot_a).island, owner_of(partition, c.slot_b).island);
}

/// Sets group and flags of the islands that are awake and of sleeping ones that are touched.
/// Returns whether one of the latter has to wake.
bool list_groups(const World& world, GroupScratch& r) {
  const Islands& all = world.memory.of<Islands>();
  r.flags.assign(all.list.size(), 0);
  for (const std::vector<std::uint32_t>* list : {&all.rest.awake, &all.rest.touched})
    for (const std::uint32_t i : *list) {
      const Island& a = all.list[i];
      r.group_of[i] = r.sets.root(i);
      if (!can_join(a)) r.flags[r.group_of[i]] |= kOtherMethod;
      if (!a.asleep) r.flags[r.group_of[i]] |= kAwake;
    }
  const auto wakes = [&](std::uint32_t i) { return all.list[i].asleep && r.flags[r.group_of[i]]; };
  return std::any_of(all.rest.touched.begin(), all.rest.touched.end(), wakes);
}

/// Wakes all islands connected to an awake one by contacts, and releases their resting contacts.
void wake_groups(World& world, GroupScratch& r, Real h) {
  Islands& all = world.memory.of<Islands>();
  rest_lists(world);
  join_touching(world, resting_contacts_of(world), r.sets);
  list_groups(world, r);
  for (const RestLists::Sleeper& s : all.rest.sleepers)
    if (r.flags[r.sets.root(s.island)] != 0) wake(world, all.list[s.island], h);
  const Partition& partition = partition_of(world);
  contact::release_resting(world.memory.of<contact::Memory>(), [&](const Contact& c) {
    return !all.list[owner_of(partition, c.slot_a).island].asleep;
  });
  std::vector<std::uint32_t>& awake = world.memory.of<Partition>().awake;
  std::sort(awake.begin(), awake.end());
  assign_contacts(world, h);
  list_groups(world, r);
}

}  // namespace

void plan_contact_groups(World& world, Real h) {
  Islands& all = world.memory.of<Islands>();
  GroupScratch& r = all.groups;
  r.sets.reset(all.list.size()), r.group_of.resize(all.list.size());
  join_touching(world, contacts_of(world), r.sets);
  const bool woke = all.rest.version != partition_of(world).rest_version;
  if (list_groups(world, r) || woke) wake_groups(world, r, h);
  std::vector<Contact>& contacts = contacts_of(world);
  for (const std::uint32_t i : all.rest.awake) {
    Island& a = all.list[i];
    const bool joins = (r.flags[r.group_of[i]] & kOtherMethod) == 0;
    for (const ContactRow& row : a.scratch.contact_rows)
      if (!joins) contacts[row.contact].rest = 0;
    a.in_group = joins && !a.scratch.contact_rows.empty();
  }
}

namespace {

/// Writes a body back to the world. False if it is lost: not finite or too far away.
bool write_body(World& world, Island& a, std::size_t column, const GroupBody& f) {
  PANTIN_ASSERT(column < a.count() && a.slots[column] == f.slot);
  Body& b = world.bodies.values()[f.slot];
  const Vec3 x = f.pose.position;
  if (!(is_finite(f.pose) && is_finite(f.velocity) && is_finite(f.spin) &&
        glm::dot(x, x) < kTooFar * kTooFar)) {
    a.lost = a.bodies[column];
    return false;
  }
  a.memory.set(kLastTranslation, column, x - b.pose.position);
  a.memory.set(kLastRotation, column,
               rotation_vector(f.pose.rotation * glm::conjugate(b.pose.rotation)));
  b.pose = f.pose, b.velocity = f.velocity, b.angular_velocity = f.spin;
  return true;
}

/// Writes the reactions of a joint, for reports and for other methods.
void write_joint(World& world, Island& a, const GroupNode& n, Real h) {
  if (n.free_root) return;
  PANTIN_ASSERT(n.column < a.count() && (!n.joint || n.joint == &a.joints[n.column]));
  a.memory.set(kLambda, n.column, h * n.reaction.force);
  if (!n.joint) return;
  JointMemory& memory = a.joint_memory[n.column];
  memory.torque_fraction = n.drive_share, memory.torque = n.reaction.torque / h;
  memory.actuation = std::numeric_limits<Real>::quiet_NaN();
  for (int s = 0; s < 4; ++s) memory.lambdas[s] = h * h * n.limits[s].impulse;
  a.stops_hit += std::any_of(std::begin(n.limits), std::end(n.limits),
                             [](const GroupLimit& l) { return l.impulse != 0; });
  if (!n.drive) return;
  JointDrive& drive = world.joint_drives.values()[a.joints[n.column].drive];
  drive.torque = n.drive_torque, drive.capped = n.drive_share < 1;
  a.drives_capped += drive.capped;
}

/// Writes back bodies, joints and warm starts of the group's islands.
void write_group(World& world, const Group& g, Real h) {
  IslandVector& list = islands_of(world);
  for (const GroupTree& t : g.trees) list[t.island].energy_removed += t.energy_removed;
  for (const GroupTie& t : g.ties) {
    PANTIN_ASSERT(t.island < list.size() && list[t.island].in_group);
    Island& a = list[t.island];
    a.energy_removed += t.energy_removed;
    if (t.is_joint)
      a.memory.set(kLambda, t.number, h * t.passed);
    else if (t.kind == GroupTie::Kind::cable)
      a.cables[t.number].lambda = h * t.passed.x;
    else
      a.pins[t.number].lambda = h * t.passed;
  }
  for (const GroupBody& f : g.bodies) {
    if (f.island == UINT32_MAX) continue;
    Island& a = list[f.island];
    PANTIN_ASSERT(a.in_group && (f.node != kNoNode || a.count() == 1));
    const std::size_t column = f.node == kNoNode ? 0 : g.nodes[f.node].column;
    if (column == 0) {
      a.stops_hit = a.drives_capped = 0;
      a.jammed = a.jammed || f.jammed;
      a.limited = a.contact_active = false;
      a.knows_torques = true;
      a.sweeps_used = 0;
      for (Tree& t : a.trees) t.knows_angular_momentum = false;
    }
    if (!a.lost) write_body(world, a, column, f);
    if (f.node != kNoNode) write_joint(world, a, g.nodes[f.node], h);
    if (column + 1 < a.count() || a.lost) continue;
    remember_step(world, a, h);
  }
}

void write_contact(World& world, const Group& g, const GroupContact& f, Real h) {
  Contact& c = contacts_of(world)[f.contact];
  c.torque_lambda = c.torque = Vec3(0);
  if (f.rolling != kNoNode) {
    PANTIN_ASSERT(f.rolling < g.rollings.size());
    const GroupRolling& r = g.rollings[f.rolling];
    const Real share = Real(1) / r.count;  // each point has an equal share
    c.torque_lambda = share * h * h * to_world(r, r.impulse);
    c.torque = share / h * to_world(r, r.passed);
  }
  c.lambda = h * h * to_world(f, f.impulse);
  c.force = to_world(f, f.passed) / h;
  c.active = f.passed.x > 0, c.rest = f.rest;
  c.depth = std::max(Real(0), -f.gap);
}

/// Whether Contact::rest has converged to the compression under load at all contacts.
bool is_settled(std::span<const GroupContact> contacts) {
  return std::all_of(contacts.begin(), contacts.end(),
                     [](const GroupContact& c) { return c.settling <= kSettled * c.shallow; });
}

/// Whether an overlap is so deep that it is still being separated with speed.
bool is_deep(std::span<const GroupContact> contacts) {
  return std::any_of(contacts.begin(), contacts.end(),
                     [](const GroupContact& c) { return c.gap < -c.shallow - c.rest; });
}

/// Whether a moving surface acts on this contact: it carries bodies along, or slips under them.
bool bears_moving_surface(const GroupContact& c) {
  return c.passed.x > 0 && (c.surface_first != 0 || c.surface_second != 0);
}

/// Puts a group to sleep once all of it has been still for long enough.
void let_sleep(World& world, const Group& g, Real h) {
  IslandVector& list = islands_of(world);
  for (const GroupContact& c : g.contacts) {
    if (!(c.passed.x > 0)) continue;
    list[g.a(c).island].contact_active = true;
    if (g.b(c).per_mass > 0) list[g.b(c).island].contact_active = true;
  }
  const bool settled = is_settled(g.contacts), deep = is_deep(g.contacts);
  bool still = std::none_of(g.contacts.begin(), g.contacts.end(), bears_moving_surface);
  bool rested = false;  // current island; among trees, arms may swing for long
  bool all_dead = true;
  const bool is_heap = g.trees.empty() && !g.has_at_most(kFewBodies);
  const Real turning = is_heap ? kSpinsInHeap * kTurning : kTurning;
  const Real patience = is_heap ? kPatienceInHeap : kPatience;
  for (const GroupBody& f : g.bodies) {
    if (f.per_mass == 0) {
      still = still && f.velocity == Vec3(0) && f.spin == Vec3(0);
      continue;
    }
    Island& a = list[f.island];
    const Real slow = a.settings.sleep_speed;
    const Real speed = glm::length(f.velocity), spin = glm::length(f.spin);
    const bool drives = f.node != kNoNode && g.nodes[f.node].is_driven;
    if (f.node == kNoNode || g.nodes[f.node].column == 0) {
      a.quiet_time += h;  // unless one of its bodies moves
      rested = !g.trees.empty() && has_rested(world, a, h) && !deep;
    }
    if (!a.contact_active || drives || !(speed < slow && spin < turning * slow)) a.quiet_time = 0;
    const bool dead = speed < kDead * slow && spin < kTurning * kDead * slow;
    all_dead = all_dead && dead;
    still =
        still && !drives && (rested || a.quiet_time > (dead && settled ? kTimeToSleep : patience));
  }
  for (const GroupTie& t : g.ties) {
    const bool is_slack = t.kind != GroupTie::Kind::cable || t.passed.x == 0;
    still = still && (is_slack || all_dead);
  }
  for (const GroupTree& t : g.trees) still = still && t.from == t.to && t.held_spin == Vec3(0);
  if (!still) return;
  for (const GroupBody& f : g.bodies)
    if (f.per_mass > 0 && !list[f.island].asleep) fall_asleep(world, list[f.island]);
}

/// Relative cost of a substep: trees are traversed, contacts are solved.
Real weight_of(const GroupScratch::Range& g) {
  return 3 * static_cast<Real>(g.bodies) + static_cast<Real>(g.contacts) +
         9 * static_cast<Real>(g.ties);
}

/// Prepares the division of the budget: weights times importance, as sums from each group to the
/// last one.
void weigh_groups(const World& world, GroupScratch& r, const Budget* budget) {
  r.costs.clear();
  if (!budget) return;
  r.costs.resize(r.groups.size()), r.weights.assign(r.groups.size() + 1, 0);
  for (std::size_t i = r.groups.size(); i-- > 0;) {
    const GroupScratch::Range& g = r.groups[i];
    const Entity body = world.bodies.owners()[r.bodies[g.first_body].slot];
    const bool asks = budget->importance && *budget->importance;
    const Real importance = asks ? std::max(Real(0), (*budget->importance)(body)) : 1;
    r.weights[i] = r.weights[i + 1] + importance * weight_of(g), r.costs[i].body = body;
  }
}

/// The pace of group i: its share of the time that is left, where so many groups are stepped at
/// once.
Pace pace_of(const GroupScratch& r, std::size_t i, const StepTask& task, int at_once) {
  if (!task.budget) return {};
  const Clock::time_point now = Clock::now();
  const Real whole = r.weights[i], own = whole - r.weights[i + 1];
  const Real share = whole > 0 ? std::min(Real(1), std::max(1, at_once) * own / whole) : 0;
  const auto time = std::chrono::duration_cast<Clock::duration>(share * (task.budget->until - now));
  return {now + time, r.cost * weight_of(r.groups[i])};
}

/// Remembers what the weights cost, for the next step.
void learn_cost(GroupScratch& r) {
  Real seconds = 0, weight = 0;
  for (std::size_t i = 0; i < r.costs.size(); ++i)
    seconds += r.costs[i].seconds, weight += r.costs[i].substeps * weight_of(r.groups[i]);
  if (weight > 0) r.cost = seconds / weight;
}

}  // namespace

void step_contact_groups(World& world, const StepTask& task) {
  GroupScratch& r = world.memory.of<Islands>().groups;
  gather_groups(world, r, task.h);
  const Real h = task.h;
  const auto group = [&](const GroupScratch::Range& g) {
    return Group{std::span(r.bodies).subspan(g.first_body, g.bodies),
                 std::span(r.contacts).subspan(g.first_contact, g.contacts),
                 std::span(r.pairs).subspan(g.first_pair, g.pairs),
                 std::span(r.nodes).subspan(g.first_node, g.nodes),
                 std::span(r.trees).subspan(g.first_tree, g.trees),
                 std::span(r.crosses).subspan(g.first_cross, g.crosses),
                 std::span(r.ties).subspan(g.first_tie, g.ties),
                 std::span(r.rollings).subspan(g.first_rolling, g.rollings),
                 std::span(r.skins),
                 std::span(r.loops).subspan(g.first_loops, g.loops),
                 std::span(r.looped).subspan(g.first_looped, g.looped),
                 std::span(r.path_steps).subspan(g.first_step, g.steps),
                 std::span(r.number_list).subspan(g.first_number, g.numbers),
                 std::span(r.resting).subspan(g.first_resting, g.resting),
                 std::span(r.rest_contacts).subspan(g.first_contact, g.contacts),
                 std::span(r.rest_rows).subspan(g.first_resting, g.resting),
                 std::span(r.rest_links).subspan(g.first_link, g.links),
                 world.time,
                 {}};
  };
  weigh_groups(world, r, task.budget);
  const auto step_one = [&](std::size_t i, Group g) {
    Pace pace = pace_of(r, i, task, g.threads.are_many() ? 1 : task.threads.count);
    const Clock::time_point from = task.budget ? Clock::now() : Clock::time_point{};
    step_group(g, h, pace);
    if (!task.budget) return;
    GroupCost& cost = r.costs[i];
    cost.seconds = std::chrono::duration<Real>(Clock::now() - from).count();
    cost.substeps = pace.taken(), cost.planned = pace.planned();
  };
  const auto is_large = [&](std::size_t i) {
    return task.threads.are_many() && r.groups[i].pairs >= kManyPairs;
  };
  for (std::size_t from = 0, to = 0; from < r.groups.size(); from = to) {
    if (to = from + 1; is_large(from)) {  // all threads work on it
      Group large = group(r.groups[from]);
      large.threads = task.threads;
      step_one(from, large);
      continue;
    }
    while (to < r.groups.size() && !is_large(to)) ++to;
    for_each_island(to - from, task,
                    [&](std::size_t i) { step_one(from + i, group(r.groups[from + i])); });
  }
  learn_cost(r);
  for (const GroupScratch::Range& g : r.groups) write_group(world, group(g), h);
  for (const GroupScratch::Range& g : r.groups)
    for (const Group all = group(g); const GroupContact& c : all.contacts)
      write_contact(world, all, c, h);
  for (const GroupScratch::Range& g : r.groups) let_sleep(world, group(g), h);
}

}  // namespace pantin::detail::articulated
