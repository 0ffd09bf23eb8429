// Lists the bodies that collide: those that solvers move, and their obstacles. Bodies at rest stay
// in a tree from step to step, so that sleeping bodies cost next to nothing.
#include <algorithm>
#include <utility>

#include "engine/base/invariants.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/memory.hpp"
#include "engine/contact/resting.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/geometry/usable.hpp"

namespace pantin::detail::contact {
namespace {

/// The tree of resting bodies is rebuilt when this many of them, or one in kPart, came or left.
constexpr std::size_t kFewChanges = 32, kPart = 4;
/// m: bodies that are farther away or larger are ignored, before their squares overflow.
constexpr Real kFarthest = 1e12;

/// Changes whenever the tree of resting bodies has to be rebuilt.
std::uint64_t versions_of(const World& world) {
  return 1 + world.edit_count + world.shapes.replaced() + world.collisions.replaced();
}

/// How many values were ever added to a store.
std::uint64_t additions(const auto& store) {
  return store.version() - store.removed() - store.replaced();
}

bool is_same(const Pose& a, const Pose& b) {
  return a.position == b.position && a.rotation == b.rotation;
}

/// Calls `take(shape)` for each shape of a body that can collide.
template <class Take>
void each_shape(const Finder& s, std::uint32_t slot, const Shapes& shapes, const Take& take) {
  const Body& body = s.world.bodies.values()[slot];
  for (std::uint32_t i = 0; i < shapes.list.size(); ++i) {
    const Shape& shape = shapes.list[i];
    if ((s.is_moved(slot) && !can_move(shape.kind)) || !is_usable(shape)) continue;
    ColliderShape at{compose(body.pose, shape.local), {}, 0, slot, i, &shape};
    if (bound_shape(at)) take(at);
  }
}

void add_obstacle(Obstacles& to, const ColliderShape& at, Real reach) {
  // A height field is unbounded below: bodies under it are pushed up.
  if (is_unbounded(at.shape->kind)) return to.unbounded.push_back(at);
  to.shapes.push_back(at), to.boxes.push_back(at.box.grown(reach));
}

const Shapes* shapes_at(const World& world, std::uint32_t slot, const Collision*& collision) {
  const Entity owner = world.bodies.owners()[slot];
  collision = world.collisions.find(owner);
  return collision ? world.shapes.find(owner) : nullptr;
}

void list_resting(const Finder& s, RestingColliders& r) {
  const std::size_t bodies = s.world.bodies.size();
  r.known.assign(bodies, 0), r.poses.resize(bodies);
  r.obstacles.clear();
  r.built_for = versions_of(s.world), r.count = r.lost = 0;
  r.collisions = additions(s.world.collisions), r.shapes = additions(s.world.shapes);
  for (std::uint32_t slot = 0; slot < bodies; ++slot) {
    if (!s.rests(slot)) continue;
    const Collision* collision = nullptr;
    const Shapes* shapes = shapes_at(s.world, slot, collision);
    if (shapes && collision->sensor) continue;
    r.known[slot] = 1, r.poses[slot] = s.world.bodies.values()[slot].pose, ++r.count;
    if (!shapes) continue;
    each_shape(s, slot, *shapes,
               [&](const ColliderShape& at) { add_obstacle(r.obstacles, at, 0); });
  }
  r.obstacles.tree.build(r.obstacles.boxes);
}

/// Removes bodies from the known ones that were added, got shapes or became solid since.
void note_added(const World& world, RestingColliders& r) {
  r.known.resize(world.bodies.size(), 0), r.poses.resize(world.bodies.size());
  const auto forget = [&](const auto& store, std::uint64_t& listed) {
    const std::uint64_t now = additions(store), added = now - std::exchange(listed, now);
    for (std::size_t i = store.size() - std::min<std::uint64_t>(added, store.size());
         i < store.size(); ++i) {
      const std::uint32_t slot = world.bodies.slot(store.owners()[i]);
      if (slot == kNoSlot || !r.known[slot]) continue;
      r.known[slot] = 0, ++r.lost;
    }
  };
  forget(world.collisions, r.collisions), forget(world.shapes, r.shapes);
}

void list_body(const Finder& s, Search& search, std::uint32_t slot) {
  const Collision* collision = nullptr;
  const Shapes* shapes = shapes_at(s.world, slot, collision);
  if (!shapes) return;
  if (collision->sensor) {
    ++search.sensors;
    return;
  }
  const Real reach = s.reach_of(slot);
  PANTIN_ASSERT(is_range(0, reach));
  if (!s.is_moved(slot))
    return each_shape(s, slot, *shapes,
                      [&](const ColliderShape& at) { add_obstacle(search.obstacles, at, reach); });
  Collider collider{slot, static_cast<std::uint32_t>(search.shapes.size()), 0, collision,
                    s.rests(slot)};
  Aabb box;
  each_shape(s, slot, *shapes,
             [&](const ColliderShape& at) { box.add(at.box), search.shapes.push_back(at); });
  collider.count = static_cast<std::uint32_t>(search.shapes.size()) - collider.first;
  if (collider.count == 0) return;
  search.colliders.push_back(collider), search.boxes.push_back(box.grown(reach));
}

/// Lists all bodies that are not known to rest. Returns how many of them rest.
std::size_t list_others(const Finder& s, Search& search) {
  RestingColliders& r = search.resting;
  search.shapes.clear(), search.colliders.clear(), search.boxes.clear();
  search.obstacles.clear(), search.sensors = 0;
  PANTIN_ASSERT(r.known.size() == s.world.bodies.size() && r.poses.size() == r.known.size());
  std::size_t unknown = 0;
  const auto bodies = s.world.bodies.values();
  for (std::uint32_t slot = 0; slot < bodies.size(); ++slot) {
    const bool rests = s.rests(slot);
    if (r.known[slot]) {
      if (rests && is_same(r.poses[slot], bodies[slot].pose)) continue;
      r.known[slot] = 0, ++r.lost;
    }
    const std::size_t sensors = search.sensors;
    list_body(s, search, slot);
    unknown += rests && search.sensors == sensors;
  }
  return unknown;
}

}  // namespace

bool bound_shape(ColliderShape& at) {
  PANTIN_ASSERT(at.shape);
  const Vec3 p = at.pose.position;
  if (!is_finite(at.pose) || !is_unit(at.pose) || !(glm::dot(p, p) < kFarthest * kFarthest))
    return false;
  if (traits_of(at.shape->kind).shape_class == ShapeClass::half_space) return true;
  at.box = bounds_of(*at.shape, at.pose);
  at.extent = glm::length(at.box.high - at.box.low) / 2;
  return at.extent < kFarthest || is_unbounded(at.shape->kind);
}

bool look_up(const World& world, const RestingColliders& resting, ColliderShape& at) {
  if (!resting.knows(at.slot)) return false;
  const Collision* collision = nullptr;
  const Shapes* shapes = shapes_at(world, at.slot, collision);
  if (!shapes || at.index >= shapes->list.size() || !is_usable(shapes->list[at.index]) ||
      collision->sensor)
    return false;
  at.shape = &shapes->list[at.index];
  return true;
}

Real Finder::reach_of(std::uint32_t slot) const { return std::max(Real(0), reach[slot]); }

bool Finder::is_moved(std::uint32_t slot) const { return feels_contacts(partition, slot); }

bool Finder::rests(std::uint32_t slot) const {
  PANTIN_ASSERT(slot < reach.size());
  if (is_moved(slot)) return keeps && reach[slot] < 0;
  if (reach[slot] > 0) return false;
  const Body& b = world.bodies.values()[slot];
  return !owner_of(partition, slot) && !moves(b) && !b.restart && !b.teleport;
}

void renumber_resting(const World& world, RestingColliders& r) {
  std::vector<std::uint8_t> known(world.bodies.size(), 0);
  std::vector<Pose> poses(world.bodies.size());
  for (std::uint32_t then = 0; then < r.known.size(); ++then) {
    const std::uint32_t slot = world.bodies.slot_now(then);
    if (slot != kNoSlot)
      known[slot] = r.known[then], poses[slot] = r.poses[then];
    else
      r.lost += r.known[then];
  }
  r.known = std::move(known), r.poses = std::move(poses);
  for (auto* shapes : {&r.obstacles.shapes, &r.obstacles.unbounded})
    for (ColliderShape& at : *shapes) at.slot = world.bodies.slot_now(at.slot);
}

void list_colliders(const Finder& s, Search& search) {
  RestingColliders& r = search.resting;
  if (r.built_for != versions_of(s.world))
    list_resting(s, r);
  else
    note_added(s.world, r);
  const std::size_t unknown = list_others(s, search);
  const std::size_t changes = kFewChanges + r.count / kPart;
  if (unknown > changes || r.lost > changes) {
    list_resting(s, r);
    list_others(s, search);
  }
  PANTIN_ASSERT(search.boxes.size() == search.colliders.size());
  PANTIN_ASSERT(search.obstacles.boxes.size() == search.obstacles.shapes.size());
  update_tree(search.obstacles.tree, search.obstacles.boxes);
}

}  // namespace pantin::detail::contact
