#include "engine/contact/detect.hpp"

#include <algorithm>
#include <optional>
#include <tuple>

#include "engine/base/invariants.hpp"
#include "engine/base/rotation.hpp"
#include "engine/contact/memory.hpp"
#include "engine/geometry/kinds.hpp"

namespace pantin::detail::contact {
namespace {

constexpr std::uint32_t kNone = UINT32_MAX;
// Margin in addition to the reach, so that rounding loses no contact.
constexpr Real kContactSlop = 1e-4;
// Part of its distance from the mass centre by which a contact point may move and count as the
// same.
constexpr Real kSamePoint = 0.15;
constexpr std::uint64_t kFeatures = (1ull << 44) - 1, kCore = kFeatures;

std::uint64_t pair_of(std::uint32_t a, std::uint32_t b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
}

/// Whether two bodies belong to solvers of their own: to the one that adjusts later, the other is
/// an obstacle that moves.
bool have_two_solvers(const Collider& a, const Collider& b) { return a.solver != b.solver; }

struct Finder {
  World& world;
  std::span<const Real> reach;
  Memory& memory;
  Search& scratch;
  const Partition& partition;
};

// ---- Colliders ---------------------------------------------------------------------------------

/// The solver and the island of a body.
void note_owner(const Partition& partition, Collider& c) {
  const Owner owner = owner_of(partition, c.slot);
  if (owner) c.solver = owner.solver, c.island = owner.island;
}

void add_shape(const Finder& s, std::uint32_t slot, const Shapes& shapes, std::uint32_t index) {
  const Shape& shape = shapes.list[index];
  const Body& body = s.world.bodies.values()[slot];
  const bool moves = feels_contacts(s.partition, slot);
  if (moves && !is_convex(shape.kind)) return;
  if (!is_complete(shape)) return;
  ColliderShape shape_at{compose(body.pose, shape.local), {}, 0, slot, index, &shape};
  if (!is_finite(shape_at.pose)) return;  // diverged bodies are reported elsewhere
  const auto number = static_cast<std::uint32_t>(s.scratch.shapes.size());
  if (traits_of(shape.kind).shape_class == ShapeClass::half_space) {
    s.scratch.unbounded.push_back(number);
  } else {
    shape_at.box = bounds_of(shape, shape_at.pose);
    shape_at.extent = glm::length(shape_at.box.high - shape_at.box.low) / 2;
    // A height field is unbounded below: bodies under it are pushed up.
    if (is_unbounded(shape.kind)) {
      s.scratch.unbounded.push_back(number);
    } else if (!moves) {
      s.scratch.static_shapes.push_back(number);
      s.scratch.static_boxes.push_back(shape_at.box.grown(s.reach[slot]));
    }
  }
  s.scratch.shapes.push_back(shape_at);
}

void list_colliders(const Finder& s) {
  Search& scratch = s.scratch;
  scratch.shapes.clear(), scratch.colliders.clear(), scratch.static_shapes.clear(),
      scratch.unbounded.clear();
  scratch.moving.clear(), scratch.static_boxes.clear(), scratch.moving_boxes.clear();
  scratch.sensors = 0;
  const auto owners = s.world.bodies.owners();
  for (std::uint32_t slot = 0; slot < owners.size(); ++slot) {
    const Collision* collision = s.world.collisions.find(owners[slot]);
    const Shapes* shapes = collision ? s.world.shapes.find(owners[slot]) : nullptr;
    if (!shapes) continue;
    if (collision->sensor) {
      ++scratch.sensors;
      continue;
    }
    PANTIN_ASSERT(is_range(0, s.reach[slot]));
    Collider collider;
    collider.slot = slot, collider.first = static_cast<std::uint32_t>(scratch.shapes.size());
    collider.collision = collision;
    note_owner(s.partition, collider);
    for (std::uint32_t i = 0; i < shapes->list.size(); ++i) add_shape(s, slot, *shapes, i);
    collider.count = static_cast<std::uint32_t>(scratch.shapes.size()) - collider.first;
    if (collider.count == 0) continue;
    scratch.collider_at[slot] = static_cast<std::uint32_t>(scratch.colliders.size());
    if (feels_contacts(s.partition, slot)) {
      scratch.moving.push_back(scratch.collider_at[slot]);
      Aabb box;
      for (std::uint32_t p = 0; p < collider.count; ++p)
        box.add(scratch.shapes[collider.first + p].box);
      scratch.moving_boxes.push_back(box.grown(s.reach[slot]));
    }
    scratch.colliders.push_back(collider);
  }
}

// ---- Pairs -------------------------------------------------------------------------------------

bool may_collide(const Search& scratch, const Collider& a, const Collider& b) {
  return do_groups_agree(*a.collision, *b.collision) && !are_jointed(scratch, a.slot, b.slot);
}

bool asked_for(const Collider& a, const Collider& b) {
  if (have_two_solvers(a, b)) return true;
  const bool own = a.island == b.island;
  return own ? a.collision->self && b.collision->self : a.collision->others || b.collision->others;
}

/// Pairs of moving colliders with overlapping bounds (broad phase), the one whose contact it is
/// first.
void list_pairs(const Finder& s) {
  Search& scratch = s.scratch;
  scratch.pairs.clear();
  const auto at = [&](std::uint32_t collider) -> const Collider& {
    return scratch.colliders[collider];
  };
  const bool two_solvers = std::any_of(
      scratch.moving.begin(), scratch.moving.end(),
      [&](std::uint32_t c) { return have_two_solvers(at(c), at(scratch.moving.front())); });
  const auto asks = [&](std::uint32_t collider) {
    return two_solvers || at(collider).collision->others || at(collider).collision->self;
  };
  if (std::none_of(scratch.moving.begin(), scratch.moving.end(), asks)) return;
  update_tree(scratch.moving_tree, scratch.moving_boxes);
  for (std::uint32_t i = 0; i < scratch.moving.size(); ++i) {
    if (!asks(scratch.moving[i])) continue;
    const Collider& a = scratch.colliders[scratch.moving[i]];
    const Real slop = kContactSlop * scratch.shapes[a.first].extent;
    scratch.moving_tree.query(scratch.moving_boxes[i].grown(slop), [&](std::uint32_t j) {
      const Collider& b = scratch.colliders[scratch.moving[j]];
      // If both request it, the pair is reported once, by the lower index.
      if (i == j || (j < i && asks(scratch.moving[j]))) return;
      if (!asked_for(a, b) || !may_collide(scratch, a, b)) return;
      const bool a_first = a.solver == b.solver ? a.slot < b.slot : a.solver > b.solver;
      const std::uint64_t first = scratch.moving[a_first ? i : j];
      scratch.pairs.push_back(first << 32 | scratch.moving[a_first ? j : i]);
    });
  }
  std::sort(scratch.pairs.begin(), scratch.pairs.end());
  scratch.pairs.erase(std::unique(scratch.pairs.begin(), scratch.pairs.end()), scratch.pairs.end());
}

/// Ten bits for each of the two shapes, the rest for the feature.
std::uint64_t key_of(const ColliderShape& a, const ColliderShape& b, std::uint64_t feature) {
  constexpr std::uint64_t kShapes = 0x3ff;
  return (a.index & kShapes) << 54 | (b.index & kShapes) << 44 | (feature & kFeatures);
}

/// A body that may rotate far in one step moves its features away from their contact points. A ball
/// inside the body is independent of rotation and gets a contact of its own.
void add_core_contact(const Finder& s, const ColliderShape& a, const ColliderShape& b) {
  Search& scratch = s.scratch;
  if (scratch.points.empty() || s.reach[a.slot] < a.extent || traits_of(a.shape->kind).is_round)
    return;
  const Real radius = inner_radius(*a.shape);
  if (!(radius > 0)) return;
  ContactPoint core =
      *std::min_element(scratch.points.begin(), scratch.points.end(),
                        [](const ContactPoint& p, const ContactPoint& q) { return p.gap < q.gap; });
  core.on_a = a.pose.position, core.on_b += radius * core.normal;
  core.gap = glm::dot(core.normal, core.on_a - core.on_b);
  core.feature = kCore;
  scratch.found.push_back({b.slot, key_of(a, b, core.feature),
                           scratch.colliders[scratch.collider_at[b.slot]].collision, core});
}

void collide_shapes(const Finder& s, const ColliderShape& a, const ColliderShape& b) {
  Search& scratch = s.scratch;
  const bool bounded = !is_unbounded(b.shape->kind);
  const Real extent = bounded ? glm::min(a.extent, b.extent) : a.extent;
  const Real margin = s.reach[a.slot] + s.reach[b.slot] + kContactSlop * extent;
  if (bounded && !a.box.grown(margin).overlaps(b.box)) return;
  scratch.points.clear();
  collide({*a.shape, a.pose}, {*b.shape, b.pose}, scratch.scratch, {margin, scratch.points});
  const Collision* other = scratch.colliders[scratch.collider_at[b.slot]].collision;
  for (const ContactPoint& p : scratch.points)
    scratch.found.push_back({b.slot, key_of(a, b, p.feature), other, p});
  const auto collider = [&](const ColliderShape& shape) -> const Collider& {
    return scratch.colliders[scratch.collider_at[shape.slot]];
  };
  if (have_two_solvers(collider(a), collider(b))) add_core_contact(s, a, b);
}

void collide_static(const Finder& s, const Collider& a) {
  Search& scratch = s.scratch;
  const auto try_shape = [&](const ColliderShape& shape_at, std::uint32_t number) {
    const ColliderShape& other = scratch.shapes[number];
    if (may_collide(scratch, a, scratch.colliders[scratch.collider_at[other.slot]]))
      collide_shapes(s, shape_at, other);
  };
  for (std::uint32_t p = a.first; p < a.first + a.count; ++p) {
    const ColliderShape& shape_at = scratch.shapes[p];
    for (std::uint32_t number : scratch.unbounded) try_shape(shape_at, number);
    scratch.static_tree.query(
        shape_at.box.grown(s.reach[a.slot] + kContactSlop * shape_at.extent),
        [&](std::uint32_t i) { try_shape(shape_at, scratch.static_shapes[i]); });
  }
}

void collide_moving(const Finder& s, const Collider& a, const Collider& b) {
  for (std::uint32_t p = a.first; p < a.first + a.count; ++p)
    for (std::uint32_t q = b.first; q < b.first + b.count; ++q)
      collide_shapes(s, s.scratch.shapes[p], s.scratch.shapes[q]);
}

// ---- Contacts ----------------------------------------------------------------------------------

auto order(const Contact& c) { return std::tie(c.slot_a, c.slot_b, c.key); }

/// What a contact had in the step before.
void take_over(Contact& c, const Contact& was) {
  c.lambda = was.lambda, c.sliding = was.sliding, c.impact = was.impact, c.rest = was.rest;
}

/// Contacts [from, end) of a body with another: those that no earlier one had the key of take over
/// from the nearest that is left, if that was soft. Corners and edges that clip each other change
/// their numbers while nothing moves.
void match_rest(const Finder& s, std::size_t from) {
  std::vector<Contact>& contacts = s.memory.contacts;
  std::vector<Contact>& before = s.memory.scratch.before;
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

/// Stores the points of one body as contacts with their warm start; `old` advances.
void store_contacts(const Finder& s, const Collider& a, std::size_t& old) {
  Search& scratch = s.scratch;
  std::vector<Contact>& contacts = s.memory.contacts;
  std::sort(scratch.found.begin(), scratch.found.end(),
            [](const FoundPoint& p, const FoundPoint& q) {
              return std::tie(p.slot_b, p.key, p.at.gap) < std::tie(q.slot_b, q.key, q.at.gap);
            });
  const auto bodies = s.world.bodies.values();
  const FoundPoint* last = nullptr;
  std::size_t first = contacts.size();  // with the same two bodies
  for (const FoundPoint& f : scratch.found) {
    if (last && last->slot_b == f.slot_b && last->key == f.key) continue;
    if (last && last->slot_b != f.slot_b) match_rest(s, first), first = contacts.size();
    last = &f;
    PANTIN_ASSERT(f.slot_b < bodies.size() && f.slot_b != a.slot && is_unit(f.at.normal));
    Contact c;
    c.slot_a = a.slot, c.slot_b = f.slot_b, c.key = f.key;
    c.point_a = to_local(bodies[a.slot].pose, f.at.on_a);
    c.point_b = to_local(bodies[f.slot_b].pose, f.at.on_b);
    c.normal = f.at.normal, c.gap = f.at.gap;
    c.friction = std::sqrt(a.collision->friction * f.other->friction);
    c.restitution = std::max(a.collision->restitution, f.other->restitution);
    while (old < s.memory.scratch.before.size() && order(s.memory.scratch.before[old]) < order(c))
      ++old;
    if (old < s.memory.scratch.before.size() && order(s.memory.scratch.before[old]) == order(c))
      take_over(c, s.memory.scratch.before[old]);
    contacts.push_back(c);
  }
  if (last) match_rest(s, first);
  scratch.found.clear();
}

}  // namespace

void list_jointed(const World& world, Search& search) {
  const std::uint64_t now = 1 + world.links.version() + world.bodies.version() + world.edit_count;
  if (search.jointed_for == now) return;
  search.jointed_for = now;
  search.jointed.clear();
  for (const Link& link : world.links.values()) {
    const std::uint32_t a = world.bodies.slot(link.a), b = world.bodies.slot(link.b);
    if (a != kNoSlot && b != kNoSlot) search.jointed.push_back(pair_of(a, b));
  }
  std::sort(search.jointed.begin(), search.jointed.end());
}

bool are_jointed(const Search& search, std::uint32_t a, std::uint32_t b) {
  return std::binary_search(search.jointed.begin(), search.jointed.end(), pair_of(a, b));
}

void update_tree(AabbTree& tree, std::span<const Aabb> boxes) {
  if (tree.size() != boxes.size()) return tree.build(boxes);
  tree.refit(boxes);
  if (tree.looseness() > 1.5) tree.build(boxes);
}

void find_contacts(World& world, std::span<const Real> reach) {
  Memory& memory = world.memory.of<Memory>();
  if (world.collisions.empty()) {
    memory.contacts.clear();
    memory.scratch.search.sensors = 0;
    return;
  }
  PANTIN_ASSERT(reach.size() >= world.bodies.size());
  Search& scratch = memory.scratch.search;
  const Finder s{world, reach, memory, scratch, partition_of(world)};
  std::swap(memory.scratch.before, memory.contacts);
  memory.contacts.clear();
  list_jointed(world, scratch);
  scratch.collider_at.assign(world.bodies.size(), kNone);
  list_colliders(s);
  if (scratch.moving.empty()) return;
  update_tree(scratch.static_tree, scratch.static_boxes);
  list_pairs(s);
  std::size_t old = 0, pair = 0;
  for (std::uint32_t number : scratch.moving) {
    const Collider& a = scratch.colliders[number];
    collide_static(s, a);
    for (; pair < scratch.pairs.size() && scratch.pairs[pair] >> 32 == number; ++pair)
      collide_moving(s, a, scratch.colliders[scratch.pairs[pair] & 0xffffffff]);
    store_contacts(s, a, old);
  }
}

Real rounding_at(const World& world, std::uint32_t slot, std::uint64_t shape) {
  const Shapes* shapes = world.shapes.find(world.bodies.owners()[slot]);
  if (!shapes || shape >= shapes->list.size()) return 0;
  const Shape& s = shapes->list[shape];
  const auto rounded = traits_of(s.kind).rounded;
  const std::optional<RoundedBox> core = rounded ? rounded(s) : std::nullopt;
  return core ? core->radius : 0;
}

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
/// and their reach is the displacement over the step. So do those that a solver has moved.
void detect(World& world, Real h) {
  PANTIN_ASSERT(is_positive(h));
  DetectScratch& scratch = world.memory.of<Memory>().scratch;
  const Partition& partition = partition_of(world);
  scratch.ends.clear();
  for (std::uint32_t slot : partition.kinematic) {
    Body& b = world.bodies.values()[slot];
    if (!moves(b)) continue;
    scratch.ends.push_back(b.pose);
    b.pose = pose_before(b, h);
    const Shapes* shapes = world.shapes.find(world.bodies.owners()[slot]);
    const Real extent = shapes ? extent_of(*shapes) : 0;
    scratch.reach[slot] = h * (glm::length(b.velocity) + extent * glm::length(b.angular_velocity));
  }
  const auto swap_starts = [&] {
    for (StartPose& start : scratch.starts)
      std::swap(world.bodies.values()[start.slot].pose, start.pose);
  };
  swap_starts();
  find_contacts(world, scratch.reach);
  swap_starts();
  auto end = scratch.ends.begin();
  for (std::uint32_t slot : partition.kinematic)
    if (Body& b = world.bodies.values()[slot]; moves(b)) b.pose = *end++;
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

}  // namespace pantin
