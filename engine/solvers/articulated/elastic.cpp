// Elastic energy of the cables and spring pins of an island, and what their anchors supply.
#include "engine/contact/detect.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Of one cable with its ends at `a` and `b`.
Real energy_between(const CableParameters& s, Vec3 a, Vec3 b) {
  PANTIN_ASSERT(s.compliance > 0);
  const Real over = glm::length(b - a) - s.length;
  return over > 0 ? 0.5 * over * over / s.compliance : 0;
}

/// Where ends of cables and pins are: `column_point(column, anchor)` on packed bodies,
/// `slot_point(slot, anchor)` on others, and `target(pin)` where pins are anchored in the world.
template <class ColumnPoint, class SlotPoint, class Target>
struct Places {
  ColumnPoint column_point;
  SlotPoint slot_point;
  Target target;
};
template <class ColumnPoint, class SlotPoint, class Target>
Places(ColumnPoint, SlotPoint, Target) -> Places<ColumnPoint, SlotPoint, Target>;

template <class At>
Real sum_energy(const World& world, const Island& a, const At& at) {
  Real sum = 0;
  for (const PackedCable& cable : a.cables) {
    const CableParameters& s = world.cables.values()[cable.cable].joint;
    if (!(s.compliance > 0)) continue;
    sum += energy_between(s,
                          cable.column_a != UINT32_MAX ? at.column_point(cable.column_a, s.anchor_a)
                                                       : at.slot_point(cable.slot_a, s.anchor_a),
                          cable.column_b != UINT32_MAX ? at.column_point(cable.column_b, s.anchor_b)
                                                       : at.slot_point(cable.slot_b, s.anchor_b));
  }
  for (const PackedPin& pin : a.pins) {
    if (!(pin.compliance > 0)) continue;
    const Vec3 to =
        pin.partner != UINT32_MAX ? at.column_point(pin.partner, pin.held_anchor) : at.target(pin);
    const Vec3 gap = to - at.column_point(pin.column, pin.anchor);
    sum += 0.5 * glm::dot(gap, gap) / pin.compliance;
  }
  return sum;
}

}  // namespace

Vec3 point_before(const World& world, std::uint32_t slot, Vec3 anchor, Real h) {
  const Body& b = world.bodies.values()[slot];
  return to_world(b.teleport ? b.pose : contact::pose_before(b, h), anchor);
}

Real elastic_energy(const World& world, const Island& a) {
  if (!has_rows(a)) return 0;
  return sum_energy(
      world, a,
      Places{[&](std::uint32_t column, Vec3 anchor) {
               return point_on(world, a.slots[column], anchor);
             },
             [&](std::uint32_t slot, Vec3 anchor) { return point_on(world, slot, anchor); },
             [](const PackedPin& pin) { return pin.target; }});
}

Real elastic_energy_before(const World& world, const Island& a, Real h) {
  if (!has_rows(a)) return 0;
  return sum_energy(
      world, a,
      Places{[&](std::uint32_t column, Vec3 anchor) {
               return point_on(world, a.slots[column], anchor);
             },
             [&](std::uint32_t slot, Vec3 anchor) { return point_before(world, slot, anchor, h); },
             [](const PackedPin& pin) { return pin.target_before; }});
}

Real elastic_energy_of_final(const World& world, const Island& a) {
  if (!has_rows(a)) return 0;
  return sum_energy(
      world, a,
      Places{[&](std::uint32_t column, Vec3 anchor) {
               return point_at(a, column, anchor, kFinalPoses);
             },
             [&](std::uint32_t slot, Vec3 anchor) { return point_on(world, slot, anchor); },
             [](const PackedPin& pin) { return pin.target; }});
}

SpringExchange spring_exchange(const Island& a, const PackedPin& pin, Real h) {
  const Vec3 gap =
      target_of(a, pin, kFinalPoses) - point_at(a, pin.column, pin.anchor, kFinalPoses);
  const Vec3 change = gap - pin.gap_before;
  const Vec3 force = 0.5 / pin.compliance * (gap + pin.gap_before) + pin.damping / h * change;
  const Vec3 moved = pin.partner == UINT32_MAX ? pin.target - pin.target_before : Vec3(0);
  return {glm::dot(force, moved), pin.damping / h * glm::dot(change, change)};
}

}  // namespace pantin::detail::articulated
