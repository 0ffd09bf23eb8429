#include "engine/world/queries.hpp"

#include <algorithm>
#include <tuple>

#include "engine/base/invariants.hpp"
#include "engine/geometry/aabb_tree.hpp"
#include "engine/geometry/collide.hpp"
#include "engine/geometry/sweep.hpp"
#include "engine/geometry/usable.hpp"
#include "engine/world/world.hpp"

namespace pantin {

using namespace detail;

/// The shapes that queries test, and their bounding-volume tree.
struct detail::QueryIndex {
  /// One shape, placed.
  struct Item {
    Shape shape;
    Pose at;
    Entity body;
    std::uint32_t index = 0;
    std::uint32_t groups = UINT32_MAX, with = UINT32_MAX;
    bool is_solid = false;
  };

  std::vector<Item> items;
  std::vector<std::uint32_t> unbounded;  // items without a bounding box
  std::vector<std::uint32_t> bounded;    // items by bounding box
  std::vector<Aabb> boxes;
  AabbTree tree;
  std::size_t left_out = 0;
};

namespace {

using Item = QueryIndex::Item;

bool sees(const QueryFilter& filter, const Item& item) {
  if (filter.bodies == QueryBodies::solid && !item.is_solid) return false;
  if (filter.except && filter.except == item.body) return false;
  return (filter.groups & item.with) && (item.groups & filter.with);
}

/// A ray's entry into one shape: distance and normal, world axes.
std::optional<RayEntry> enter(const Shape& shape, const Pose& at, const Ray& ray,
                              const RayEntry& unit) {
  const Vec3 from = to_local(at, ray.origin), way = glm::conjugate(at.rotation) * unit.normal;
  if (ray.start_inside == StartInside::hit && contains(shape, from)) {
    const auto near = closest(shape, from, 0);
    return RayEntry{0, at.rotation * (near ? near->normal : -way)};
  }
  if (way == Vec3(0)) return std::nullopt;
  auto entry = cast(shape, from, way, unit.distance);
  if (entry) entry->normal = at.rotation * entry->normal;
  return entry;
}

/// Calls `found(hit)` for entries within the limit; it returns the new limit, a fraction of the
/// ray.
template <class Found>
void visit_ray(const QueryIndex& index, const Ray& ray, const QueryFilter& filter, Found&& found) {
  const Real length = glm::length(ray.way);
  const Vec3 unit = length > 0 ? ray.way / length : Vec3(0);
  const auto look = [&](std::uint32_t number, Real limit) {
    const Item& item = index.items[number];
    if (!sees(filter, item)) return limit;
    const auto entry = enter(item.shape, item.at, ray, {limit, unit});
    if (!entry) return limit;
    const Real fraction = length > 0 ? glm::min(entry->distance / length, Real(1)) : 0;
    const Vec3 point = ray.origin + entry->distance * unit;
    // The limit is slightly enlarged so that rounding does not drop equally near hits.
    const Real so_far = found(RayHit{item.body, item.index, point, entry->normal, fraction});
    return glm::min(limit, length * so_far * (1 + 1e-12));
  };
  Real limit = length;
  for (std::uint32_t number : index.unbounded) limit = look(number, limit);
  index.tree.cast(ray.origin, unit, limit,
                  [&](std::uint32_t box, Real so_far) { return look(index.bounded[box], so_far); });
}

auto order(const RayHit& h) { return std::tie(h.fraction, h.body.index, h.shape); }

}  // namespace

Queries::Queries() : index_(std::make_unique<QueryIndex>()) {}
Queries::Queries(const Queries& other) : index_(std::make_unique<QueryIndex>(*other.index_)) {}
// The moved-from object is empty but valid.
Queries::Queries(Queries&& other) noexcept : Queries() { std::swap(index_, other.index_); }
Queries& Queries::operator=(const Queries& other) {
  *index_ = *other.index_;
  return *this;
}
Queries& Queries::operator=(Queries&& other) noexcept {
  std::swap(index_, other.index_);
  return *this;
}
Queries::~Queries() = default;

std::size_t Queries::left_out() const { return index_->left_out; }

void Queries::refit(const World& world, std::span<const Pose> poses) {
  auto& [items, unbounded, bounded, boxes, tree, left_out] = *index_;
  items.clear(), unbounded.clear(), bounded.clear(), boxes.clear(), left_out = 0;
  const auto owners = world.bodies.owners();
  for (std::uint32_t slot = 0; slot < owners.size(); ++slot) {
    const Shapes* shapes = world.shapes.find(owners[slot]);
    if (!shapes) continue;
    const Collision* collision = world.collisions.find(owners[slot]);
    const Pose& pose = slot < poses.size() ? poses[slot] : world.bodies.values()[slot].pose;
    for (std::uint32_t i = 0; i < shapes->list.size(); ++i) {
      const Shape& shape = shapes->list[i];
      Item item{shape, compose(pose, shape.local), owners[slot], i};
      if (!is_finite(item.at) || !is_unit(item.at) || !is_usable(shape)) {
        ++left_out;
        continue;
      }
      if (collision)
        item.groups = collision->groups, item.with = collision->with,
        item.is_solid = !collision->sensor;
      const auto number = static_cast<std::uint32_t>(items.size());
      if (is_unbounded(shape.kind))
        unbounded.push_back(number);
      else
        bounded.push_back(number), boxes.push_back(bounds_of(shape, item.at));
      items.push_back(std::move(item));
    }
  }
  if (tree.size() == boxes.size()) tree.refit(boxes);
  if (tree.size() != boxes.size() || tree.looseness() > 1.5) tree.build(boxes);
}

RayAnswer Queries::cast_ray(const Ray& ray, const QueryFilter& filter) const {
  if (!is_finite(ray.origin) || !is_finite(ray.way)) return {{}, QueryStatus::not_finite};
  RayAnswer answer;
  visit_ray(*index_, ray, filter, [&](const RayHit& hit) {
    if (!answer.hit || order(hit) < order(*answer.hit)) answer.hit = hit;
    return answer.hit->fraction;
  });
  return answer;
}

QueryStatus Queries::cast_ray_through(const Ray& ray, const QueryFilter& filter,
                                      std::vector<RayHit>& out) const {
  out.clear();
  if (!is_finite(ray.origin) || !is_finite(ray.way)) return QueryStatus::not_finite;
  visit_ray(*index_, ray, filter, [&](const RayHit& hit) {
    out.push_back(hit);
    return Real(1);
  });
  std::sort(out.begin(), out.end(),
            [](const RayHit& a, const RayHit& b) { return order(a) < order(b); });
  return QueryStatus::ok;
}

RayAnswer Queries::cast_shape(const Shape& shape, const Pose& from, Vec3 way,
                              const QueryFilter& filter) const {
  const Real length = glm::length(way);
  if (!is_finite(from) || !is_unit(from) || !std::isfinite(length) || !is_finite(shape.size))
    return {{}, QueryStatus::not_finite};
  if (!is_convex(shape) || !is_usable(shape)) return {{}, QueryStatus::bad_shape};
  const Pose at = compose(from, shape.local);
  constexpr Real kShortest = 1e-150;  // m: the square of a shorter length underflows
  const Vec3 unit = length > kShortest ? way / length : Vec3(0, 1, 0);
  RayAnswer answer;
  const auto look = [&](std::uint32_t number) {
    const Item& item = index_->items[number];
    if (!sees(filter, item)) return;
    const Real limit = answer.hit ? answer.hit->fraction * length : length;
    const auto met = sweep({shape, at}, {item.shape, item.at}, unit, limit);
    if (!met) return;
    const Real fraction = length > 0 ? glm::min(met->distance / length, Real(1)) : 0;
    const RayHit hit{item.body, item.index, met->point, met->normal, fraction};
    if (!answer.hit || order(hit) < order(*answer.hit)) answer.hit = hit;
  };
  Aabb swept = bounds_of(shape, at);
  swept.add({swept.low + way, swept.high + way});
  for (std::uint32_t number : index_->unbounded) look(number);
  index_->tree.query(swept, [&](std::uint32_t box) { look(index_->bounded[box]); });
  return answer;
}

QueryStatus Queries::overlap(const Shape& shape, const Pose& at, const QueryFilter& filter,
                             std::vector<Overlap>& out) const {
  out.clear();
  if (!is_finite(at) || !is_unit(at) || !is_finite(shape.size)) return QueryStatus::not_finite;
  if (!is_convex(shape) || !is_usable(shape)) return QueryStatus::bad_shape;
  const Pose pose = compose(at, shape.local);
  std::vector<std::uint32_t> numbers = index_->unbounded;
  index_->tree.query(bounds_of(shape, pose),
                     [&](std::uint32_t box) { numbers.push_back(index_->bounded[box]); });
  std::sort(numbers.begin(), numbers.end());
  NarrowPhaseScratch room;
  std::vector<ContactPoint> points;
  for (std::uint32_t number : numbers) {
    const Item& item = index_->items[number];
    if (!sees(filter, item)) continue;
    points.clear();
    collide({shape, pose}, {item.shape, item.at}, room, {0, points});
    if (points.empty()) continue;
    const ContactPoint& deepest = *std::min_element(
        points.begin(), points.end(),
        [](const ContactPoint& a, const ContactPoint& b) { return a.gap < b.gap; });
    out.push_back({item.body, item.index, -deepest.gap, deepest.normal, deepest.on_b});
  }
  return QueryStatus::ok;
}

ClosestAnswer Queries::closest_point(Vec3 place, Real within, const QueryFilter& filter) const {
  if (!is_finite(place) || !(within >= 0)) return {{}, QueryStatus::not_finite};
  ClosestAnswer answer;
  const auto key = [](const ClosestPoint& p) {
    return std::tie(p.distance, p.body.index, p.shape);
  };
  const auto look = [&](std::uint32_t number) {
    const Item& item = index_->items[number];
    if (!sees(filter, item)) return;
    const Real limit = answer.hit ? glm::max(answer.hit->distance, Real(0)) : within;
    const auto near = closest(item.shape, to_local(item.at, place), limit);
    if (!near) return;
    const ClosestPoint found{item.body, item.index, to_world(item.at, near->point),
                             item.at.rotation * near->normal, near->distance};
    if (!answer.hit || key(found) < key(*answer.hit)) answer.hit = found;
  };
  for (std::uint32_t number : index_->unbounded) look(number);
  const Real start = answer.hit ? glm::max(answer.hit->distance, Real(0)) : within;
  index_->tree.nearest(place, start * start, [&](std::uint32_t box) {
    look(index_->bounded[box]);
    const Real now = answer.hit ? glm::max(answer.hit->distance, Real(0)) : within;
    return now * now;
  });
  return answer;
}

}  // namespace pantin
