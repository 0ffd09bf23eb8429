// Bodies that fly together can meet only by their relative motion.
#include <algorithm>

#include "engine/base/invariants.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/pairs.hpp"
#include "engine/contact/resting.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::contact {
namespace {

/// A body is fast if it may move farther in a step than this fraction of its extent.
constexpr Real kFast = 0.2;
/// A time beyond the step.
constexpr Real kNever = 2;

/// Distance between two boxes, m.
Real distance_between(const Aabb& a, const Aabb& b) {
  return glm::length(glm::max(glm::max(a.low - b.high, b.low - a.high), Vec3(0)));
}

/// Finds the flights of a search. Nodes are the colliders, then the shapes of obstacles.
class FlightFinder {
 public:
  FlightFinder(const SweptSearch& s, Search& search, std::span<const Displacement> displacement)
      : s_(s), search_(search), own_(search.flights), displacement_(displacement) {}

  /// Whether there may be two fast bodies in one flight.
  bool any_fast_pair() const {
    const auto is_fast_pair = [&](std::uint64_t pair) {
      return is_fast(first_of(pair)) && is_fast(second_of(pair));
    };
    for (std::size_t k = 0; k < search_.obstacles.shapes.size(); ++k)
      if (is_fast(node_of(k)) && is_kinematic(search_.obstacles.shapes[k].slot)) return true;
    return std::any_of(search_.pairs.begin(), search_.pairs.end(), is_fast_pair);
  }

  void find() {
    const std::size_t nodes = search_.colliders.size() + search_.obstacles.shapes.size();
    own_.edges.clear(), own_.disturbed.assign(nodes, kNever), own_.struck.assign(nodes, 0);
    for (std::uint32_t node = 0; node < nodes; ++node)
      own_.struck[node] = s_.reach_of(slot_of(node));
    for (const std::uint64_t pair : search_.pairs) link(first_of(pair), second_of(pair));
    for (std::uint32_t i = 0; i < search_.colliders.size(); ++i) look_around(i);
    for (Flights::Edge& e : own_.edges) e.time = time_of(e.distance, e.a, own_.struck[e.b]);
    disturb_joined();
    spread_disturbances();
    join_undisturbed(nodes);
    list_bodies();
    add_strikes();
  }

 private:
  static std::uint32_t first_of(std::uint64_t pair) {
    return static_cast<std::uint32_t>(pair >> 32);
  }
  static std::uint32_t second_of(std::uint64_t pair) {
    return static_cast<std::uint32_t>(pair & 0xffffffff);
  }
  std::uint32_t node_of(std::size_t obstacle) const {
    return static_cast<std::uint32_t>(search_.colliders.size() + obstacle);
  }
  bool is_obstacle(std::uint32_t node) const { return node >= search_.colliders.size(); }
  std::uint32_t slot_of(std::uint32_t node) const {
    return is_obstacle(node) ? search_.obstacles.shapes[node - search_.colliders.size()].slot
                             : search_.colliders[node].slot;
  }
  /// Bounds at the start of the step.
  Aabb still_box(std::uint32_t node) const {
    return is_obstacle(node) ? search_.obstacles.shapes[node - search_.colliders.size()].box
                             : search_.boxes[node].grown(-s_.reach_of(slot_of(node)));
  }
  bool is_fast(std::uint32_t node) const {
    const Aabb box = still_box(node);
    return s_.reach_of(slot_of(node)) > kFast * glm::length(box.high - box.low) / 2;
  }
  bool is_kinematic(std::uint32_t slot) const {
    return !owner_of(s_.partition, slot) && moves(s_.world.bodies.values()[slot]);
  }
  /// The time that a collider needs for a distance to a body of that reach, as a fraction of the
  /// step. Either may have the speed of what strikes it.
  Real time_of(Real distance, std::uint32_t i, Real reach) const {
    const Real way = own_.struck[i] + reach;
    return distance > 0 ? (way > 0 ? std::min(distance / way, kNever) : kNever) : 0;
  }
  void link(std::uint32_t a, std::uint32_t b) {
    own_.edges.push_back({a, b, distance_between(still_box(a), still_box(b))});
    const Real to_a = s_.reach_of(slot_of(b)), to_b = s_.reach_of(slot_of(a));
    own_.struck[a] = std::max(own_.struck[a], to_a);
    own_.struck[b] = std::max(own_.struck[b], to_b);
  }

