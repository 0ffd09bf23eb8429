// Gathers the bodies, trees, contacts and ties of each group for a step (step_group.cpp).
#include <algorithm>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/impulses/gather.hpp"
#include "engine/solvers/articulated/impulses/group_points.hpp"
#include "engine/solvers/articulated/impulses/meetings.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Overlaps up to this fraction of a body's size are removed by translation.
constexpr Real kShallow = 5e-3;
/// A joint that carries the impulses of more tie ends is cut.
constexpr std::uint32_t kMostEnds = 8;

/// One body without joints.
bool is_body(const Island& a) { return a.count() == 1 && a.parents[0] == kFree; }

GroupBody gather_body(const World& world, const Island& a, std::size_t column) {
  GroupBody f = gather_pose(world, a.slots[column], 0);
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
  PANTIN_ASSERT(column < a.count());
  n.mass = a.constants.at(kMass, column), n.inertia = a.constants.vec(kInertia, column);
  n.own_anchor = a.constants.vec(kOwnAnchor, column);
  n.parent_anchor = a.constants.vec(kParentAnchor, column);
  n.pulled = n.pulled_earlier = force_of_multiplier(a) * a.memory.vec(kLambda, column);
  if (a.parents[column] == kFree || a.joints.empty() || !a.joints[column].stiff) return n;
  const PackedJoint& joint = a.joints[column];
  const JointMemory& memory = a.joint_memory[column];
  n.joint = &joint;
  n.is_limited = joint.joint.limits.any();
  n.has_spring = joint.joint.limits->soft_zone > 0;
  if (joint.drive != UINT32_MAX) {
    n.drive = &world.joint_drives.values()[joint.drive];
    n.drive_share = memory.torque_fraction, n.has_spring = true;
  }
  n.is_driven = is_driven(world, a, column);
  if (is_actuated(joint))
    n.actuator.dof = &dof_of(world, a, column), n.actuator.angle = memory.angle;
  const Real per = force_of_multiplier(a);
  for (int s = 0; s < 4; ++s)  // N m as yet
    n.limits[s].impulse = n.limits[s].before = per * memory.lambdas[s];
  return n;
}

/// The motion of a tree's anchor over the step.
void gather_anchor(const World& world, const Island& a, GroupTree& t, Real h) {
  const Tree& tree = a.trees[t.number];
  PANTIN_ASSERT(t.number < a.trees.size() && a.parents[tree.first] == kHeld);
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

/// Whether a joint can be cut and replaced by a tie.
bool can_cut(const Island& a, std::size_t column) {
  return a.parents[column] >= 0 && (a.joints.empty() || !a.joints[column].stiff);
}

/// Marks the roots of trees, by column. In an island with many ties, joints that would carry the
/// impulses of more than kMostEnds ends are cut and become ties: so few ties are coupled.
void find_roots(GroupScratch& r, const Island& a) {
  r.ends.assign(a.count(), 0), r.roots.assign(a.count(), 0);
  for (const PackedPin& pin : a.pins) {
    if (!is_rigid(pin)) continue;
    ++r.ends[pin.column];
    if (pin.partner != kNone) ++r.ends[pin.partner];
  }
  for (std::size_t c = a.count(); c-- > 0;) {
    const bool cut = r.ends[c] > kMostEnds && can_cut(a, c);
    r.roots[c] = cut || a.parents[c] < 0;
    if (a.parents[c] >= 0) r.ends[static_cast<std::size_t>(a.parents[c])] += cut ? 1 : r.ends[c];
  }
}

/// The trees of an island. Leaves the index of each column's tree in r.roots, of its node in
/// r.ends.
void gather_trees(const World& world, GroupScratch& r, const GroupScratch::Range& range,
                  const IslandStep& of) {
  const Island& a = islands_of(world)[of.number];
  const std::size_t first_tree = r.trees.size();
  find_roots(r, a);
  std::uint32_t number = 0;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const std::int32_t parent = a.parents[c];
    if (r.roots[c] == 0) {
      PANTIN_ASSERT(parent >= 0 && static_cast<std::size_t>(parent) < c);
      r.roots[c] = r.roots[static_cast<std::size_t>(parent)];
      ++r.trees[range.first_tree + r.roots[c]].count;
      continue;
    }
    GroupTree t;
    t.count = 1, t.island = of.number, t.has_loops = has_rigid_ties(a);
    if (parent < 0) t.number = number++;
    if (parent == kHeld) gather_anchor(world, a, t, of.h);
    r.roots[c] = static_cast<std::uint32_t>(r.trees.size() - range.first_tree);
    r.trees.push_back(t);
  }
  auto first = static_cast<std::uint32_t>(r.nodes.size() - range.first_node);
  for (std::size_t i = first_tree; i < r.trees.size(); ++i) {
    r.trees[i].first = r.trees[i].at = first;
    first += r.trees[i].count;
  }
  for (std::size_t c = 0; c < a.count(); ++c)
    r.ends[c] = r.trees[range.first_tree + r.roots[c]].at++;
}

