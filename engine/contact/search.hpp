#pragma once
/// Scratch memory of contact detection, kept allocated between steps.
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/disjoint_sets.hpp"
#include "engine/base/threads.hpp"
#include "engine/contact/contact.hpp"
#include "engine/geometry/aabb_tree.hpp"
#include "engine/geometry/collide.hpp"
#include "engine/world/collision.hpp"
#include "engine/world/entity.hpp"
#include "engine/world/joined.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail {
struct Partition;
}

namespace pantin::detail::contact {

/// Keys of contact points: ten bits for each of the two shapes, the rest for the feature.
inline constexpr std::uint64_t kFeatures = (1ull << 44) - 1, kCore = kFeatures, kShapes = 0x3ff;
inline constexpr int kShapeOfA = 54, kShapeOfB = 44;
inline std::uint64_t key_of(std::uint32_t a, std::uint32_t b, std::uint64_t feature) {
  return (a & kShapes) << kShapeOfA | (b & kShapes) << kShapeOfB | (feature & kFeatures);
}
inline std::uint32_t shape_of_a(std::uint64_t key) {
  return static_cast<std::uint32_t>(key >> kShapeOfA & kShapes);
}
inline std::uint32_t shape_of_b(std::uint64_t key) {
  return static_cast<std::uint32_t>(key >> kShapeOfB & kShapes);
}
inline bool is_core(std::uint64_t key) { return (key & kFeatures) == kCore; }

/// One shape of a collider at its pose in the world.
struct ColliderShape {
  Pose pose;
  Aabb box;                      // world bounds at that pose
  Real extent = 0;               // m, half its diagonal
  std::uint32_t slot = 0;        // of the body
  std::uint32_t index = 0;       // among the body's shapes
  const Shape* shape = nullptr;  // only within the step in which it was looked up
};

/// Computes the box and extent of a shape at its pose. False if its numbers are not finite or too
/// large: such a shape touches nothing. Solvers report bodies that diverged.
bool bound_shape(ColliderShape& at);

/// A collider that moves or may be moved: one body of a solver with its shapes.
struct Collider {
  std::uint32_t slot = 0, first = 0, count = 0;  // range in Search::shapes
  const Collision* collision = nullptr;
  bool rests = false;
};

/// Shapes of obstacles; the bounded ones form a tree.
struct Obstacles {
  std::vector<ColliderShape> shapes, unbounded;
  std::vector<Aabb> boxes;  // of `shapes`
  AabbTree tree;

  void clear() { shapes.clear(), unbounded.clear(), boxes.clear(); }
};

/// Colliders at rest: fixed bodies and sleeping ones. Rebuilt when much has changed; in between,
/// bodies that no longer rest, or that are gone (slot kNoSlot), are skipped.
struct RestingColliders {
  std::vector<std::uint8_t> known;  // by slot: is listed, or has nothing to collide
  std::vector<Pose> poses;          // by slot, of those
  Obstacles obstacles;
  std::uint64_t built_for = 0;               // versions of the components
  std::uint64_t collisions = 0, shapes = 0;  // additions() that were processed
  std::size_t count = 0, lost = 0;

  bool knows(std::uint32_t slot) const { return slot < known.size() && known[slot] != 0; }
};

/// A contact point before it becomes a contact.
struct FoundPoint {
  std::uint32_t slot_a = 0, slot_b = 0;
  std::uint64_t key = 0;
  const MaterialPair* pair = nullptr;  // of the two shapes' materials
  ContactPoint at;
};

/// A found point and its bodies, which it is sorted by.
struct PointKey {
  std::uint64_t bodies = 0;
  std::uint32_t point = 0;
};

/// What a body moves by in a step, about its mass centre; world axes.
struct Displacement {
  Vec3 translation{0};  // m
  Vec3 rotation{0};     // rad, a rotation vector

