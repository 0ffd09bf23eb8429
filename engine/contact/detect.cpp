#include "engine/contact/detect.hpp"

#include <algorithm>
#include <tuple>

#include "engine/base/check.hpp"
#include "engine/base/rotation.hpp"
#include "engine/contact/memory.hpp"
#include "engine/geometry/kinds.hpp"

namespace pantin::contact {
namespace {

constexpr std::uint32_t kNone = UINT32_MAX;
// Contacts may be this much farther off than the bodies can move, so that rounding loses none.
constexpr Real kSlop = 1e-4;
constexpr std::uint64_t kFeatures = (1ull << 44) - 1, kCore = kFeatures;

std::uint64_t pair_of(std::uint32_t a, std::uint32_t b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
}

struct Finder {
  World& world;
  std::span<const Real> reach;
  Memory& memory;
  Search& room;
  const Partition& partition;
};

// ---- What there is -----------------------------------------------------------------------------

/// A number for the island that moves a body, of all solvers; UINT64_MAX: nobody moves it.
std::uint64_t island_of(const Partition& partition, std::uint32_t slot) {
  const Owner owner = owner_of(partition, slot);
  return owner ? std::uint64_t(owner.solver) << 32 | owner.island : UINT64_MAX;
}

void list_jointed(const World& world, Search& room) {
  const std::uint64_t now = 1 + world.links.version() + world.bodies.version() + world.touched;
  if (room.jointed_for == now) return;
  room.jointed_for = now;
  room.jointed.clear();
  for (const Link& link : world.links.values()) {
    const std::uint32_t a = world.bodies.slot(link.a), b = world.bodies.slot(link.b);
    if (a != kNoSlot && b != kNoSlot) room.jointed.push_back(pair_of(a, b));
  }
  std::sort(room.jointed.begin(), room.jointed.end());
}

void add_part(const Finder& s, std::uint32_t slot, const Shapes& shapes, std::uint32_t index) {
  const Shape& shape = shapes.parts[index];
  const Body& body = s.world.bodies.values()[slot];
  const bool moves = feels_contacts(s.partition, slot);
  if (moves && !is_convex(shape.kind)) return;
  if (!is_complete(shape)) return;
  SolidPart part{compose(body.pose, shape.local), {}, 0, slot, index, &shape};
  if (!is_finite(part.pose)) return;  // lost bodies are reported elsewhere
  const auto number = static_cast<std::uint32_t>(s.room.parts.size());
  if (traits_of(shape.kind).shape_class == ShapeClass::half_space) {
    s.room.endless.push_back(number);
  } else {
    part.box = bounds_of(shape, part.pose);
    part.extent = glm::length(part.box.high - part.box.low) / 2;
    // Whatever is below a height field is to be pushed up.
    if (is_unbounded(shape.kind)) {
      s.room.endless.push_back(number);
    } else if (!moves) {
      s.room.still.push_back(number);
      s.room.still_boxes.push_back(part.box.grown(s.reach[slot]));
    }
  }
  s.room.parts.push_back(part);
}

void list_solids(const Finder& s) {
  Search& room = s.room;
  room.parts.clear(), room.solids.clear(), room.still.clear(), room.endless.clear();
  room.moving.clear(), room.still_boxes.clear(), room.moving_boxes.clear();
  const auto owners = s.world.bodies.owners();
  for (std::uint32_t slot = 0; slot < owners.size(); ++slot) {
    const Collision* collision = s.world.collisions.find(owners[slot]);
    const Shapes* shapes = collision ? s.world.shapes.find(owners[slot]) : nullptr;
    if (!shapes) continue;
    Solid solid{slot, static_cast<std::uint32_t>(room.parts.size()), 0,
                island_of(s.partition, slot), collision};
    for (std::uint32_t i = 0; i < shapes->parts.size(); ++i) add_part(s, slot, *shapes, i);
    solid.count = static_cast<std::uint32_t>(room.parts.size()) - solid.first;
    if (solid.count == 0) continue;
    room.solid_at[slot] = static_cast<std::uint32_t>(room.solids.size());
    if (feels_contacts(s.partition, slot)) {
      room.moving.push_back(room.solid_at[slot]);
      Box box;
      for (std::uint32_t p = 0; p < solid.count; ++p) box.add(room.parts[solid.first + p].box);
      room.moving_boxes.push_back(box.grown(s.reach[slot]));
    }
    room.solids.push_back(solid);
  }
}

/// Brings a tree up to its boxes with no more work than they ask for.
void update(BoxTree& tree, std::span<const Box> boxes) {
  if (tree.size() != boxes.size()) return tree.build(boxes);
  tree.refit(boxes);
  if (tree.looseness() > 1.5) tree.build(boxes);
}

// ---- Pairs -------------------------------------------------------------------------------------

bool may_touch(const Search& room, const Solid& a, const Solid& b) {
  if (!(a.collision->groups & b.collision->with) || !(b.collision->groups & a.collision->with))
    return false;
  return !std::binary_search(room.jointed.begin(), room.jointed.end(), pair_of(a.slot, b.slot));
}

bool want_each_other(const Solid& a, const Solid& b) {
  const bool own = a.island == b.island && a.island != UINT64_MAX;
  return own ? a.collision->self && b.collision->self : a.collision->others || b.collision->others;
}

/// Pairs of moving solids whose boxes meet, by slots.
void list_pairs(const Finder& s) {
  Search& room = s.room;
  room.pairs.clear();
  const auto asks = [&](std::uint32_t solid) {
    return room.solids[solid].collision->others || room.solids[solid].collision->self;
  };
  if (std::none_of(room.moving.begin(), room.moving.end(), asks)) return;
  update(room.moving_tree, room.moving_boxes);
  for (std::uint32_t i = 0; i < room.moving.size(); ++i) {
    if (!asks(room.moving[i])) continue;
    const Solid& a = room.solids[room.moving[i]];
    const Real slop = kSlop * room.parts[a.first].extent;
    room.moving_tree.query(room.moving_boxes[i].grown(slop), [&](std::uint32_t j) {
      const Solid& b = room.solids[room.moving[j]];
      // Where both ask, the one in front is heard.
      if (i == j || (j < i && asks(room.moving[j]))) return;
      if (want_each_other(a, b) && may_touch(room, a, b))
        room.pairs.push_back(pair_of(room.moving[i], room.moving[j]));
    });
  }
  std::sort(room.pairs.begin(), room.pairs.end());
  room.pairs.erase(std::unique(room.pairs.begin(), room.pairs.end()), room.pairs.end());
}

/// Ten bits for each of the two shapes, the rest for the feature.
std::uint64_t key_of(const SolidPart& a, const SolidPart& b, std::uint64_t feature) {
  constexpr std::uint64_t kShapes = 0x3ff;
  return (a.index & kShapes) << 54 | (b.index & kShapes) << 44 | (feature & kFeatures);
}

/// A body that may turn or come far in one step turns its corners away from where they were found:
/// what does not turn, a ball within it, stays in front of the nearest point as well.
void keep_core(const Finder& s, const SolidPart& a, const SolidPart& b) {
  Search& room = s.room;
  if (room.points.empty() || s.reach[a.slot] < a.extent || traits_of(a.shape->kind).is_round)
    return;
  const Real radius = inner_radius(*a.shape);
  if (!(radius > 0)) return;
  TouchPoint core = *std::min_element(
      room.points.begin(), room.points.end(),
      [](const TouchPoint& p, const TouchPoint& q) { return p.gap < q.gap; });
  core.on_a = a.pose.position, core.on_b += radius * core.normal;
  core.gap = glm::dot(core.normal, core.on_a - core.on_b);
  core.feature = kCore;
  room.found.push_back({b.slot, key_of(a, b, core.feature),
                        room.solids[room.solid_at[b.slot]].collision, core});
}

void touch_parts(const Finder& s, const SolidPart& a, const SolidPart& b) {
  Search& room = s.room;
  const bool bounded = !is_unbounded(b.shape->kind);
  const Real extent = bounded ? glm::min(a.extent, b.extent) : a.extent;
  const Real margin = s.reach[a.slot] + s.reach[b.slot] + kSlop * extent;
  if (bounded && !a.box.grown(margin).overlaps(b.box)) return;
  room.points.clear();
  touch(*a.shape, a.pose, *b.shape, b.pose, margin, room.room, room.points);
  const Collision* other = room.solids[room.solid_at[b.slot]].collision;
  for (const TouchPoint& p : room.points)
    room.found.push_back({b.slot, key_of(a, b, p.feature), other, p});
  if (!feels_contacts(s.partition, b.slot))
    keep_core(s, a, b);
}

void touch_still(const Finder& s, const Solid& a) {
  Search& room = s.room;
  const auto try_part = [&](const SolidPart& part, std::uint32_t number) {
    const SolidPart& other = room.parts[number];
    if (may_touch(room, a, room.solids[room.solid_at[other.slot]])) touch_parts(s, part, other);
  };
  for (std::uint32_t p = a.first; p < a.first + a.count; ++p) {
    const SolidPart& part = room.parts[p];
    for (std::uint32_t number : room.endless) try_part(part, number);
    room.still_tree.query(part.box.grown(s.reach[a.slot] + kSlop * part.extent),
                          [&](std::uint32_t i) { try_part(part, room.still[i]); });
  }
}

void touch_moving(const Finder& s, const Solid& a, const Solid& b) {
  for (std::uint32_t p = a.first; p < a.first + a.count; ++p)
    for (std::uint32_t q = b.first; q < b.first + b.count; ++q)
      touch_parts(s, s.room.parts[p], s.room.parts[q]);
}

// ---- Contacts ----------------------------------------------------------------------------------

auto order(const Contact& c) { return std::tie(c.slot_a, c.slot_b, c.key); }

/// Turns what was found for one body into contacts, with what they bore; `old` moves on.
void take_down(const Finder& s, const Solid& a, std::size_t& old) {
  Search& room = s.room;
  std::sort(room.found.begin(), room.found.end(), [](const FoundPoint& p, const FoundPoint& q) {
    return std::tie(p.slot_b, p.key, p.at.gap) < std::tie(q.slot_b, q.key, q.at.gap);
  });
  const auto bodies = s.world.bodies.values();
  const FoundPoint* last = nullptr;
  for (const FoundPoint& f : room.found) {
    if (last && last->slot_b == f.slot_b && last->key == f.key) continue;
    last = &f;
    Contact c;
    c.slot_a = a.slot, c.slot_b = f.slot_b, c.key = f.key;
    c.point_a = to_local(bodies[a.slot].pose, f.at.on_a);
    c.point_b = to_local(bodies[f.slot_b].pose, f.at.on_b);
    c.normal = f.at.normal, c.gap = f.at.gap;
    c.friction = std::sqrt(a.collision->friction * f.other->friction);
    c.restitution = std::max(a.collision->restitution, f.other->restitution);
    while (old < s.memory.scratch.before.size() && order(s.memory.scratch.before[old]) < order(c)) ++old;
    if (old < s.memory.scratch.before.size() && order(s.memory.scratch.before[old]) == order(c)) {
      const Contact& was = s.memory.scratch.before[old];
      c.load = was.load, c.sliding = was.sliding, c.impact = was.impact;
    }
    s.memory.contacts.push_back(c);
  }
  room.found.clear();
}

}  // namespace

void find_contacts(World& world, std::span<const Real> reach) {
  Memory& memory = world.memory.of<Memory>();
  if (world.collisions.empty()) {
    memory.contacts.clear();
    return;
  }
  PANTIN_ASSERT(reach.size() >= world.bodies.size());
  Search& room = memory.scratch.search;
  const Finder s{world, reach, memory, room, partition_of(world)};
  std::swap(memory.scratch.before, memory.contacts);
  memory.contacts.clear();
  list_jointed(world, room);
  room.solid_at.assign(world.bodies.size(), kNone);
  list_solids(s);
  if (room.moving.empty()) return;
  update(room.still_tree, room.still_boxes);
  list_pairs(s);
  std::size_t old = 0, pair = 0;
  for (std::uint32_t number : room.moving) {
    const Solid& a = room.solids[number];
    touch_still(s, a);
    for (; pair < room.pairs.size() && room.pairs[pair] >> 32 == number; ++pair)
      touch_moving(s, a, room.solids[room.pairs[pair] & 0xffffffff]);
    take_down(s, a, old);
  }
}

Real extent_of(const Shapes& shapes) {
  Real most = 0;
  for (const Shape& s : shapes.parts)
    most = std::max(most, pantin::reach_of(s) + glm::length(s.local.position));
  return most;
}

bool moves(const Body& b) {
  return b.motion != Motion::fixed && (b.velocity != Vec3(0) || b.spin != Vec3(0));
}

/// Kinematic bodies are at the end of the step already: they are put back for the search, and their
/// reach is the way they come.
void detect(World& world, Real h) {
  DetectScratch& scratch = world.memory.of<Memory>().scratch;
  const Partition& partition = partition_of(world);
  scratch.ends.clear();
  for (std::uint32_t slot : partition.kinematic) {
    Body& b = world.bodies.values()[slot];
    if (!moves(b)) continue;
    scratch.ends.push_back(b.pose);
    b.pose.position -= h * b.velocity;
    b.pose.rotation = glm::normalize(turn_by(-h * b.spin) * b.pose.rotation);
    const Shapes* shapes = world.shapes.find(world.bodies.owners()[slot]);
    const Real extent = shapes ? extent_of(*shapes) : 0;
    scratch.reach[slot] = h * (glm::length(b.velocity) + extent * glm::length(b.spin));
  }
  find_contacts(world, scratch.reach);
  auto end = scratch.ends.begin();
  for (std::uint32_t slot : partition.kinematic)
    if (Body& b = world.bodies.values()[slot]; moves(b)) b.pose = *end++;
}

}  // namespace pantin::contact

namespace pantin {

const std::vector<Contact>& contacts_of(const World& world) {
  return world.memory.of<contact::Memory>().contacts;
}
std::vector<Contact>& contacts_of(World& world) {
  return world.memory.of<contact::Memory>().contacts;
}

}  // namespace pantin