/// All bodies of an island in contact, with its trees.
void gather_island(const World& world, GroupScratch& r, const GroupScratch::Range& range,
                   const IslandStep& of) {
  const Island& a = islands_of(world)[of.number];
  const bool jointed = !is_body(a) || has_rigid_ties(a);
  if (jointed) {
    gather_trees(world, r, range, of);
    r.nodes.resize(r.nodes.size() + a.count());
  }
  for (std::size_t c = 0; c < a.count(); ++c) {
    const auto body = static_cast<std::uint32_t>(r.bodies.size() - range.first_body);
    r.index[a.slots[c]] = body;
    r.bodies.push_back(gather_body(world, a, c));
    r.bodies.back().island = of.number;
    if (!jointed) continue;
    GroupNode n = gather_node(world, a, c);
    n.body = body, n.tree = r.roots[c];
    n.free_root = r.ends[c] == r.trees[range.first_tree + n.tree].first && a.parents[c] != kHeld;
    if (a.parents[c] >= 0 && !n.free_root) {
      n.parent = r.ends[static_cast<std::size_t>(a.parents[c])];
      n.depth = r.nodes[range.first_node + n.parent].depth + 1;
    }
    r.bodies.back().node = r.ends[c];
    r.nodes[range.first_node + r.ends[c]] = n;
  }
}

const Island& island_of(const World& world, std::uint32_t slot) {
  return islands_of(world)[owner_of(partition_of(world), slot).island];
}

/// The shapes of a contact that moves over round NURBS faces; the ball inside a body stays in it.
void gather_skins(const World& world, const Contact& c, GroupScratch& r, GroupContact& made) {
  if (contact::is_core(c.key) || !is_of_rounds(c.key)) return;
  const auto shape = [&](std::uint32_t slot, std::uint32_t index) -> const Shape* {
    const Shapes* shapes = world.shapes.find(world.bodies.owners()[slot]);
    if (!shapes || index >= shapes->list.size()) return nullptr;
    const Shape& s = shapes->list[index];
    return s.kind == ShapeKind::nurbs && s.surface ? &s : nullptr;
  };
  const Shape* const a = shape(c.slot_a, contact::shape_of_a(c.key));
  const Shape* const b = shape(c.slot_b, contact::shape_of_b(c.key));
  if (!a || !b) return;
  made.skins = static_cast<std::uint32_t>(r.skins.size());
  r.skins.push_back({a, b, nearest_on(*a->surface, to_local(a->local, c.point_a)).at,
                     nearest_on(*b->surface, to_local(b->local, c.point_b)).at});
}

GroupContact gather_contact(const World& world, std::uint32_t number, const Island& island) {
  const Contact& c = contacts_of(world)[number];
  const Body &a = world.bodies.values()[c.slot_a], &b = world.bodies.values()[c.slot_b];
  GroupContact f;
  PANTIN_ASSERT(is_own(world, c.slot_a));
  f.contact = number;
  contact::set_axes(f.axes, c.normal);
  // Round shapes touch one radius below their core at any rotation; corners rotate with the body.
  using Side = contact::BodyOfContact::Side;
  f.on_a = contact::touched_place(world, c, {Side::a, a.pose.rotation});
  f.on_b = contact::touched_place(world, c, {Side::b, b.pose.rotation});
  f.gap = c.gap, f.friction = c.friction, f.restitution = c.restitution, f.rest = c.rest;
  f.lengths = contact::rolling_lengths(c);
  f.shallow = kShallow * island.size;
  f.surface_first = glm::dot(c.surface_velocity, f.axes[1]);
  f.surface_second = glm::dot(c.surface_velocity, f.axes[2]);
  f.impulse = contact::along_axes(f.axes, force_of_multiplier(island) * c.lambda);
  f.impulse.x = std::max(Real(0), f.impulse.x);
  if (!is_finite(f.impulse) || f.impulse.x == 0) f.impulse = Vec3(0);
  return f;
}