  /// m, of the point of the body at `arm` from its mass centre, to second order.
  Vec3 at(Vec3 arm) const {
    const Vec3 across = glm::cross(rotation, arm);
    return translation + across + glm::cross(rotation, across) / 2.0;
  }
};

/// Bodies that nothing at rest can disturb within the step: see find_flights().
struct Flights {
  static constexpr std::uint32_t kNone = UINT32_MAX;
  /// A body in flight, at the start of the step.
  struct OfBody {
    std::uint32_t flight = kNone;
    Real extent = 0;  // m
    Vec3 centre{0};
    Displacement by;  // kReachFactor included
    Real rest = 0;    // m: its reach, less that displacement
    Real pushed = 0;  // m: displacement by those that may strike it
  };
  /// Two nodes that may meet, their distance, m, and the time that they need at least, as a
  /// fraction of the step.
  struct Edge {
    std::uint32_t a = 0, b = 0;
    Real distance = 0, time = 0;
  };
  std::vector<OfBody> of;  // by body slot; empty: there is no flight
  std::vector<Edge> edges;
  std::vector<std::uint32_t> in_island;  // bodies, by island of the partition
  std::vector<Real> struck;     // m, by node: largest reach of it and of those that may strike it
  std::vector<Real> disturbed;  // by node: when at the earliest, as a fraction of the step
  DisjointSets sets{0};

  bool share_one(std::uint32_t a, std::uint32_t b) const {
    return !of.empty() && of[a].flight != kNone && of[a].flight == of[b].flight;
  }
  /// m: by how much the surfaces of two such bodies may approach each other by what is predicted:
  /// by translations and rotations apart, or by the relative motion at one of them. (The distance
  /// of two rotations is at most that of their rotation vectors.) The order of the two does not
  /// matter, to the bit.
  static Real relative_motion(const OfBody& a, const OfBody& b);
  /// m: the same by all that may happen.
  Real reach_between(std::uint32_t slot_a, std::uint32_t slot_b) const;
};

/// What one thread finds, and its scratch memory.
struct PointSearch {
  std::vector<FoundPoint> found;
  std::vector<ContactPoint> points;    // of one pair
  std::vector<ContactPoint> at_start;  // `points` at the start of the step
  NarrowPhaseScratch scratch;
};

/// Not part of the state: an empty Search finds the same contacts.
struct Search {
  RestingColliders resting;
  Obstacles obstacles;                // no solver owns them, not at rest
  std::vector<ColliderShape> shapes;  // of the colliders
  std::vector<Collider> colliders;    // by slot
  std::vector<Aabb> boxes;            // of the colliders
  AabbTree tree;
  std::vector<std::uint64_t> joined;  // see engine/world/joined.hpp
  std::uint64_t joined_for = 0;
  std::vector<std::uint64_t> ignored;  // likewise
  std::vector<std::uint64_t> pairs;    // of colliders, the contact's owner first
  Flights flights;
  std::vector<const MaterialPair*> material_pairs;  // of the World, sorted by their materials
  std::vector<FoundPoint> found;
  std::vector<PointKey> keys;
  std::vector<std::uint32_t> order;  // of those
  std::vector<PointSearch> workers;  // by part of the search, at least one after it
  // Sensors: how many there are, their shapes, those without bounds, those with.
  std::size_t sensors = 0;
  std::vector<ColliderShape> sensor_shapes;
  std::vector<std::uint32_t> unbounded_sensors, bounded_sensors;
  std::vector<Aabb> sensor_boxes;
  AabbTree sensor_tree;
};

/// Updates Search::joined.
void list_joined(const World& world, Search& search);
/// Updates a tree: refits it, or rebuilds it when it has become loose.
void update_tree(AabbTree& tree, std::span<const Aabb> boxes);

/// Input of a contact search.
struct Finder {
  World& world;
  const Partition& partition;
  std::span<const Real> reach;  // by slot, see find_contacts
  bool keeps = true;            // contacts between bodies at rest are kept
  Threads threads = {};

  /// Bound of the displacement of the body's surface in the step, m.
  Real reach_of(std::uint32_t slot) const;
  /// Whether the body cannot move in the step, unless something strikes it.
  bool rests(std::uint32_t slot) const;
  /// Whether contacts affect its motion.
  bool is_moved(std::uint32_t slot) const;
};

/// Removes the points of pairs that do not collide from Search::order, which is sorted by pairs:
/// see near_pairs.hpp.
void drop_points(const Finder& finder, Search& search, const ContactFilter* filter);

/// Fills colliders, obstacles and resting colliders (colliders.cpp).
void list_colliders(const Finder& finder, Search& search);

}  // namespace pantin::detail::contact
