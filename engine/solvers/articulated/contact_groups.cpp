// Which bodies and trees touch, and how they enter and leave their step (step_group.cpp).
#include <algorithm>
#include <optional>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr std::uint32_t kNone = UINT32_MAX;
/// Of that overlap: what is left to take up when bodies fall asleep.
constexpr Real kSettled = 5e-4;
/// Sleep conserves forces as they are: it waits until hardly anything moves, but not for ever (s).
constexpr Real kDead = 1e-3, kPatience = 8;
/// Overlaps up to this fraction of the size of a body are removed by translating it.
constexpr Real kShallow = 5e-3;

bool can_join(const Island& a) {
  return !a.unfit && a.finite && a.settings.solver == Solver::articulated && !a.follows &&
         a.pins.empty() && a.cables.empty();
}

/// One body without joints.
bool is_body(const Island& a) { return a.count() == 1 && a.parents[0] == kFree; }

Real radius_of(const World& world, std::uint32_t slot, std::uint64_t index) {
  const Shapes* shapes = world.shapes.find(world.bodies.owners()[slot]);
  if (!shapes || index >= shapes->list.size()) return 0;
  const Shape& s = shapes->list[index];
  const auto rounded = traits_of(s.kind).rounded;
  const std::optional<RoundedBox> core = rounded ? rounded(s) : std::nullopt;
  return core ? core->radius : 0;
}

}  // namespace

void plan_contact_groups(World& world, Real h) {
  Islands& all = world.memory.of<Islands>();
  GroupScratch& r = all.groups;
  std::vector<Contact>& contacts = contacts_of(world);
  const Partition& partition = partition_of(world);
  r.sets.reset(all.list.size()), r.group_of.resize(all.list.size());
  r.eligible.assign(all.list.size(), 1), r.awake.assign(all.list.size(), 0);
  const auto island_at = [&](std::uint32_t slot) { return owner_of(partition, slot).island; };
  for (const Contact& c : contacts) {
    if (!contact::feels_contacts(partition, c.slot_b)) continue;
    r.sets.join(island_at(c.slot_a), island_at(c.slot_b));
  }
  for (std::uint32_t i = 0; i < all.list.size(); ++i) {
    Island& a = all.list[i];
    a.in_group = false;
    const std::uint32_t group = r.sets.root(i);
    r.group_of[i] = group;
    if (!can_join(a)) r.eligible[group] = 0;
    if (!a.asleep) r.awake[group] = 1;
  }
  for (std::uint32_t i = 0; i < all.list.size(); ++i) {
    Island& a = all.list[i];
    const std::uint32_t group = r.group_of[i];
    const bool joins = r.eligible[group] != 0;
    // Who touches somebody awake is awake.
    if (a.asleep && (r.awake[group] != 0 || (a.mutual && !joins))) wake(world, a, h);
    for (const ContactRow& row : a.scratch.contact_rows)
      if (!joins) contacts[row.contact].rest = 0;
    if (!joins || a.scratch.contact_rows.empty()) continue;
    a.in_group = true, a.mutual = false;
  }
}

