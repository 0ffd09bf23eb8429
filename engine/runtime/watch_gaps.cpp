#include "engine/runtime/watch_gaps.hpp"

#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/world/cable_route.hpp"
#include "engine/world/joint_coordinate.hpp"
#include "engine/world/partition.hpp"

namespace pantin::detail {
namespace {

/// Tolerated gap, relative to the size of the mechanism or the length of the belt.
constexpr Real kOpen = 1e-3;
/// rad: tolerated violation of kinds and limits, and of gears.
constexpr Real kOver = 0.05, kOffRatio = 0.01;
/// s: the time that a pin may need to reach its target.
constexpr Real kOnTheWay = 0.25;

}  // namespace

/// The extent of the anchors of each mechanism when compiled, but at least the radius of gyration
/// of each body: a wheel may be held at its centre alone.
void GapWatch::find_sizes(const World& world) {
  sizes_.assign(world.bodies.size(), 0);
  const Partition& partition = partition_of(world);
  std::vector<Vec3> low(partition.islands.size(), Vec3(1e300)), high(low.size(), Vec3(-1e300));
  const auto island_of = [&](Entity e) {
    const std::uint32_t slot = world.bodies.slot(e);
    return slot < partition.island.size() ? partition.island[slot] : Owner::kNone;
  };
  const auto add = [&](std::uint32_t island, Entity e, Vec3 anchor) {
    const Body* b = world.bodies.find(e);
    if (!b || island == Owner::kNone) return;
    const Vec3 at = to_world(b->pose, anchor);
    low[island] = glm::min(low[island], glm::min(at, b->pose.position));
    high[island] = glm::max(high[island], glm::max(at, b->pose.position));
  };
  const auto add_both = [&](Entity a, Entity b, Vec3 on_a, Vec3 on_b) {
    for (const std::uint32_t island : {island_of(a), island_of(b)})
      add(island, a, on_a), add(island, b, on_b);
  };
  for (const Link& l : world.links.values()) add_both(l.a, l.b, l.joint.anchor_a, l.joint.anchor_b);
  for (const Cable& c : world.cables.values())
    add_both(c.a, c.b, c.joint.anchor_a, c.joint.anchor_b);
  for (std::uint32_t i = 0; i < sizes_.size() && i < partition.island.size(); ++i) {
    const std::uint32_t island = partition.island[i];
    const Body& b = world.bodies.values()[i];
    if (b.motion == Motion::dynamic) sizes_[i] = radius_of_gyration(b.inertia, b.mass);
    if (island != Owner::kNone && low[island].x <= high[island].x)
      sizes_[i] = std::max(sizes_[i], glm::length(high[island] - low[island]));
  }
}

Real GapWatch::size_of(const World& world, Entity a, Entity b) const {
  const std::uint32_t on_a = world.bodies.slot(a), on_b = world.bodies.slot(b);
  return std::max(on_a < sizes_.size() ? sizes_[on_a] : 0, on_b < sizes_.size() ? sizes_[on_b] : 0);
}

void GapWatch::compile(const World& world) {
  find_sizes(world);
  missed_for_.assign(world.pins.size(), 0);
  ratios_.assign(world.gears.size(), {});
  held_.clear();
  for (const Belt& belt : world.belts.values()) held_.push_back(held_spans(world, belt));
}

void GapWatch::check_joints(const World& world, FindingList& found) const {
  for (std::uint32_t i = 0; i < world.links.size(); ++i) {
    const Link& l = world.links.values()[i];
    const Body *a = world.bodies.find(l.a), *b = world.bodies.find(l.b);
    const JointKindInfo& info = info_of(l.joint.kind);
    if (!a || !b || info.rows == 0) continue;
    const Entity joint = world.links.owners()[i];
    const Real gap = info.counts_turns ? 0 : info.gap(l.joint, a->pose, b->pose);
    if (gap > kOpen * size_of(world, l.a, l.b)) found.note(FindingKind::joint_open, joint, gap);
    if (!info.uses_axes && !l.joint.limits.any()) continue;
    const Real over =
        violation(l.joint, relative_rotation(l.joint, a->pose.rotation, b->pose.rotation));
    if (over > kOver) found.note(FindingKind::limit_exceeded, joint, over);
  }
}

void GapWatch::check_cables(const World& world, FindingList& found) const {
  for (std::uint32_t i = 0; i < world.cables.size(); ++i) {
    const Cable& c = world.cables.values()[i];
    if (c.joint.compliance > 0 || !c.guides.empty()) continue;
    const Body *a = world.bodies.find(c.a), *b = world.bodies.find(c.b);
    const Real over = a && b ? stretch(c.joint, a->pose, b->pose) : 0;
    if (over > kOpen * size_of(world, c.a, c.b))
      found.note(FindingKind::cable_overlong, world.cables.owners()[i], over);
  }
}

void GapWatch::check_pins(const World& world, Real h, FindingList& found) {
  for (std::uint32_t i = 0; i < world.pins.size(); ++i) {
    const Pin& p = world.pins.values()[i];
    const bool missed = p.kind == PinKind::exact && p.missed && p.reachable;
    missed_for_[i] = missed ? missed_for_[i] + h : 0;
    if (missed_for_[i] > kOnTheWay)
      found.note(FindingKind::pin_missed, world.pins.owners()[i], p.residual);
  }
}

void GapWatch::check_gears(const World& world, FindingList& found) {
  for (std::uint32_t i = 0; i < world.gears.size(); ++i) {
    const Gear& g = world.gears.values()[i];
    const Link *first = world.links.find(g.first), *second = world.links.find(g.second);
    if (!first || !second) continue;
    Ratio& r = ratios_[i];
    const Coordinate of_first = g.first_travels ? Coordinate::travel : Coordinate::angle,
                     of_second = g.second_travels ? Coordinate::travel : Coordinate::angle;
    r.first = coordinate_at(world, *first, of_first, r.first).value;
    const Real near = r.known ? r.second : g.has_offset ? g.ratio * r.first + g.offset : 0;
    r.second = coordinate_at(world, *second, of_second, near).value;
    const Real offset = r.second - g.ratio * r.first;
    if (!r.known) r.offset = offset, r.known = true;
    const Real off = std::abs(offset - r.offset);
    const Real most = g.second_travels ? kOpen * size_of(world, second->a, second->b)
                                       : kOffRatio * std::max(Real(1), std::abs(g.ratio));
    if (off > most) found.note(FindingKind::gear_slipped, world.gears.owners()[i], off);
  }
}

/// Each span, between fixed marks on consecutive pulleys, must keep its length.
void GapWatch::check_belts(const World& world, FindingList& found) const {
  for (std::uint32_t i = 0; i < world.belts.size(); ++i) {
    const Belt& belt = world.belts.values()[i];
    if (belt.slips || belt.friction > 0) continue;
    const std::size_t count = belt.pulleys.size();
    for (std::size_t k = 0; k < held_[i]; ++k) {
      const BeltPulley &from = belt.pulleys[k], &to = belt.pulleys[(k + 1) % count];
      const Body *a = world.bodies.find(from.body), *b = world.bodies.find(to.body);
      if (!a || !b) continue;
      const BeltPlace at = place_of(from, a->pose), next = place_of(to, b->pose);
      const BeltSpan span = span_between(at, next, from.direction);
      const Real off = std::abs(marked_length(at, next, span) - from.offset);
      if (off > kOpen * belt.length)
        found.note(FindingKind::belt_slipped, world.belts.owners()[i], off);
    }
  }
}

void GapWatch::check_surfaces(const World& world, FindingList& found) const {
  for (std::uint32_t i = 0; i < world.surface_contacts.size(); ++i) {
    const SurfaceContact& c = world.surface_contacts.values()[i];
    if (c.over || (c.lifts && c.gap > 0)) continue;
    const Body *a = world.bodies.find(c.a), *b = world.bodies.find(c.b);
    const Real apart = a && b ? glm::length(a->pose.position - b->pose.position) : 1e300;
    if (std::abs(c.gap) > kOpen * std::max(size_of(world, c.a, c.b), apart))
      found.note(FindingKind::surfaces_apart, world.surface_contacts.owners()[i], std::abs(c.gap));
  }
}

void GapWatch::end_step(const World& world, Real h, FindingList& found) {
  check_joints(world, found);
  check_cables(world, found);
  check_pins(world, h, found);
  check_gears(world, found);
  check_belts(world, found);
  check_surfaces(world, found);
}

}  // namespace pantin::detail
