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
#include "engine/solvers/articulated/impulses/meetings.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::articulated {
namespace {

/// A group is not searched for rest for 0, 1, 3, 7 steps after so many misses.
constexpr int kMostMisses = 4;
/// Threads share a group of so many pairs.
constexpr std::size_t kManyPairs = 128;

/// Flags of a group.
constexpr std::uint8_t kOtherMethod = 1, kAwake = 2;

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
/// Others may then meet an awake one.
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
  join_islands(world, r, h);
}

}  // namespace

void plan_contact_groups(World& world, Real h) {
  Islands& all = world.memory.of<Islands>();
  GroupScratch& r = all.groups;
  r.sets.reset(all.list.size()), r.group_of.resize(all.list.size());
  r.creeping.resize(all.list.size());
  join_islands(world, r, h);
  bool woke = all.rest.version != partition_of(world).rest_version;
  for (; list_groups(world, r) || woke; woke = false) wake_groups(world, r, h);
  std::vector<Contact>& contacts = contacts_of(world);
  for (const std::uint32_t i : all.rest.awake) {
    Island& a = all.list[i];
    const bool joins = (r.flags[r.group_of[i]] & kOtherMethod) == 0;
    for (const ContactRow& row : a.scratch.contact_rows)
      if (!joins) contacts[row.contact].rest = 0;
    a.in_group = joins && std::any_of(a.scratch.contact_rows.begin(), a.scratch.contact_rows.end(),
                                      [&](const ContactRow& row) {
                                        return !is_idle(world, contacts[row.contact]);
                                      });
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

/// After a second search in vain the next one waits, longer and longer.
void note_search(Island& first, Rest found) {
  if (found == Rest::missed) {
    first.misses = static_cast<std::uint8_t>(std::min(first.misses + 1, kMostMisses));
    first.waits = static_cast<std::uint8_t>((1 << (first.misses - 1)) - 1);
  } else if (first.waits > 0) {
    --first.waits;
  } else if (first.misses > 0) {
    --first.misses;
  }
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
                 std::span(r.laned).subspan(g.first_laned, g.laned),
                 std::span(r.batches).subspan(g.first_batch, g.batches),
                 g.lane_numbers,
                 std::span(r.resting).subspan(g.first_resting, g.resting),
                 std::span(r.rest_contacts).subspan(g.first_contact, g.contacts),
                 {std::span(r.rest_rows).subspan(g.first_resting, g.resting),
                  std::span(r.rest_columns).subspan(g.first_column, g.columns),
                  std::span(r.rest_marks).subspan(g.first_mark, g.marks)},
                 std::span(r.rest_links).subspan(g.first_link, g.links),
                 g.pressed,
                 g.waits,
                 world.time,
                 {}};
  };
  weigh_groups(world, r, task.budget);
  r.rests.resize(r.groups.size());
  const auto step_one = [&](std::size_t i, Group g) {
    Pace pace = pace_of(r, i, task, g.threads.are_many() ? 1 : task.threads.count);
    if (task.budget && !g.trees.empty()) g.pressed = false;  // sweeps take a known time
    const Clock::time_point from = task.budget ? Clock::now() : Clock::time_point{};
    r.rests[i] = step_group(g, h, pace);
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
  for (std::size_t i = 0; i < r.groups.size(); ++i) {
    const Group g = group(r.groups[i]);
    note_search(islands_of(world)[g.bodies.front().island], r.rests[i]);
    write_group(world, g, h);
  }
  for (const GroupScratch::Range& g : r.groups)
    for (const Group all = group(g); const GroupContact& c : all.contacts)
      write_contact(world, all, c, h);
  if (!r.groups.empty()) r.sets.reset(islands_of(world).size());
  for (const GroupScratch::Range& g : r.groups) let_sleep(world, group(g), h);
}

}  // namespace pantin::detail::articulated