/// Rolling friction of one pair of bodies, whose contacts are f.first to f.first + f.count.
void gather_rolling(const World& world, GroupScratch& r, const GroupScratch::Range& range,
                    GroupRolling f) {
  const auto points = std::span(r.contacts).subspan(range.first_contact + f.first, f.count);
  const auto rolls = [](const GroupContact& c) { return c.lengths.any(); };
  if (std::none_of(points.begin(), points.end(), rolls)) return;
  Vec3 normal(0), torque(0);
  for (GroupContact& c : points) {
    c.rolling = static_cast<std::uint32_t>(r.rollings.size() - range.first_rolling);
    const Contact& contact = contacts_of(world)[c.contact];
    normal += c.axes[0];
    torque += force_of_multiplier(island_of(world, contact.slot_a)) * contact.torque_lambda;
  }
  contact::set_axes(f.axes, contact::shared_normal(normal, points.front().axes[0]));
  f.impulse = contact::along_axes(f.axes, torque);
  if (!is_finite(f.impulse)) f.impulse = Vec3(0);
  r.rollings.push_back(f);
}

/// Rolling friction of all contacts of the last group.
void gather_rollings(const World& world, GroupScratch& r, const GroupScratch::Range& range) {
  const auto contacts = std::span(r.contacts).subspan(range.first_contact);
  for (std::uint32_t from = 0, to = 0; from < contacts.size(); from = to) {
    while (to < contacts.size() && have_same_bodies(contacts[from], contacts[to])) ++to;
    GroupRolling f;
    f.first = from, f.count = to - from;
    gather_rolling(world, r, range, f);
  }
}

/// Divides the contacts of the last group into pairs; reserves their responses.
void gather_pairs(GroupScratch& r, const GroupScratch::Range& range) {
  const auto contacts = std::span(r.contacts).subspan(range.first_contact);
  for (std::uint32_t from = 0, to = 0; from < contacts.size(); from = to) {
    while (to < contacts.size() && to - from < kMostPoints &&
           have_same_bodies(contacts[from], contacts[to]))
      ++to;
    GroupPair p;
    p.first = from, p.count = to - from, p.responses = r.numbers - range.first_number;
    r.numbers += most_responses(3 * p.count + (contacts[from].rolling != kNoNode ? 3 : 0));
    r.pairs.push_back(p);
  }
}

/// Where the next group begins.
GroupScratch::Range next_range(const GroupScratch& r) {
  GroupScratch::Range range;
  range.first_body = r.bodies.size(), range.first_contact = r.contacts.size();
  range.first_node = r.nodes.size(), range.first_tree = r.trees.size();
  range.first_cross = r.crosses.size(), range.first_tie = r.ties.size();
  range.first_rolling = r.rollings.size(), range.first_loops = r.loops.size();
  range.first_looped = r.looped.size(), range.first_step = r.path_steps.size();
  range.first_number = r.numbers, range.first_resting = r.resting.size();
  range.first_pair = r.pairs.size(), range.first_link = r.rest_links.size();
  range.first_column = r.rest_columns.size(), range.first_mark = r.rest_marks.size();
  range.first_laned = r.laned.size(), range.first_batch = r.batches.size();
  return range;
}

void end_range(GroupScratch& r, GroupScratch::Range range) {
  range.bodies = r.bodies.size() - range.first_body;
  range.contacts = r.contacts.size() - range.first_contact;
  range.nodes = r.nodes.size() - range.first_node;
  range.trees = r.trees.size() - range.first_tree;
  range.crosses = r.crosses.size() - range.first_cross;
  range.ties = r.ties.size() - range.first_tie;
  range.rollings = r.rollings.size() - range.first_rolling;
  range.loops = r.loops.size() - range.first_loops;
  range.looped = r.looped.size() - range.first_looped;
  range.steps = r.path_steps.size() - range.first_step;
  range.numbers = r.numbers - range.first_number;
  range.resting = r.resting.size() - range.first_resting;
  range.pairs = r.pairs.size() - range.first_pair;
  range.links = r.rest_links.size() - range.first_link;
  range.columns = r.rest_columns.size() - range.first_column;
  range.marks = r.rest_marks.size() - range.first_mark;
  range.laned = r.laned.size() - range.first_laned;
  range.batches = r.batches.size() - range.first_batch;
  PANTIN_ASSERT(range.bodies > 1 && range.contacts > 0);
  r.groups.push_back(range);
}

}  // namespace