namespace {

GroupBody gather_body(const World& world, std::uint32_t slot, Real h) {
  const Body& b = world.bodies.values()[slot];
  GroupBody f;
  f.slot = slot;
  f.pose = b.pose, f.velocity = b.velocity, f.spin = b.angular_velocity;
  if (contact::feels_contacts(partition_of(world), slot)) return f;
  if (!contact::moves(b)) {
    f.velocity = f.spin = Vec3(0);
    return f;
  }
  f.pose = contact::pose_before(b, h);
  return f;
}

GroupBody gather_body(const World& world, const Island& a, std::size_t column) {
  GroupBody f = gather_body(world, a.slots[column], 0);
  const Real mass = a.constants.at(kMass, column);
  const Vec3 inertia = a.constants.vec(kInertia, column);
  f.per_mass = 1 / mass, f.per_inertia = Real(1) / inertia;
  f.drag = a.constants.at(kDrag, column);
  f.acceleration = a.constants.at(kGravityScale, column) * world.gravity;
  if (const Force* force = world.forces.find(a.bodies[column]))
    f.acceleration += force->force / mass, f.torque = force->torque;
  f.response = inverse_inertia(f, f.pose.rotation);
  const Mat3 r = glm::mat3_cast(f.pose.rotation);
  f.angular_momentum = r * (inertia * (glm::transpose(r) * f.spin));
  return f;
}

/// A joint of a tree, or its root.
GroupNode gather_node(const World& world, const Island& a, std::size_t column) {
  GroupNode n;
  n.column = static_cast<std::uint32_t>(column);
  n.mass = a.constants.at(kMass, column), n.inertia = a.constants.vec(kInertia, column);
  n.own_anchor = a.constants.vec(kOwnAnchor, column);
  n.parent_anchor = a.constants.vec(kParentAnchor, column);
  n.free_root = a.parents[column] == kFree;
  if (n.free_root || a.joints.empty() || !a.joints[column].stiff) return n;
  const PackedJoint& joint = a.joints[column];
  const JointMemory& memory = a.joint_memory[column];
  n.joint = &joint;
  n.is_limited = joint.joint.limits.any();
  n.has_spring = joint.joint.limits->soft_zone > 0;
  if (joint.drive != UINT32_MAX) {
    n.drive = &world.joint_drives.values()[joint.drive];
    n.drive_share = memory.torque_fraction, n.has_spring = true;
  }
  const Real per = a.last_step > 0 && !a.fresh ? 1 / (a.last_step * a.last_step) : 0;
  for (int s = 0; s < 4; ++s) n.limits[s].impulse = per * memory.lambdas[s];  // N m as yet
  return n;
}

/// The way of a tree's anchor.
void gather_anchor(const World& world, const Island& a, GroupTree& t, Real h) {
  const Tree& tree = a.trees[t.number];
  t.from = tree.target_before, t.to = tree.target;
  t.anchor_velocity = (t.to - t.from) / h;
  if (tree.held_body == kNoSlot) return;
  const Body& b = world.bodies.values()[tree.held_body];
  t.held_before = t.held_after = b.pose;
  if (b.teleport) {
    t.from = t.to, t.anchor_velocity = Vec3(0);
  } else if (contact::moves(b)) {
    t.held_before = contact::pose_before(b, h);
    t.held_spin = b.angular_velocity;
  }
}

/// All bodies of an island that something touches.
void gather_island(const World& world, GroupScratch& r, GroupScratch::Range& range,
                   std::uint32_t number, Real h) {
  const Island& a = islands_of(world)[number];
  const bool jointed = !is_body(a);
  const auto first = static_cast<std::uint32_t>(r.nodes.size() - range.first_node);
  for (std::size_t c = 0; c < a.count(); ++c) {
    const auto body = static_cast<std::uint32_t>(r.bodies.size() - range.first_body);
    r.index[a.slots[c]] = body;
    r.bodies.push_back(gather_body(world, a, c));
    r.bodies.back().island = number;
    if (!jointed) continue;
    GroupNode n = gather_node(world, a, c);
    n.body = body;
    if (a.parents[c] >= 0) {
      n.parent = first + static_cast<std::uint32_t>(a.parents[c]);
      n.depth = r.nodes[range.first_node + n.parent].depth + 1;
    }
    r.bodies.back().node = first + static_cast<std::uint32_t>(c);
    r.nodes.push_back(n);
  }
  for (std::uint32_t i = 0; jointed && i < a.trees.size(); ++i) {
    GroupTree t;
    t.first = first + a.trees[i].first, t.count = a.trees[i].count, t.island = number, t.number = i;
    t.first_body = r.nodes[range.first_node + t.first].body;
    if (a.parents[a.trees[i].first] == kHeld) gather_anchor(world, a, t, h);
    for (std::uint32_t k = t.first; k < t.first + t.count; ++k)
      r.nodes[range.first_node + k].tree =
          static_cast<std::uint32_t>(r.trees.size() - range.first_tree);
    r.trees.push_back(t);
  }
}

GroupContact gather_contact(const World& world, std::uint32_t number, const Island& island) {
  const Contact& c = contacts_of(world)[number];
  const Body &a = world.bodies.values()[c.slot_a], &b = world.bodies.values()[c.slot_b];
  GroupContact f;
  f.contact = number;
  f.axes[0] = c.normal;
  const Vec3 aside = std::abs(c.normal.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  f.axes[1] = glm::normalize(glm::cross(c.normal, aside));
  f.axes[2] = glm::cross(c.normal, f.axes[1]);
  // Round shapes are touched below their core, however they turn; corners turn with the body.
  f.radius_a = radius_of(world, c.slot_a, c.key >> 54 & 0x3ff);
  f.radius_b = radius_of(world, c.slot_b, c.key >> 44 & 0x3ff);
  f.core_a = c.point_a + f.radius_a * (glm::conjugate(a.pose.rotation) * c.normal);
  f.core_b = c.point_b - f.radius_b * (glm::conjugate(b.pose.rotation) * c.normal);
  f.friction = c.friction, f.restitution = c.restitution, f.rest = c.rest;
  f.shallow = kShallow * island.size;
  // From the multiplier to the mean force.
  const Real per =
      island.last_step > 0 && !island.fresh ? 1 / (island.last_step * island.last_step) : 0;
  const Vec3 force = per * c.lambda;
  f.impulse = {std::max(Real(0), glm::dot(force, f.axes[0])), glm::dot(force, f.axes[1]),
               glm::dot(force, f.axes[2])};
  if (!is_finite(f.impulse) || f.impulse.x == 0) f.impulse = Vec3(0);
  return f;
}

bool are_of_one_tree(const GroupScratch& r, const GroupScratch::Range& range,
                     const GroupContact& c) {
  const std::uint32_t a = r.bodies[range.first_body + c.a].node,
                      b = r.bodies[range.first_body + c.b].node;
  return a != kNoNode && b != kNoNode &&
         r.nodes[range.first_node + a].tree == r.nodes[range.first_node + b].tree;
}

/// Contacts by group, bodies of each group with the fixed ones that it touches.
void gather(const World& world, GroupScratch& r, Real h) {
  const Partition& partition = partition_of(world);
  const std::vector<Island>& list = islands_of(world);
  const std::vector<Contact>& contacts = contacts_of(world);
  r.order.clear(), r.groups.clear(), r.bodies.clear(), r.contacts.clear();
  r.nodes.clear(), r.trees.clear(), r.crosses.clear();
  const auto group_at = [&](std::uint32_t contact) {
    return r.group_of[owner_of(partition, contacts[contact].slot_a).island];
  };
  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    const Island& a = list[owner_of(partition, contacts[i].slot_a).island];
    if (a.in_group && !a.asleep) r.order.push_back(i);
  }
  std::sort(r.order.begin(), r.order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return std::pair(group_at(i), i) < std::pair(group_at(j), j);
  });
  r.index.resize(world.bodies.size());
  for (std::size_t from = 0; from < r.order.size();) {
    std::size_t to = from;
    while (to < r.order.size() && group_at(r.order[to]) == group_at(r.order[from])) ++to;
    GroupScratch::Range range;
    range.first_body = r.bodies.size(), range.first_contact = r.contacts.size();
    range.first_node = r.nodes.size(), range.first_tree = r.trees.size();
    range.first_cross = r.crosses.size();
    for (std::size_t i = from; i < to; ++i) {
      const Contact& c = contacts[r.order[i]];
      r.index[c.slot_a] = r.index[c.slot_b] = kNone;
    }
    for (const bool fixed : {false, true})  // free ones and trees first
      for (std::size_t i = from; i < to; ++i) {
        const Contact& c = contacts[r.order[i]];
        for (const std::uint32_t slot : {c.slot_a, c.slot_b}) {
          const Owner owner = owner_of(partition, slot);
          if (owner.feels_contacts == fixed || r.index[slot] != kNone) continue;
          if (!fixed) {
            gather_island(world, r, range, owner.island, h);
            continue;
          }
          r.index[slot] = static_cast<std::uint32_t>(r.bodies.size() - range.first_body);
          r.bodies.push_back(gather_body(world, slot, h));
        }
      }
    for (std::size_t i = from; i < to; ++i) {
      const Contact& c = contacts[r.order[i]];
      r.contacts.push_back(
          gather_contact(world, r.order[i], list[owner_of(partition, c.slot_a).island]));
      GroupContact& made = r.contacts.back();
      made.a = r.index[c.slot_a], made.b = r.index[c.slot_b];
      if (!are_of_one_tree(r, range, made)) continue;
      if (i > from && have_same_bodies(made, *(&made - 1))) {
        made.cross = (&made - 1)->cross;
        continue;
      }
      made.cross = static_cast<std::uint32_t>(r.crosses.size() - range.first_cross);
      r.crosses.emplace_back();
    }
    range.bodies = r.bodies.size() - range.first_body;
    range.contacts = r.contacts.size() - range.first_contact;
    range.nodes = r.nodes.size() - range.first_node;
    range.trees = r.trees.size() - range.first_tree;
    range.crosses = r.crosses.size() - range.first_cross;
    r.groups.push_back(range);
    from = to;
  }
}