  /// Bodies with joints are disturbed by these: a blow anywhere may move them in any way.
  void disturb_joined() {
    own_.in_island.assign(s_.partition.islands.size(), 0);
    for (const std::uint32_t island : s_.partition.island)
      if (island != Owner::kNone) ++own_.in_island[island];
    for (std::uint32_t i = 0; i < search_.colliders.size(); ++i) {
      const std::uint32_t island = s_.partition.island[slot_of(i)];
      if (island != Owner::kNone && own_.in_island[island] > 1) own_.disturbed[i] = 0;
    }
  }

  /// Links a collider with the kinematic bodies within its reach. Other obstacles disturb it.
  void look_around(std::uint32_t i) {
    const std::uint32_t slot = search_.colliders[i].slot;
    const Real slop = kContactSlop * search_.shapes[search_.colliders[i].first].extent;
    const Aabb box = still_box(i).grown(own_.struck[i] + slop);
    Real& time = own_.disturbed[i];
    if (search_.colliders[i].rests) time = 0;
    const auto disturb = [&](const ColliderShape& at, Real distance) {
      const Real after = time_of(distance, i, s_.reach_of(at.slot));
      if (after < time && may_collide(s_, search_, slot, at.slot)) time = after;
    };
    search_.obstacles.tree.query(box, [&](std::uint32_t k) {
      const ColliderShape& at = search_.obstacles.shapes[k];
      if (!is_kinematic(at.slot))
        disturb(at, distance_to(i, at));
      else if (may_collide(s_, search_, slot, at.slot))
        link(i, node_of(k));
    });
    for (const ColliderShape& at : search_.obstacles.unbounded) disturb(at, distance_to(i, at));
    each_resting(s_.world, search_.resting, box,
                 [&](const ColliderShape& at) { disturb(at, distance_to(i, at)); });
  }
  /// m; 0 to an unbounded shape, which may be anywhere, unless it is a plane.
  Real distance_to(std::uint32_t i, const ColliderShape& at) const {
    if (!is_unbounded(at.shape->kind)) return distance_between(still_box(i), at.box);
    if (traits_of(at.shape->kind).shape_class != ShapeClass::half_space) return 0;
    const Vec3 up = at.pose.rotation * Vec3(0, 1, 0);
    const Aabb box = still_box(i);
    const Vec3 middle = (box.low + box.high) / 2.0, half = (box.high - box.low) / 2.0;
    return glm::dot(up, middle - at.pose.position) - glm::dot(glm::abs(up), half);
  }

  /// Passes disturbances on, from body to body that may meet in time.
  void spread_disturbances() {
    const auto relax = [&](const Flights::Edge& e) {
      if (is_obstacle(e.b)) return false;
      Real &a = own_.disturbed[e.a], &b = own_.disturbed[e.b];
      const Real before = a + b;
      if (a + e.time < 1) b = std::min(b, a + e.time);
      if (b + e.time < 1) a = std::min(a, b + e.time);
      return a + b < before;
    };
    settle(relax);
  }
  /// Visits the edges, from either end in turns, until `change` returns false for all.
  template <class Change>
  void settle(const Change& change) {
    for (bool any = true; any;) {
      any = false;
      for (const Flights::Edge& e : own_.edges) any = change(e) || any;
      for (auto e = own_.edges.rbegin(); any && e != own_.edges.rend(); ++e) change(*e);
    }
  }

  bool is_disturbed(std::uint32_t node) const { return own_.disturbed[node] < 1; }

  void join_undisturbed(std::size_t nodes) {
    own_.sets.reset(nodes);
    const std::vector<ColliderShape>& shapes = search_.obstacles.shapes;
    for (std::size_t k = 1; k < shapes.size(); ++k)
      if (shapes[k].slot == shapes[k - 1].slot) own_.sets.join(node_of(k), node_of(k - 1));
    for (const Flights::Edge& e : own_.edges)
      if (!is_disturbed(e.a) && !is_disturbed(e.b)) own_.sets.join(e.a, e.b);
  }

