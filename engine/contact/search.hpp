#pragma once
/// Scratch memory of contact detection, kept allocated between steps.
#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry/aabb_tree.hpp"
#include "engine/geometry/collide.hpp"
#include "engine/world/collision.hpp"
#include "engine/world/entity.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail::contact {

/// One shape of a collider at its pose in the world.
struct ColliderShape {
  Pose pose;
  Aabb box;                 // as it stands
  Real extent = 0;          // m, half its diagonal
  std::uint32_t slot = 0;   // of the body
  std::uint32_t index = 0;  // among the body's shapes
  const Shape* shape = nullptr;
};

/// A collider: one body with its shapes.
struct Collider {
  std::uint32_t slot = 0, first = 0, count = 0;  // its shapes
  std::uint8_t solver = UINT8_MAX;               // none: no solver owns the body
  std::uint32_t island = UINT32_MAX;             // of that solver
  const Collision* collision = nullptr;
};

/// A contact point of one body before it becomes a contact.
struct FoundPoint {
  std::uint32_t slot_b = 0;
  std::uint64_t key = 0;
  const Collision* other = nullptr;
  ContactPoint at;
};

/// Not part of the state: an empty one finds the same contacts.
struct Search {
  std::vector<ColliderShape> shapes;
  std::vector<Collider> colliders;
  std::vector<std::uint32_t> static_shapes, unbounded, moving;  // shapes; shapes; colliders
  std::vector<std::uint32_t> collider_at;                       // by slot; UINT32_MAX: none
  std::vector<Aabb> boxes, static_boxes, moving_boxes;
  AabbTree static_tree, moving_tree;
  std::vector<std::uint64_t> jointed;  // pairs of slots, lower first, sorted
  std::uint64_t jointed_for = 0;       // see jointed_version
  std::vector<std::uint64_t> pairs;    // of moving colliders, lower slot first
  std::vector<FoundPoint> found;       // of one body
  std::vector<ContactPoint> points;    // of one pair
  NarrowPhaseScratch scratch;
  // Sensors: how many there are, their shapes, those without bounds, those with.
  std::size_t sensors = 0;
  std::vector<ColliderShape> sensor_shapes;
  std::vector<std::uint32_t> unbounded_sensors, bounded_sensors;
  std::vector<Aabb> sensor_boxes;
  AabbTree sensor_tree;
};

/// Brings Search::jointed up to date.
void list_jointed(const World& world, Search& search);
/// Whether a joint connects two bodies, by their slots.
bool are_jointed(const Search& search, std::uint32_t a, std::uint32_t b);
/// Updates a tree: refits it, or rebuilds it when it has become loose.
void update_tree(AabbTree& tree, std::span<const Aabb> boxes);

}  // namespace pantin::detail::contact
