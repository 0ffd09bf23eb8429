// Pairs of bodies that are near each other.
#include "engine/contact/near_pairs.hpp"

#include <span>
#include <tuple>
#include <utility>

#include "engine/base/invariants.hpp"
#include "engine/base/rotation.hpp"
#include "engine/contact/memory.hpp"
#include "engine/geometry/convex.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::contact {
namespace {

/// Cosine of the angle to the solid side; up to this a body approaches from the side.
constexpr Real kFromTheSide = 0.02;
/// Fraction of a body's height by which it may be below the top and still stand there.
constexpr Real kSunk = 0.05;

}  // namespace

void NearPairs::begin() {
  for (NearPair& p : list) p.seen = false;
}

NearPair& NearPairs::at(const ContactPair& pair, const ContactFilter* filter) {
  PANTIN_ASSERT(pair.a.index < pair.b.index);
  const auto key = [](const auto& p) { return std::tuple(p.a.index, p.b.index); };
  auto found = std::lower_bound(list.begin(), list.end(), pair,
                                [&](const auto& p, const auto& q) { return key(p) < key(q); });
  const bool is_known = found != list.end() && key(*found) == key(pair);
  if (!is_known) found = list.insert(found, NearPair{});
  if (!is_known || found->a != pair.a || found->b != pair.b) *found = {.a = pair.a, .b = pair.b};
  found->seen = true;
  if (filter && !found->asked) found->asked = true, found->refused = !(*filter)(pair);
  return *found;
}

bool has_near_pairs(const World& world, const ContactFilter* filter) {
  const auto collisions = world.collisions.values();
  return filter || std::any_of(collisions.begin(), collisions.end(),
                               [](const Collision& c) { return c.one_way != Vec3(0); });
}

Vec3 one_way(const World& world, Entity body) {
  const Collision* c = world.collisions.find(body);
  if (!c || c->one_way == Vec3(0)) return Vec3(0);
  const Vec3 way = world.origin_pose(body).rotation * glm::normalize(c->one_way);
  return is_finite(way) ? way : Vec3(0);
}

bool is_let_pass(const Approach& from) {
  if (std::abs(from.facing) > kFromTheSide) return from.facing < 0;
  PANTIN_ASSERT(is_range(from.low, from.high));
  return !(from.low > from.top - kSunk * (from.high - from.low));
}

namespace {

/// Rotation that maps a unit vector to y.
Quat to_y_from(Vec3 way) {
  const Vec3 across = glm::cross(way, Vec3(0, 1, 0));
  const Real sine = glm::length(across);
  if (sine < 1e-12) return way.y > 0 ? kIdentity : Quat(0, 1, 0, 0);
  return from_rotation_vector(std::atan2(sine, way.y) / sine * across);
}

/// Extent of a shape of a body along the direction that `to_y` maps to y, m.
Aabb extent_along(const World& world, std::uint32_t slot, std::uint64_t shape, const Quat& to_y) {
  const Entity e = world.bodies.owners()[slot];
  PANTIN_ASSERT(shape < world.shapes[e].list.size());
  const Shape& s = world.shapes[e].list[shape];
  const Pose at = compose(world.bodies.values()[slot].pose, s.local);
  return bounds_of(s, compose(Pose{Vec3(0), to_y}, at));
}

/// One of the two bodies at a contact point, and its outward normal there.
struct Side {
  std::uint32_t slot, shape;
  Vec3 outwards;
};

bool is_let_pass(const World& world, const Side& surface, Vec3 way, const Side& other) {
  if (way == Vec3(0)) return false;
  Approach from{.facing = glm::dot(surface.outwards, way)};
  if (std::abs(from.facing) <= kFromTheSide) {
    const Quat to_y = to_y_from(way);
    const Aabb body = extent_along(world, other.slot, other.shape, to_y);
    from.low = body.low.y, from.high = body.high.y;
    from.top = extent_along(world, surface.slot, surface.shape, to_y).high.y;
  }
  return contact::is_let_pass(from);
}

ContactPair pair_of(const World& world, const FoundPoint& f) {
  const auto owners = world.bodies.owners();
  ContactPair p{owners[f.slot_a], owners[f.slot_b], shape_of_a(f.key), shape_of_b(f.key),
                f.at.on_b,        f.at.normal,      f.at.gap};
  if (p.a.index < p.b.index) return p;
  std::swap(p.a, p.b), std::swap(p.shape_a, p.shape_b);
  p.point = f.at.on_a, p.normal = -p.normal;
  return p;
}

/// Whether two bodies collide, given their near points.
bool collide(const Finder& s, const Search& search, std::span<const std::uint32_t> points,
             const ContactFilter* filter) {
  PANTIN_ASSERT(!points.empty());
  const World& world = s.world;
  const auto at = [&](std::uint32_t i) -> const FoundPoint& { return search.found[i]; };
  const FoundPoint& nearest =
      at(*std::min_element(points.begin(), points.end(), [&](std::uint32_t i, std::uint32_t j) {
        return at(i).at.gap < at(j).at.gap;
      }));
  NearPair& pair = s.world.memory.of<Memory>().near.at(pair_of(world, nearest), filter);
  const auto owners = world.bodies.owners();
  const Vec3 way_a = one_way(world, owners[nearest.slot_a]),
             way_b = one_way(world, owners[nearest.slot_b]);
  const bool passes = std::any_of(points.begin(), points.end(), [&](std::uint32_t i) {
    const FoundPoint& f = at(i);
    const Side a{f.slot_a, shape_of_a(f.key), -f.at.normal},
        b{f.slot_b, shape_of_b(f.key), f.at.normal};
    return is_let_pass(world, a, way_a, b) || is_let_pass(world, b, way_b, a);
  });
  if (passes || nearest.at.gap > 0) pair.passes = passes;
  return pair.collides();
}

}  // namespace

void add_ignored(const World& world, std::span<const std::uint64_t> ignored, NearPairs& near) {
  const auto owners = world.bodies.owners();
  for (const std::uint64_t pair : ignored) {
    PANTIN_ASSERT((pair >> 32) < owners.size() && (pair & 0xffffffff) < owners.size());
    Entity a = owners[pair >> 32], b = owners[pair & 0xffffffff];
    if (one_way(world, a) == Vec3(0) && one_way(world, b) == Vec3(0)) continue;
    if (b.index < a.index) std::swap(a, b);
    near.at({a, b}, nullptr).passes = true;
  }
}

void drop_points(const Finder& s, Search& search, const ContactFilter* filter) {
  NearPairs& near = s.world.memory.of<Memory>().near;
  if (!has_near_pairs(s.world, filter)) return near.list.clear();
  near.begin();
  add_ignored(s.world, search.ignored, near);
  std::vector<std::uint32_t>& order = search.order;
  std::size_t kept = 0;
  for (std::size_t from = 0, to = 0; from < order.size(); from = to) {
    const FoundPoint& first = search.found[order[from]];
    while (to < order.size() && search.found[order[to]].slot_a == first.slot_a &&
           search.found[order[to]].slot_b == first.slot_b)
      ++to;
    if (!collide(s, search, std::span(order).subspan(from, to - from), filter)) continue;
    PANTIN_ASSERT(kept <= from);
    for (std::size_t i = from; i < to; ++i) order[kept++] = order[i];
  }
  order.resize(kept);
  near.end([&](const NearPair& p) {
    const std::uint32_t a = s.world.bodies.slot(p.a), b = s.world.bodies.slot(p.b);
    return a != kNoSlot && b != kNoSlot && s.rests(a) && s.rests(b);
  });
}

}  // namespace pantin::detail::contact