GroupBody gather_pose(const World& world, std::uint32_t slot, Real h) {
  const Body& b = world.bodies.values()[slot];
  GroupBody f;
  f.slot = slot;
  f.pose = b.pose, f.velocity = b.velocity, f.spin = b.angular_velocity;
  if (is_own(world, slot)) return f;
  if (!contact::moves(b)) {
    f.velocity = f.spin = Vec3(0);
    return f;
  }
  f.pose = contact::pose_before(b, h);
  return f;
}

void gather_groups(const World& world, GroupScratch& r, Real h) {
  const Partition& partition = partition_of(world);
  const IslandVector& list = islands_of(world);
  const std::vector<Contact>& contacts = contacts_of(world);
  r.order.clear(), r.keys.clear(), r.groups.clear(), r.bodies.clear(), r.contacts.clear();
  r.nodes.clear(), r.trees.clear(), r.crosses.clear(), r.ties.clear(), r.rollings.clear();
  r.skins.clear();
  r.loops.clear(), r.looped.clear(), r.path_steps.clear(), r.numbers = 0;
  r.resting.clear(), r.rest_rows.clear(), r.rest_links.clear(), r.pairs.clear();
  r.rest_columns.clear(), r.rest_marks.clear();
  r.laned.clear(), r.batches.clear();
  const auto group_at = [&](std::uint32_t contact) {
    return r.group_of[owner_of(partition, contacts[contact].slot_a).island];
  };
  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    if (!is_own(world, contacts[i].slot_a)) continue;
    const Island& a = list[owner_of(partition, contacts[i].slot_a).island];
    if (a.in_group && !a.asleep && !is_idle(world, contacts[i]))
      r.keys.push_back(std::uint64_t(group_at(i)) << 32 | i);
  }
  std::sort(r.keys.begin(), r.keys.end());
  for (const std::uint64_t key : r.keys) r.order.push_back(static_cast<std::uint32_t>(key));
  r.index.resize(world.bodies.size());
  for (std::size_t from = 0; from < r.order.size();) {
    std::size_t to = from;
    while (to < r.order.size() && group_at(r.order[to]) == group_at(r.order[from])) ++to;
    GroupScratch::Range range = next_range(r);
    for (std::size_t i = from; i < to; ++i) {
      const Contact& c = contacts[r.order[i]];
      r.index[c.slot_a] = r.index[c.slot_b] = kNone;
    }
    for (const bool fixed : {false, true})  // free bodies and trees first
      for (std::size_t i = from; i < to; ++i) {
        const Contact& c = contacts[r.order[i]];
        for (const std::uint32_t slot : {c.slot_a, c.slot_b}) {
          const Owner owner = owner_of(partition, slot);
          if (is_own(world, slot) == fixed || r.index[slot] != kNone) continue;
          if (!fixed) {
            gather_island(world, r, range, {owner.island, h});
            continue;
          }
          r.index[slot] = static_cast<std::uint32_t>(r.bodies.size() - range.first_body);
          r.bodies.push_back(gather_pose(world, slot, h));
        }
      }
    for (std::size_t i = from; i < to; ++i) {
      const Contact& c = contacts[r.order[i]];
      r.contacts.push_back(gather_contact(world, r.order[i], island_of(world, c.slot_a)));
      GroupContact& made = r.contacts.back();
      made.a = r.index[c.slot_a], made.b = r.index[c.slot_b];
      gather_skins(world, c, r, made);
      PANTIN_ASSERT(made.a != kNone && made.b != kNone && made.a != made.b);
      if (!are_coupled(r, range, {made.a, made.b})) continue;
      if (i > from && have_same_bodies(made, *(&made - 1))) {
        made.cross = (&made - 1)->cross;
        continue;
      }
      made.cross = static_cast<std::uint32_t>(r.crosses.size() - range.first_cross);
      r.crosses.emplace_back();
    }
    gather_rollings(world, r, range);
    const std::size_t dynamic = r.bodies.size();
    for (std::size_t k = range.first_body; k < dynamic; ++k) {
      const GroupBody& body = r.bodies[k];
      const bool first = body.island != UINT32_MAX && body.slot == list[body.island].slots[0];
      if (first) gather_ties(world, r, range, {body.island, h});
    }
    add_looped(r, range);
    range.waits = list[r.bodies[range.first_body].island].waits > 0;
    gather_resting(r, range, h);
    gather_pairs(r, range);
    gather_laned(r, range);
    end_range(r, range);
    from = to;
  }
  if (r.number_list.size() < r.numbers) r.number_list.resize(r.numbers);
  r.rest_contacts.resize(r.contacts.size());
}

}  // namespace pantin::detail::articulated
