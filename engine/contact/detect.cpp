#include "engine/contact/detect.hpp"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include "engine/base/invariants.hpp"
#include "engine/base/rotation.hpp"
#include "engine/contact/memory.hpp"
#include "engine/contact/on_the_way.hpp"
#include "engine/contact/pairs.hpp"
#include "engine/contact/resting.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/geometry/usable.hpp"

namespace pantin::detail::contact {
namespace {

// Fraction of its distance from the mass centre by which a contact point may move and still count
// as the same.
constexpr Real kSamePoint = 0.15;
// Reach of a body at rest whose surface moves, m: it does not count as resting.
constexpr Real kRunningReach = 1e-12;
// Bodies or pairs of bodies that are worth a part of a thread's work.
constexpr std::size_t kLeastInPart = 16;

const Collision& collision_of(const SweptSearch& s, std::uint32_t slot) {
  return s.world.collisions[s.world.bodies.owners()[slot]];
}

Memory& memory_of(const SweptSearch& s) { return s.world.memory.of<Memory>(); }

// ---- Surfaces ----------------------------------------------------------------------------------

std::uint64_t materials_of(const MaterialPair* pair) { return body_pair(pair->a, pair->b); }

void list_material_pairs(const World& world, Search& search) {
  search.material_pairs.clear();
  for (const MaterialPair& pair : world.material_pairs) search.material_pairs.push_back(&pair);
  std::sort(search.material_pairs.begin(), search.material_pairs.end(),
            [](const MaterialPair* p, const MaterialPair* q) {
              return std::tuple(materials_of(p), p) < std::tuple(materials_of(q), q);
            });
}

/// The World's entry for two materials, or null.
const MaterialPair* find_pair(const Search& search, std::uint32_t a, std::uint32_t b) {
  if (search.material_pairs.empty()) return nullptr;
  const std::uint64_t both = body_pair(a, b);
  const auto at = std::lower_bound(
      search.material_pairs.begin(), search.material_pairs.end(), both,
      [](const MaterialPair* p, std::uint64_t key) { return materials_of(p) < key; });
  return at != search.material_pairs.end() && materials_of(*at) == both ? *at : nullptr;
}

/// Velocity of a body's surface relative to the body, m/s, world axes.
Vec3 surface_velocity(const World& world, std::uint32_t slot, const Collision& c) {
  if (c.surface_velocity == Vec3(0)) return Vec3(0);
  const Vec3 v = world.origin_pose(world.bodies.owners()[slot]).rotation * c.surface_velocity;
  return is_finite(v) ? v : Vec3(0);
}

/// Sets the friction, restitution and surface velocity of a contact.
void set_surface(const SweptSearch& s, Contact& c, const MaterialPair* given) {
  static const MaterialPair kNothingSaid;
  const Collision &a = collision_of(s, c.slot_a), &b = collision_of(s, c.slot_b);
  const MaterialPair& pair = given ? *given : kNothingSaid;
  c.friction = pair.friction.value_or(std::sqrt(a.friction * b.friction));
  c.restitution = pair.restitution.value_or(std::max(a.restitution, b.restitution));
  c.rolling = pair.rolling.value_or(std::max(a.rolling, b.rolling));
  c.spinning = pair.spinning.value_or(std::max(a.spinning, b.spinning));
  c.surface_velocity =
      surface_velocity(s.world, c.slot_a, a) - surface_velocity(s.world, c.slot_b, b);
}

/// A body that may rotate far in one step moves its features away from their contact points. A ball
/// inside the body is independent of rotation and gets a contact of its own. That contact has
/// friction as well, for it carries a part of the load.
void add_core_contact(const SweptSearch& s, PointSearch& at, const ColliderShape& a,
                      const ColliderShape& b) {
  if (at.points.empty() || s.reach_of(a.slot) < a.extent || traits_of(a.shape->kind).is_round)
    return;
  PANTIN_ASSERT(at.found.back().slot_a == a.slot && at.found.back().slot_b == b.slot);
  const Real radius = inner_radius(*a.shape);
  if (!(radius > 0)) return;
  ContactPoint core =
      *std::min_element(at.points.begin(), at.points.end(),
                        [](const ContactPoint& p, const ContactPoint& q) { return p.gap < q.gap; });
  core.on_a = a.pose.position - radius * core.normal;
  core.gap = glm::dot(core.normal, core.on_a - core.on_b);
  core.feature = kCore;
  at.found.push_back(
      {a.slot, b.slot, key_of(a.index, b.index, core.feature), at.found.back().pair, core});
}

void collide_shapes(const Swept& with, PointSearch& at, const ColliderShape& a,
                    const ColliderShape& b) {
  const SweptSearch& s = with.s;
  const Search& search = with.search;
  PANTIN_ASSERT(a.slot != b.slot && can_move(a.shape->kind));
  const bool bounded = !is_unbounded(b.shape->kind);
  const Real extent = bounded ? glm::min(a.extent, b.extent) : a.extent;
  const Real own = s.is_moved(b.slot) ? s.reach_of(a.slot) : s.reach_if_struck(a.slot);
  const Real margin = s.reach_between(search, a.slot, b.slot, own) + kContactSlop * extent;
  if (bounded && !a.box.grown(margin).overlaps(b.box)) return;
  at.points.clear();
  collide({*a.shape, a.pose}, {*b.shape, b.pose}, at.scratch, {margin, at.points});
  const MaterialPair* pair = find_pair(search, a.shape->material, b.shape->material);
  advance_to_impact(with, at, a, b);
  for (const ContactPoint& p : at.points)
    at.found.push_back({a.slot, b.slot, key_of(a.index, b.index, p.feature), pair, p});
  if (have_two_solvers(s, a.slot, b.slot)) add_core_contact(s, at, a, b);
}

/// Collides a shape of a body that a solver moves with obstacles that have no solver.
void collide_obstacles(const Swept& with, PointSearch& at, const ColliderShape& a) {
  const SweptSearch& s = with.s;
  const Search& search = with.search;
  const auto collide_with = [&](const ColliderShape& b) {
    if (s.rests(a.slot) && s.rests(b.slot)) return;
    if (may_collide(s, search, a.slot, b.slot)) collide_shapes(with, at, a, b);
  };
  for (const ColliderShape& b : search.obstacles.unbounded) collide_with(b);
  search.obstacles.tree.query(a.box.grown(s.reach_if_struck(a.slot) + kContactSlop * a.extent),
                              [&](std::uint32_t i) { collide_with(search.obstacles.shapes[i]); });
}

/// Collides a shape of a body that a solver moves with resting colliders.
void collide_resting(const Swept& with, PointSearch& at, const ColliderShape& a) {
  const SweptSearch& s = with.s;
  const Search& search = with.search;
  const Aabb near = a.box.grown(s.reach_if_struck(a.slot) + kContactSlop * a.extent);
  each_resting(s.world, search.resting, near, [&](const ColliderShape& b) {
    const bool both = s.is_moved(b.slot);
    if (both && !asked_for(s, a.slot, b.slot)) return;
    if (!may_collide(s, search, a.slot, b.slot)) return;
    const bool turned = both && is_first(s, b.slot, a.slot);
    collide_shapes(with, at, turned ? b : a, turned ? a : b);
  });
}

/// Collides a moving obstacle with sleeping bodies.
void strike_resting(const Swept& with, PointSearch& at, const ColliderShape& b) {
  const SweptSearch& s = with.s;
  const Search& search = with.search;
  if (s.rests(b.slot)) return;
  const bool bounded = !is_unbounded(b.shape->kind);
  const Aabb everywhere{Vec3(-1e300), Vec3(1e300)};
  const Aabb near = bounded ? b.box.grown(s.reach_of(b.slot)) : everywhere;
  each_resting(s.world, search.resting, near, [&](const ColliderShape& a) {
    if (s.is_moved(a.slot) && may_collide(s, search, a.slot, b.slot))
      collide_shapes(with, at, a, b);
  });
}

/// Calls `find(i, at)` for each i below `count` on the threads of the search, and appends what they
/// find in that order.
template <class Find>
void find_each(const SweptSearch& s, Search& search, std::size_t count, const Find& find) {
  const std::size_t needed = s.threads.are_many() ? kMostParts : 1;
  if (search.workers.size() < needed) search.workers.resize(needed);
  if (needed == 1) {
    PointSearch& at = search.workers.front();
    std::swap(at.found, search.found);  // they are appended where they stay
    for (std::size_t i = 0; i < count; ++i) find(i, at);
    std::swap(at.found, search.found);
    return;
  }
  const std::size_t parts = in_parts(s.threads, count, kLeastInPart, [&](const ListPart& part) {
    PointSearch& at = search.workers[part.number];
    at.found.clear();
    for (std::size_t i = part.begin; i < part.end; ++i) find(i, at);
  });
  for (const PointSearch& at : std::span(search.workers).first(parts))
    search.found.insert(search.found.end(), at.found.begin(), at.found.end());
}

void find_points(const SweptSearch& s, Search& search) {
  const Swept with{s, search};
  search.found.clear();
  find_each(s, search, search.colliders.size(), [&](std::size_t i, PointSearch& at) {
    const Collider& c = search.colliders[i];
    PANTIN_ASSERT(is_part(c.first, c.count, search.shapes.size()));
    for (std::uint32_t p = c.first; p < c.first + c.count; ++p) {
      collide_obstacles(with, at, search.shapes[p]);
      if (!c.rests) collide_resting(with, at, search.shapes[p]);
    }
  });
  find_each(s, search, 1, [&](std::size_t, PointSearch& at) {
    for (const ColliderShape& b : search.obstacles.unbounded) strike_resting(with, at, b);
    for (const ColliderShape& b : search.obstacles.shapes) strike_resting(with, at, b);
  });
  find_each(s, search, search.pairs.size(), [&](std::size_t i, PointSearch& at) {
    const std::uint64_t pair = search.pairs[i];
    PANTIN_ASSERT((pair >> 32) < search.colliders.size() &&
                  (pair & 0xffffffff) < search.colliders.size());
    const Collider &a = search.colliders[pair >> 32], &b = search.colliders[pair & 0xffffffff];
    for (std::uint32_t p = a.first; p < a.first + a.count; ++p)
      for (std::uint32_t q = b.first; q < b.first + b.count; ++q)
        collide_shapes(with, at, search.shapes[p], search.shapes[q]);
  });
  search.keys.clear();
  for (const FoundPoint& p : search.found)
    search.keys.push_back(
        {std::uint64_t(p.slot_a) << 32 | p.slot_b, static_cast<std::uint32_t>(search.keys.size())});
  std::sort(search.keys.begin(), search.keys.end(), [&](const PointKey& i, const PointKey& j) {
    if (i.bodies != j.bodies) return i.bodies < j.bodies;
    const FoundPoint &p = search.found[i.point], &q = search.found[j.point];
    return std::tie(p.key, p.at.gap, i.point) < std::tie(q.key, q.at.gap, j.point);
  });
  search.order.clear();
  for (const PointKey& key : search.keys) search.order.push_back(key.point);
}

// ---- Contacts ----------------------------------------------------------------------------------

auto order(const Contact& c) { return std::tie(c.slot_a, c.slot_b, c.key); }

/// Whether contacts are sorted and keys are unique.
[[maybe_unused]] bool are_in_order(const std::vector<Contact>& contacts) {
  return std::adjacent_find(contacts.begin(), contacts.end(),
                            [](const Contact& c, const Contact& d) {
                              return !(order(c) < order(d));
                            }) == contacts.end();
}

/// Copies the warm start of a contact from the step before.
void take_over(Contact& c, const Contact& was) {
  c.lambda = was.lambda, c.rest = was.rest;
  c.torque_lambda = was.torque_lambda;
}

/// Contacts [from, end) of one pair of bodies: matches old soft contacts whose key has vanished to
/// the nearest new contact whose key is new. Corners and edges that clip each other change their
/// numbers while nothing moves.
void match_rest(Memory& memory, std::size_t from) {
  std::vector<Contact>& contacts = memory.contacts;
  PANTIN_ASSERT(from <= memory.contacts.size());
  std::vector<Contact>& before = memory.scratch.before;
  if (from == contacts.size()) return;
  const auto pair = [](const Contact& c) { return std::tie(c.slot_a, c.slot_b); };
  const auto old =
      std::equal_range(before.begin(), before.end(), contacts[from],
                       [&](const Contact& c, const Contact& d) { return pair(c) < pair(d); });
  if (old.first == old.second) return;
  const auto key_in = [](auto first, auto last, std::uint64_t key) {
    return std::any_of(first, last, [&](const Contact& c) { return c.key == key; });
  };
  const auto end = contacts.end();
  for (auto was = old.first; was != old.second; ++was) {
    if (!(was->rest > 0) || key_in(contacts.begin() + std::ptrdiff_t(from), end, was->key))
      continue;
    Contact* nearest = nullptr;
    Real least =
        kSamePoint * kSamePoint *
        std::max(glm::dot(was->point_a, was->point_a), glm::dot(was->point_b, was->point_b));
    for (auto c = contacts.begin() + std::ptrdiff_t(from); c != end; ++c) {
      if (c->lambda != Vec3(0) || key_in(old.first, old.second, c->key)) continue;
      const Vec3 way = c->point_a - was->point_a;
      if (const Real d = glm::dot(way, way); d < least) least = d, nearest = &*c;
    }
    if (nearest) take_over(*nearest, *was);
  }
}

Contact contact_of(const SweptSearch& s, const FoundPoint& f) {
  const auto bodies = s.world.bodies.values();
  PANTIN_ASSERT(f.slot_b < bodies.size() && f.slot_b != f.slot_a && is_unit(f.at.normal));
  Contact c;
  c.slot_a = f.slot_a, c.slot_b = f.slot_b, c.key = f.key;
  c.point_a = to_local(bodies[f.slot_a].pose, f.at.on_a);
  c.point_b = to_local(bodies[f.slot_b].pose, f.at.on_b);
  c.normal = f.at.normal, c.gap = f.at.gap;
  set_surface(s, c, f.pair);
  return c;
}

/// Stores the found points in Memory::contacts, in order, with the warm start of those they
/// continue.
void store_contacts(const SweptSearch& s, Search& search) {
  Memory& memory = memory_of(s);
  std::vector<Contact>& contacts = memory.contacts;
  const std::vector<Contact>& before = memory.scratch.before;
  std::size_t old = 0, first = 0;  // `first` of those with the same two bodies
  const FoundPoint* last = nullptr;
  for (const std::uint32_t i : search.order) {
    const FoundPoint& f = search.found[i];
    const bool same = last && last->slot_a == f.slot_a && last->slot_b == f.slot_b;
    if (same && last->key == f.key) continue;
    if (!same) match_rest(memory, first), first = contacts.size();
    last = &f;
    Contact c = contact_of(s, f);
    while (old < before.size() && order(before[old]) < order(c)) ++old;
    if (old < before.size() && order(before[old]) == order(c)) take_over(c, before[old]);
    contacts.push_back(c);
  }
  match_rest(memory, first);
  PANTIN_ASSERT(are_in_order(contacts));
}

}  // namespace

void list_joined(const World& world, Search& search) {
  const std::uint64_t now = 1 + joined_version(world);
  if (search.joined_for == now) return;
  search.joined_for = now;
  detail::list_joined(world, search.joined);
}

void update_tree(AabbTree& tree, std::span<const Aabb> boxes) {
  if (tree.size() != boxes.size()) return tree.build(boxes);
  tree.refit(boxes);
  if (tree.looseness() > 1.5) tree.build(boxes);
}

namespace {

/// Bounds the displacement of bodies that may strike a body: those that were near it in the last
/// step.
void find_strikers(std::span<const Contact> before, DetectScratch& scratch) {
  scratch.struck.assign(scratch.reach.size(), 0);
  const std::vector<Real>& reach = scratch.reach;
  for (const Contact& c : before) {
    PANTIN_ASSERT(c.slot_a < reach.size() && c.slot_b < reach.size());
    scratch.struck[c.slot_a] = std::max(scratch.struck[c.slot_a], reach[c.slot_b]);
    scratch.struck[c.slot_b] = std::max(scratch.struck[c.slot_b], reach[c.slot_a]);
  }
}

/// Finds the contacts of a step of h seconds; 0: at the current poses.
void search_contacts(World& world, std::span<const Real> reach, const SearchTask& task) {
  const Real h = task.h;
  Memory& memory = world.memory.of<Memory>();
  Search& search = memory.scratch.search;
  if (world.collisions.empty()) {
    memory.contacts.clear(), memory.resting.clear();
    search.sensors = 0;
    return;
  }
  PANTIN_ASSERT(reach.size() >= world.bodies.size());
  const std::span<const Real> struck(h > 0 ? memory.scratch.struck : std::span<const Real>());
  // A sleeping body may have got another shape or Collision.
  const std::uint64_t replaced = replacements(world);
  const bool keeps = std::exchange(memory.kept_for, replaced) == replaced;
  const SweptSearch s{{world, partition_of(world), reach, keeps, task.threads}, h, struck};
  std::swap(memory.scratch.before, memory.contacts);
  memory.contacts.clear();
  split_resting(s, memory);
  list_joined(world, search), detail::list_ignored(world, search.ignored);
  list_material_pairs(world, search);
  list_colliders(s, search);
  list_pairs(s, search);
  search.flights.of.clear();
  if (h > 0) find_flights(s, search, memory.scratch.displacement);
  find_points(s, search), drop_points(s, search, task.filter);
  store_contacts(s, search);
}

}  // namespace

void find_contacts(World& world, std::span<const Real> reach) { search_contacts(world, reach, {}); }

Real extent_of(const Shapes& shapes) {
  Real most = 0;
  for (const Shape& s : shapes.list)
    most = std::max(most, detail::reach_of(s) + glm::length(s.local.position));
  return most;
}

bool moves(const Body& b) {
  return b.motion != Motion::fixed && (b.velocity != Vec3(0) || b.angular_velocity != Vec3(0));
}

Pose pose_before(const Body& b, Real h) {
  return {b.pose.position - h * b.velocity,
          glm::normalize(from_rotation_vector(-h * b.angular_velocity) * b.pose.rotation)};
}

/// Kinematic bodies are at the end of the step already: for the search they return to its start,
/// and their reach is the displacement over the step. Bodies that a solver has moved return as
/// well.
void detect(World& world, const SearchTask& task) {
  const Real h = task.h;
  PANTIN_ASSERT(is_positive(h));
  DetectScratch& scratch = world.memory.of<Memory>().scratch;
  const Partition& partition = partition_of(world);
  PANTIN_ASSERT(scratch.reach.size() >= world.bodies.size());
  scratch.ends.clear();
  for (std::uint32_t slot : partition.kinematic) {
    Body& b = world.bodies.values()[slot];
    if (!moves(b)) continue;
    scratch.ends.push_back(b.pose);
    b.pose = pose_before(b, h);
    const Shapes* shapes = world.shapes.find(world.bodies.owners()[slot]);
    const Real extent = shapes ? extent_of(*shapes) : 0;
    scratch.reach[slot] = h * (glm::length(b.velocity) + extent * glm::length(b.angular_velocity));
    scratch.displacement[slot] = {h * b.velocity, h * b.angular_velocity};
  }
  find_strikers(contacts_of(world), scratch);
  for (std::size_t i = 0; i < world.collisions.size(); ++i) {
    if (world.collisions.values()[i].surface_velocity == Vec3(0)) continue;
    const std::uint32_t slot = world.bodies.slot(world.collisions.owners()[i]);
    if (slot == kNoSlot) continue;
    if (scratch.reach[slot] < 0) scratch.rest_version = 0;  // a sleeper's contacts may drive it now
    scratch.reach[slot] = std::max(scratch.reach[slot], kRunningReach);
  }
  const auto swap_starts = [&] {
    for (StartPose& start : scratch.starts)
      std::swap(world.bodies.values()[start.slot].pose, start.pose);
  };
  for ([[maybe_unused]] const StartPose& start : scratch.starts)
    PANTIN_ASSERT(start.slot < world.bodies.size() && owner_of(partition, start.slot));
  scratch.has_gravity.assign(world.bodies.size(), 0);
  for (const StartPose& start : scratch.starts) scratch.has_gravity[start.slot] = 1;
  swap_starts();
  search_contacts(world, scratch.reach, task);
  swap_starts();
  auto end = scratch.ends.begin();
  for (std::uint32_t slot : partition.kinematic)
    if (Body& b = world.bodies.values()[slot]; moves(b)) b.pose = *end++;
  PANTIN_ASSERT(end == scratch.ends.end());
}

}  // namespace pantin::detail::contact

namespace pantin {

using namespace detail;

const std::vector<Contact>& contacts_of(const World& world) {
  return world.memory.of<contact::Memory>().contacts;
}
std::vector<Contact>& contacts_of(World& world) {
  return world.memory.of<contact::Memory>().contacts;
}
const std::vector<Contact>& resting_contacts_of(const World& world) {
  return world.memory.of<contact::Memory>().resting;
}

}  // namespace pantin