/// A body of its island. False if it is lost.
bool write_body(World& world, Island& a, std::size_t column, const GroupBody& f) {
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

/// What passed through a joint, for reports and for other methods.
void write_joint(World& world, Island& a, const GroupNode& n, Real h) {
  if (n.free_root) return;
  a.memory.set(kLambda, n.column, h * n.reaction.force);
  if (!n.joint) return;
  JointMemory& memory = a.joint_memory[n.column];
  memory.torque_fraction = n.drive_share, memory.torque = n.reaction.torque / h;
  for (int s = 0; s < 4; ++s) memory.lambdas[s] = h * h * n.limits[s].impulse;
  a.stops_hit += std::any_of(std::begin(n.limits), std::end(n.limits),
                             [](const GroupLimit& l) { return l.impulse != 0; });
  if (!n.drive) return;
  JointDrive& drive = world.joint_drives.values()[a.joints[n.column].drive];
  drive.torque = n.drive_torque, drive.capped = n.drive_share < 1;
  a.drives_capped += drive.capped;
}

/// Bodies and joints of the group's islands, and what their next step starts from.
void write_group(World& world, const Group& g, Real h) {
  std::vector<Island>& list = islands_of(world);
  for (const GroupBody& f : g.bodies) {
    if (f.island == UINT32_MAX) continue;
    Island& a = list[f.island];
    const std::size_t column = f.node == kNoNode ? 0 : g.nodes[f.node].column;
    if (column == 0) {
      a.stops_hit = a.drives_capped = 0;
      a.limited = a.disturbed = false, a.in_contact = true, a.contact_active = false;
      a.force_share = 1, a.reserve = 0, a.sweeps_used = a.active_set_iterations_used = 0;
      for (Tree& t : a.trees) t.knows_angular_momentum = false;
    }
    if (!a.lost) write_body(world, a, column, f);
    if (f.node != kNoNode) write_joint(world, a, g.nodes[f.node], h);
    if (column + 1 < a.count() || a.lost) continue;
    remember_step(world, a, h);
    a.calm_steps = 0;  // the other rules have no history to go on
  }
}

void write_contact(World& world, const GroupContact& f, Real h) {
  Contact& c = contacts_of(world)[f.contact];
  c.lambda = h * h * to_world(f, f.impulse);
  c.force = to_world(f, f.passed) / h;
  c.active = f.passed.x > 0, c.impact = 0, c.sliding = 1, c.rest = f.rest;
  c.depth = std::max(Real(0), -f.gap);
}

/// Whether the springs of a group have taken up their loads.
bool is_settled(std::span<const GroupContact> contacts) {
  return std::all_of(contacts.begin(), contacts.end(), [](const GroupContact& c) {
    return c.settling <= kSettled * c.shallow;
  });
}

/// A group sleeps once all of it has been still for long enough.
void let_sleep(World& world, const Group& g, Real h) {
  std::vector<Island>& list = islands_of(world);
  for (const GroupContact& c : g.contacts) {
    if (!(c.passed.x > 0)) continue;
    list[g.a(c).island].contact_active = true;
    if (g.b(c).per_mass > 0) list[g.b(c).island].contact_active = true;
  }
  const bool settled = is_settled(g.contacts);
  bool still = true;
  for (const GroupBody& f : g.bodies) {
    if (f.per_mass == 0) {
      still = still && f.velocity == Vec3(0) && f.spin == Vec3(0);
      continue;
    }
    Island& a = list[f.island];
    const Real slow = a.settings.sleep_speed;
    const Real speed = glm::length(f.velocity), spin = glm::length(f.spin);
    const bool drives = f.node != kNoNode && g.nodes[f.node].drive;
    if (f.node == kNoNode || g.nodes[f.node].column == 0)
      a.quiet_time += h;  // unless one of its bodies moves
    if (!a.contact_active || drives || !(speed < slow && spin < 10 * slow)) a.quiet_time = 0;
    const bool dead = speed < kDead * slow && spin < 10 * kDead * slow;
    still = still && a.quiet_time > (dead && settled ? kTimeToSleep : kPatience);
  }
  for (const GroupTree& t : g.trees) still = still && t.from == t.to && t.held_spin == Vec3(0);
  if (!still) return;
  for (const GroupBody& f : g.bodies)
    if (f.per_mass > 0 && !list[f.island].asleep) fall_asleep(world, list[f.island]);
}

}  // namespace

void step_contact_groups(World& world, const StepTask& task) {
  GroupScratch& r = world.memory.of<Islands>().groups;
  gather(world, r, task.h);
  const Real h = task.h;
  const auto group = [&](const GroupScratch::Range& g) {
    return Group{std::span(r.bodies).subspan(g.first_body, g.bodies),
                 std::span(r.contacts).subspan(g.first_contact, g.contacts),
                 std::span(r.nodes).subspan(g.first_node, g.nodes),
                 std::span(r.trees).subspan(g.first_tree, g.trees),
                 std::span(r.crosses).subspan(g.first_cross, g.crosses),
                 world.time};
  };
  for_each_island(r.groups.size(), task.threads,
                  [&](std::size_t i) { step_group(group(r.groups[i]), h); });
  for (const GroupScratch::Range& g : r.groups) write_group(world, group(g), h);
  for (const GroupContact& c : r.contacts) write_contact(world, c, h);
  for (const GroupScratch::Range& g : r.groups) let_sleep(world, group(g), h);
}

}  // namespace pantin::detail::articulated