  void list_bodies() {
    own_.of.assign(s_.world.bodies.size(), {});
    for (std::uint32_t node = 0; node < own_.disturbed.size(); ++node) {
      if (is_disturbed(node) || !is_fast(node)) continue;
      const std::uint32_t slot = slot_of(node);
      const Shapes* shapes = s_.world.shapes.find(s_.world.bodies.owners()[slot]);
      const Real factor = s_.is_moved(slot) ? kReachFactor : 1, extent = extent_of(*shapes);
      const Displacement by{factor * displacement_[slot].translation,
                            factor * displacement_[slot].rotation};
      const Real way = glm::length(by.translation) + extent * glm::length(by.rotation);
      own_.of[slot] = {own_.sets.root(node), extent, s_.world.bodies.values()[slot].pose.position,
                       by, std::max(Real(0), s_.reach_of(slot) - way)};
    }
  }

  /// A body that is struck may take the speed of the striker for the rest of the step, and strike
  /// others.
  void add_strikes() {
    for (const Flights::Edge& e : own_.edges) {
      const std::uint32_t slot_a = slot_of(e.a), slot_b = slot_of(e.b);
      if (!own_.share_one(slot_a, slot_b)) continue;
      Flights::OfBody &a = own_.of[slot_a], &b = own_.of[slot_b];
      const Real more = Flights::relative_motion(a, b) - e.distance;
      a.pushed = std::max(a.pushed, more), b.pushed = std::max(b.pushed, more);
    }
    settle([&](const Flights::Edge& e) {
      const std::uint32_t slot_a = slot_of(e.a), slot_b = slot_of(e.b);
      if (!own_.share_one(slot_a, slot_b)) return false;
      Real &a = own_.of[slot_a].pushed, &b = own_.of[slot_b].pushed;
      const Real before = a + b;
      b = std::max(b, a - e.distance), a = std::max(a, b - e.distance);
      return a + b > before;
    });
  }

  const SweptSearch& s_;
  Search& search_;
  Flights& own_;
  std::span<const Displacement> displacement_;
};

}  // namespace

Real Flights::relative_motion(const OfBody& a, const OfBody& b) {
  const auto way_at = [](const OfBody& at, const OfBody& other) {
    return glm::length(at.by.translation - other.by.at(at.centre - other.centre));
  };
  const Real turned = glm::length(a.by.rotation - b.by.rotation);
  const Real together =
      std::min(way_at(a, b) + a.extent * turned, way_at(b, a) + b.extent * turned);
  const Real apart =
      glm::length(a.by.translation - b.by.translation) +
      (a.extent * glm::length(a.by.rotation) + b.extent * glm::length(b.by.rotation));
  return std::min(together, apart);
}

Real Flights::reach_between(std::uint32_t slot_a, std::uint32_t slot_b) const {
  const OfBody &a = of[slot_a], &b = of[slot_b];
  return relative_motion(a, b) + ((a.rest + b.rest) + (a.pushed + b.pushed));
}

void find_flights(const SweptSearch& s, Search& search,
                  std::span<const Displacement> displacement) {
  PANTIN_ASSERT(displacement.size() >= s.world.bodies.size());
  FlightFinder finder(s, search, displacement);
  if (!finder.any_fast_pair()) return;
  finder.find();
  std::erase_if(search.pairs, [&](std::uint64_t pair) {
    const std::size_t a = pair >> 32, b = pair & 0xffffffff;
    const std::uint32_t slot_a = search.colliders[a].slot, slot_b = search.colliders[b].slot;
    if (!search.flights.share_one(slot_a, slot_b)) return false;
    const Real slop = kContactSlop * std::max(search.shapes[search.colliders[a].first].extent,
                                              search.shapes[search.colliders[b].first].extent);
    const Real less =
        s.reach_of(slot_a) + s.reach_of(slot_b) - search.flights.reach_between(slot_a, slot_b);
    return !search.boxes[a].grown(slop - less).overlaps(search.boxes[b]);
  });
}

}  // namespace pantin::detail::contact
