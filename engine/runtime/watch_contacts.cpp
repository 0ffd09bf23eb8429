#include "engine/runtime/watch_contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/memory.hpp"
#include "engine/geometry/sweep.hpp"
#include "engine/geometry/usable.hpp"
#include "engine/world/joined.hpp"
#include "engine/world/partition.hpp"

namespace pantin::detail {
namespace {

/// Tolerated depth between bodies at rest: a fraction of the smaller body's size, and of its
/// thickness.
constexpr Real kDeep = 0.01, kDeepOfThickness = 0.05;
/// A body has passed through if it crossed more than this fraction of the other's core.
constexpr Real kThrough = 0.9;
/// Paths that bend by more than this fraction of the half thickness, because the other body
/// rotates, are skipped.
constexpr Real kStraight = 0.25;
/// s: how long a body at rest must be too deep. Slower than kSlow sqrt(g thickness) is at rest.
constexpr Real kAtRestFor = 0.5, kSlow = 0.02;
/// Of the thickness, and s. A moving body counts while it is deeper than kMostly, weighted by its
/// relative depth: for kMovingFor at a whole thickness, half as long at two. No impact lasts that
/// long. A body that starts inside another has kToComeOut longer to separate.
constexpr Real kMostly = 0.5, kMovingFor = 0.15, kToComeOut = 0.25;
/// Of the thickness: NURBS shapes that overlap by more have no nearest way out.
constexpr Real kNoWayOut = 0.3;
constexpr Real kTiny = 1e-9;  // m
/// Above this number of fast shapes, candidates are looked up in a tree.
constexpr std::size_t kFewFast = 8;

/// The core of a shape: the shape without a quarter of its thickness all around, or a ball in its
/// middle.
Shape core_of(const Shape& shape, Real half_thickness) {
  Shape core = shape;
  core.material = 0;
  const Real off = 0.5 * half_thickness;
  if (shape.kind == ShapeKind::capsule) core.size.x -= off;
  if (shape.kind == ShapeKind::box) core.size -= Vec3(off);
  if (shape.kind == ShapeKind::capsule || shape.kind == ShapeKind::box) return core;
  core.kind = ShapeKind::sphere, core.size = Vec3(off, 0, 0), core.surface = nullptr;
  return core;
}

/// m; of a shape without an inner radius: the smallest side of its bounding box.
Real thickness_of(const Shape& shape, Real half_thickness) {
  if (half_thickness > 0 || is_unbounded(shape.kind)) return 2 * half_thickness;
  const Aabb box = bounds_of(shape, Pose{});
  const Vec3 size = box.high - box.low;
  return std::min({size.x, size.y, size.z});
}

Real turn_between(Quat a, Quat b) { return glm::length(rotation_vector(b * glm::conjugate(a))); }

/// A shape of a body, or null: shapes may have been removed since they were listed.
const Shape* find_shape(const World& world, std::uint32_t slot, std::uint32_t number) {
  const Shapes* shapes = world.shapes.find(world.bodies.owners()[slot]);
  return shapes && number < shapes->list.size() ? &shapes->list[number] : nullptr;
}

/// Whether two bodies collide, and one belongs to a solver that resolves contacts.
bool collide(const World& world, std::uint32_t a, std::uint32_t b) {
  const Collision *on_a = world.collisions.find(world.bodies.owners()[a]),
                  *on_b = world.collisions.find(world.bodies.owners()[b]);
  if (!on_a || !on_b || on_a->sensor || on_b->sensor || !do_groups_agree(*on_a, *on_b))
    return false;
  const Partition& partition = partition_of(world);
  const Owner of_a = owner_of(partition, a), of_b = owner_of(partition, b);
  if (!of_a.feels_contacts && !of_b.feels_contacts) return false;
  if (!of_a || !of_b) return true;  // one of them is static
  const bool own = partition.island[a] == partition.island[b];
  return own ? on_a->self && on_b->self : on_a->others || on_b->others;
}

}  // namespace

void ContactWatch::compile(const World& world) {
  const std::size_t count = world.bodies.size();
  solids_.clear(), unbounded_.clear(), balls_.clear();
  first_.assign(count + 1, 0), rest_version_ = placed_for_ = slept_for_ = 0;
  thickness_.assign(count, 0), shallow_.assign(count, 0), rests_for_.assign(count, 0),
      depth_.assign(count, 0), overlaps_.assign(count, {0, 0, -kToComeOut});
  before_.assign(count, {});
  is_skin_.assign(count, 0);
  for (std::uint32_t slot = 0; slot < count; ++slot) {
    first_[slot + 1] = static_cast<std::uint32_t>(solids_.size());
    const Entity e = world.bodies.owners()[slot];
    const Collision* collision = world.collisions.find(e);
    const Shapes* shapes = world.shapes.find(e);
    if (!collision || collision->sensor || !shapes) continue;
    Real thinnest = 1e300;
    for (std::uint32_t i = 0; i < shapes->list.size(); ++i) {
      const Shape& shape = shapes->list[i];
      if (!is_usable(shape)) continue;
      is_skin_[slot] = is_skin_[slot] || shape.kind == ShapeKind::nurbs;
      const Real half = inner_radius(shape);
      if (is_unbounded(shape.kind))
        unbounded_.push_back(static_cast<std::uint32_t>(solids_.size()));
      solids_.push_back({slot, i, core_of(shape, half), half, reach_of(shape)});
      balls_.push_back(
          {shape.local.position, slot,
           is_unbounded(shape.kind) ? std::numeric_limits<Real>::infinity() : reach_of(shape)});
      if (const Real thick = thickness_of(shape, half); thick > 0)
        thinnest = std::min(thinnest, thick);
    }
    first_[slot + 1] = static_cast<std::uint32_t>(solids_.size());
    thickness_[slot] = thinnest < 1e300 ? thinnest : 0;
    shallow_[slot] =
        std::min(kDeep * 2 * contact::extent_of(*shapes), kDeepOfThickness * thickness_[slot]);
  }
  if (solids_.empty()) first_ = {};
  boxes_.resize(solids_.size()), fast_.reserve(solids_.size());
  list_joined(world, joined_);
  tree_ = {};
}

void ContactWatch::note(const World& world, std::uint32_t slot) {
  const Body& b = world.bodies.values()[slot];
  before_[slot] = {b.pose, b.velocity, b.angular_velocity, b.teleport};
}

void ContactWatch::begin_substep(const World& world) {
  if (solids_.empty()) return;
  const Partition& partition = partition_of(world);
  for (const auto* slots : {&partition.kinematic, &partition.awake})
    for (const std::uint32_t slot : *slots) note(world, slot);
}

void ContactWatch::note_start(const World& world) {
  const std::uint64_t version = partition_of(world).rest_version;
  if (std::exchange(rest_version_, version) == version || solids_.empty()) return;
  for (std::uint32_t slot = 0; slot < before_.size(); ++slot)
    if (world.bodies.values()[slot].motion == Motion::dynamic) note(world, slot);
}

bool ContactWatch::may_meet(const World& world, std::uint32_t a, std::uint32_t b) const {
  if (a == b || before_[a].leaps || before_[b].leaps) return false;
  return collide(world, a, b) && !are_joined(joined_, a, b);
}

/// Whether the core moved further than a quarter of its thickness.
bool ContactWatch::is_fast(const World& world, const Solid& s) const {
  if (!(s.half_thickness > 0)) return false;
  const Body& b = world.bodies.values()[s.slot];
  if (b.motion == Motion::fixed) return false;
  const Vec3 way = to_world(b.pose, s.core.local.position) -
                   to_world(before_[s.slot].pose, s.core.local.position);
  return glm::dot(way, way) > 0.25 * s.half_thickness * s.half_thickness;
}

void ContactWatch::place_box(const World& world, std::size_t i) {
  const Solid& s = solids_[i];
  const Body& b = world.bodies.values()[s.slot];
  const Shape* shape = find_shape(world, s.slot, s.shape);
  if (!shape || !is_usable(*shape) || !is_finite(b.pose) || is_unbounded(shape->kind)) {
    boxes_[i] = {Vec3(1e300), Vec3(1e300)};
    return;
  }
  boxes_[i] = bounds_of(*shape, compose(b.pose, shape->local));
  boxes_[i].add(bounds_of(*shape, compose(before_[s.slot].pose, shape->local)));
}

/// Boxes of bodies that sleep are unchanged.
void ContactWatch::place_boxes(const World& world) {
  const Partition& partition = partition_of(world);
  if (std::exchange(placed_for_, rest_version_) != rest_version_) {
    for (std::size_t i = 0; i < solids_.size(); ++i) place_box(world, i);
  } else {
    for (const auto* slots : {&partition.kinematic, &partition.awake})
      for (const std::uint32_t slot : *slots)
        for (std::uint32_t i = first_[slot]; i < first_[slot + 1]; ++i) place_box(world, i);
  }
  contact::update_tree(tree_, boxes_);
}

/// m: how far a convex shape moves along the polyline `way`, without rotating, until it hits
/// `other`.
std::optional<Real> way_to(const Shape& shape, Quat rotation, std::span<const Vec3> way,
                           const PlacedShape& other) {
  Real done = 0;
  for (std::size_t i = 0; i + 1 < way.size(); ++i) {
    const Real length = glm::length(way[i + 1] - way[i]);
    if (!(length > kTiny)) continue;
    const Pose from{way[i], rotation};
    const auto hit = sweep({shape, from}, other, (way[i + 1] - way[i]) / length, length);
    if (hit) return done + hit->distance;
    done += length;
  }
  return {};
}

/// m: the length of that path between the first and the last contact. None if there is no contact,
/// or the path starts or ends in contact.
std::optional<Real> way_within(const Shape& shape, Quat rotation, std::array<Vec3, 3> way,
                               const PlacedShape& other) {
  const Real length = glm::length(way[1] - way[0]) + glm::length(way[2] - way[1]);
  const std::optional<Real> in = way_to(shape, rotation, way, other);
  std::swap(way[0], way[2]);
  const std::optional<Real> out = in ? way_to(shape, rotation, way, other) : std::nullopt;
  if (!in || !out || *in <= 0 || *out <= 0) return {};
  return length - *in - *out;
}

/// Sweeps the core of `a` along its path relative to `b`, without rotating it, against the core of
/// `b`, or its shape if it has no core of that kind. Using the core excludes rotations that cut an
/// edge.
/// Returns the length of the path within `b`, m, or none if `a` did not pass through.
std::optional<Real> ContactWatch::passage(const World& world, const Solid& a, const Solid& b,
                                          Real h) const {
  const Body &on_a = world.bodies.values()[a.slot], &on_b = world.bodies.values()[b.slot];
  if (on_a.motion != Motion::dynamic && on_b.motion != Motion::dynamic) return {};
  const Shape* other = find_shape(world, b.slot, b.shape);
  if (!other) return {};
  const Before &a_before = before_[a.slot], &b_before = before_[b.slot];
  const Pose was = compose(a_before.pose, a.core.local);
  const Pose start = compose(on_b.pose, compose(inverse(b_before.pose), was)),
             end = compose(on_a.pose, a.core.local), at = compose(on_b.pose, other->local);
  if (!is_finite(end) || !is_finite(at)) return {};
  const Real turn = turn_between(b_before.pose.rotation, on_b.pose.rotation);
  const Real away = std::max(glm::length(end.position - on_b.pose.position),
                             glm::length(start.position - on_b.pose.position));
  if (turn * turn / 8 * away > kStraight * a.half_thickness) return {};
  Shape core = a.core;
  if (a.reach * turn_between(start.rotation, end.rotation) > a.half_thickness)
    core.kind = ShapeKind::sphere, core.size = Vec3(0.5 * a.half_thickness, 0, 0);
  const bool has_middle = b.half_thickness > 0 && b.core.kind == other->kind;
  const PlacedShape there{has_middle ? b.core : *other, at};
  const Vec3 middle = 0.5 * (start.position + end.position);
  std::array<Vec3, 3> way{start.position, middle, end.position};
  if (is_unbounded(other->kind) && contains(*other, to_local(at, end.position))) {
    const std::optional<Real> above = way_to(core, end.rotation, way, there);
    const Real length = glm::length(end.position - start.position);
    return above && *above > 0 ? std::optional(length - *above) : std::nullopt;
  }
  const std::optional<Real> within = way_within(core, end.rotation, way, there);
  if (!within || !(*within > kThrough * a.half_thickness)) return {};
  // A rotating body moves on an arc: a path bent by the velocities at both ends must pass through
  // as well.
  const Quat seen = on_b.pose.rotation * glm::conjugate(b_before.pose.rotation);
  const auto apart = [](const auto& body, const auto& from, Vec3 point) {
    return body.velocity - from.velocity +
           glm::cross(body.angular_velocity, point - body.pose.position) -
           glm::cross(from.angular_velocity, point - from.pose.position);
  };
  way[1] =
      middle +
      h / 8 * (seen * apart(a_before, b_before, was.position) - apart(on_a, on_b, end.position));
  const std::optional<Real> around = way_within(core, end.rotation, way, there);
  return around && *around > kThrough * a.half_thickness ? within : std::nullopt;
}

/// Whether the swept bounding spheres of two shapes overlap.
bool ContactWatch::may_pass(const World& world, std::size_t one, std::size_t two) const {
  Vec3 middle[2];
  Real room = 0;
  for (const std::size_t i : {one, two}) {
    const Ball& ball = balls_[i];
    const Vec3 now = to_world(world.bodies.values()[ball.slot].pose, ball.centre),
               before = to_world(before_[ball.slot].pose, ball.centre);
    middle[i == two] = 0.5 * (before + now), room += ball.radius + 0.5 * glm::length(now - before);
  }
  const Vec3 apart = middle[1] - middle[0];
  return !(glm::dot(apart, apart) > room * room);
}

/// Calls `meet(solid)` for the shapes that a fast one may have passed through.
template <class Meet>
void ContactWatch::each_near(const World& world, std::uint32_t fast, const Meet& meet) const {
  for (const std::uint32_t i : unbounded_) meet(i);
  if (fast_.size() > kFewFast) return tree_.query(boxes_[fast], meet);
  for (std::uint32_t i = 0; i < balls_.size(); ++i)
    if (i != fast && std::isfinite(balls_[i].radius) && may_pass(world, fast, i)) meet(i);
}

namespace {

/// Whether a body moves through a surface that is solid from the other side only.
bool lets_pass(const World& world, std::uint32_t surface, std::uint32_t slot) {
  const Vec3 way = contact::one_way(world, world.bodies.owners()[surface]);
  const auto bodies = world.bodies.values();
  return way != Vec3(0) && glm::dot(bodies[slot].velocity - bodies[surface].velocity, way) > 0;
}

}  // namespace

void ContactWatch::end_substep(const World& world, Real h, FindingList& found) {
  if (solids_.empty()) return;
  fast_.clear();
  const Partition& partition = partition_of(world);
  const auto list = [&](std::uint32_t slot) {
    for (std::uint32_t i = first_[slot]; i < first_[slot + 1]; ++i)
      if (!before_[slot].leaps && is_fast(world, solids_[i])) fast_.push_back(i);
  };
  for (const std::uint32_t slot : partition.kinematic)
    if (partition.island[slot] == Owner::kNone) list(slot);
  std::for_each(partition.awake.begin(), partition.awake.end(), list);
  if (fast_.size() > kFewFast) place_boxes(world);
  for (const std::uint32_t fast : fast_)
    each_near(world, fast, [&](std::uint32_t i) {
      const Solid &s = solids_[fast], &other = solids_[i];
      if (!may_meet(world, s.slot, other.slot) || lets_pass(world, s.slot, other.slot) ||
          lets_pass(world, other.slot, s.slot))
        return;
      const bool is_led = world.bodies.values()[s.slot].motion != Motion::dynamic;
      if (const std::optional<Real> way = passage(world, s, other, h))
        found.note(FindingKind::passed_through, world.bodies.owners()[is_led ? other.slot : s.slot],
                   *way);
    });
}

/// Whether the contact is deeper than is tolerated at rest.
bool ContactWatch::is_sunk(const Contact& c) const {
  const Real on_a = thickness_[c.slot_a], on_b = thickness_[c.slot_b];
  const bool a_is_smaller = on_b == 0 || on_a < on_b;
  return c.depth > shallow_[a_is_smaller ? c.slot_a : c.slot_b] && (a_is_smaller ? on_a : on_b) > 0;
}

/// Reports bodies that sleep too deep in others: once, when they fall asleep or are first checked.
void ContactWatch::tell_of_sleepers(const World& world, FindingList& found) {
  if (std::exchange(slept_for_, rest_version_) == rest_version_) return;
  for (const Contact& c : resting_contacts_of(world))
    if (is_sunk(c)) found.note(FindingKind::sunk, world.bodies.owners()[c.slot_a], c.depth);
}

void ContactWatch::end_step(const World& world, Real h, FindingList& found) {
  const std::vector<Contact>& contacts = contacts_of(world);
  if (thickness_.size() != world.bodies.size()) return;
  tell_of_sleepers(world, found);
  if (contacts.empty()) return;
  const std::vector<std::uint32_t>& awake = partition_of(world).awake;
  for (const std::uint32_t slot : awake)
    depth_[slot] = 0, overlaps_[slot].part = overlaps_[slot].depth = 0;
  const Real g = glm::length(world.gravity);
  for (const Contact& c : contacts) {
    const Body &a = world.bodies.values()[c.slot_a], &b = world.bodies.values()[c.slot_b];
    const Real on_a = thickness_[c.slot_a], on_b = thickness_[c.slot_b];
    const bool a_is_smaller = on_b == 0 || on_a < on_b;
    const Real thin = a_is_smaller ? on_a : on_b;
    if (!is_sunk(c)) continue;
    Overlap& m = overlaps_[c.slot_a];
    if (c.depth > m.part * thin) m.part = c.depth / thin, m.depth = c.depth;
    if (is_skin_[c.slot_a] && is_skin_[c.slot_b] && c.depth > kNoWayOut * thin && m.for_long >= 0)
      found.note(FindingKind::sunk, world.bodies.owners()[c.slot_a], c.depth);
    const auto speed_at = [](const Body& body, Vec3 point) {
      return body.velocity + glm::cross(body.angular_velocity, body.pose.rotation * point);
    };
    const Vec3 apart = speed_at(a, c.point_a) - speed_at(b, c.point_b);
    const Real slow = kSlow * std::sqrt(std::max(g, thin) * thin);
    if (glm::dot(apart, apart) < slow * slow)
      depth_[c.slot_a] = std::max(depth_[c.slot_a], c.depth);
  }
  for (const std::uint32_t i : awake) {
    rests_for_[i] = depth_[i] > 0 ? rests_for_[i] + h : 0;
    if (rests_for_[i] > kAtRestFor)
      found.note(FindingKind::sunk, world.bodies.owners()[i], depth_[i]);
    Overlap& m = overlaps_[i];
    m.for_long = m.part > kMostly ? m.for_long + h * m.part : 0;
    if (m.for_long > kMovingFor) found.note(FindingKind::sunk, world.bodies.owners()[i], m.depth);
  }
}

}  // namespace pantin::detail
