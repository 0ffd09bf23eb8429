// Sensors: which bodies overlap them at the end of a step.
//
// The bounding boxes of the sensors' shapes form a tree, since sensors are few; every other shape
// queries it.
#include <algorithm>
#include <optional>
#include <tuple>

#include "engine/base/invariants.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/memory.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/geometry/usable.hpp"

namespace pantin::detail::contact {
namespace {

/// A shape of a body at its pose; none if it is too far away or has no surface.
std::optional<ColliderShape> place(const World& world, std::uint32_t slot, const Shape& shape) {
  ColliderShape at{compose(world.bodies.values()[slot].pose, shape.local), {}, 0, slot, 0, &shape};
  if (!is_usable(shape) || !bound_shape(at)) return std::nullopt;
  return at;
}

enum class Role : std::uint8_t { sensor, solid };

/// Calls `take(shape)` for every shape of the bodies in that role that collide.
template <class Take>
void each_shape(const World& world, Role role, const Take& take) {
  for (std::size_t i = 0; i < world.collisions.size(); ++i) {
    const Entity body = world.collisions.owners()[i];
    const std::uint32_t slot = world.bodies.slot(body);
    const Shapes* shapes = world.shapes.find(body);
    const Role its = world.collisions.values()[i].sensor ? Role::sensor : Role::solid;
    if (its != role || slot == kNoSlot || !shapes) continue;
    for (const Shape& shape : shapes->list)
      if (const auto at = place(world, slot, shape)) take(*at);
  }
}

void list_sensors(const World& world, Search& search) {
  search.sensor_shapes.clear(), search.sensor_boxes.clear();
  search.unbounded_sensors.clear(), search.bounded_sensors.clear();
  each_shape(world, Role::sensor, [&](const ColliderShape& at) {
    const auto number = static_cast<std::uint32_t>(search.sensor_shapes.size());
    search.sensor_shapes.push_back(at);
    if (is_unbounded(at.shape->kind))
      search.unbounded_sensors.push_back(number);
    else
      search.bounded_sensors.push_back(number), search.sensor_boxes.push_back(at.box);
  });
  PANTIN_ASSERT(search.sensor_boxes.size() == search.bounded_sensors.size());
  update_tree(search.sensor_tree, search.sensor_boxes);
}

bool may_sense(const World& world, const Search& search, std::uint32_t sensor, std::uint32_t body) {
  const auto owners = world.bodies.owners();
  const auto is_fixed = [&](std::uint32_t slot) {
    return world.bodies.values()[slot].motion == Motion::fixed;
  };
  return do_groups_agree(world.collisions[owners[sensor]], world.collisions[owners[body]]) &&
         !(is_fixed(sensor) && is_fixed(body)) && !are_joined(search.joined, sensor, body);
}

/// Adds the overlap of two shapes, if there is one.
void sense_shape(const World& world, Memory& memory, const ColliderShape& sensor,
                 const ColliderShape& other) {
  Search& search = memory.scratch.search;
  if (!may_sense(world, search, sensor.slot, other.slot)) return;
  // The narrow phase needs a shape that can move as its first one.
  const bool swaps = !can_move(sensor.shape->kind);
  const ColliderShape &a = swaps ? other : sensor, &b = swaps ? sensor : other;
  if (!can_move(a.shape->kind)) return;
  auto& [found, points, at_start, scratch] = search.workers.front();
  points.clear();
  collide({*a.shape, a.pose}, {*b.shape, b.pose}, scratch, {0, points});
  if (points.empty()) return;
  const ContactPoint& deepest =
      *std::min_element(points.begin(), points.end(),
                        [](const ContactPoint& p, const ContactPoint& q) { return p.gap < q.gap; });
  PANTIN_ASSERT(deepest.gap <= 0);
  const auto owners = world.bodies.owners();
  memory.overlaps.push_back({owners[sensor.slot], owners[other.slot],
                             swaps ? deepest.on_a : deepest.on_b,
                             swaps ? -deepest.normal : deepest.normal, -deepest.gap});
}

/// Keeps each pair once, with its deepest overlap. Ties are decided by the point, since the order
/// of the tree differs between a World and its copy.
void sort_out(std::vector<SensorOverlap>& overlaps) {
  const auto order = [](const SensorOverlap& o) {
    return std::tuple(o.sensor.index, o.body.index, -o.depth, o.point.x, o.point.y, o.point.z);
  };
  std::sort(overlaps.begin(), overlaps.end(),
            [&](const SensorOverlap& p, const SensorOverlap& q) { return order(p) < order(q); });
  const auto same = [&](const SensorOverlap& p, const SensorOverlap& q) {
    return p.sensor == q.sensor && p.body == q.body;
  };
  overlaps.erase(std::unique(overlaps.begin(), overlaps.end(), same), overlaps.end());
}

}  // namespace

void sense(World& world) {
  Memory& memory = world.memory.of<Memory>();
  Search& search = memory.scratch.search;
  memory.overlaps.clear();
  if (search.sensors == 0) return;
  list_joined(world, search);
  list_sensors(world, search);
  each_shape(world, Role::solid, [&](const ColliderShape& at) {
    const auto look = [&](std::uint32_t number) {
      PANTIN_ASSERT(number < search.sensor_shapes.size());
      sense_shape(world, memory, search.sensor_shapes[number], at);
    };
    for (const std::uint32_t number : search.unbounded_sensors) look(number);
    if (is_unbounded(at.shape->kind))
      for (const std::uint32_t number : search.bounded_sensors) look(number);
    else
      search.sensor_tree.query(at.box, [&](std::uint32_t i) { look(search.bounded_sensors[i]); });
  });
  sort_out(memory.overlaps);
}

}  // namespace pantin::detail::contact

namespace pantin::detail {

const std::vector<SensorOverlap>& sensor_overlaps_of(const World& world) {
  return world.memory.of<contact::Memory>().overlaps;
}

}  // namespace pantin::detail

namespace pantin::detail {
template contact::Memory& Memories::create();
template const contact::Memory& Memories::none();
}  // namespace pantin::detail
