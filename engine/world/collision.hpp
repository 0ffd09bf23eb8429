#pragma once
/// Collision filters and surface properties.
#include <cstdint>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin {

/// A component: the body's Shapes collide. Bodies without it have no contacts.
///
/// A dynamic body collides with every fixed or kinematic one whose groups agree, with dynamic ones
/// of its solver only on request, of another one always. Bodies that a joint connects never do.
///
/// A sensor reports which bodies overlap it and pushes none: see ContactEvents. It sees every body
/// that collides and whose groups agree, dynamic ones without a request; neither other sensors, nor
/// bodies that a joint connects to it, nor, where it is fixed itself, fixed bodies. Call
/// World::mark_dirty() after changing `sensor`.
struct Collision {
  Real friction = 0.5;              // Coulomb; of two bodies the geometric mean counts
  Real restitution = 0;             // 0..1; of two bodies the larger counts
  std::uint32_t groups = 1;         // bits: groups that this body belongs to
  std::uint32_t with = UINT32_MAX;  // bits: groups that it collides with; both bodies must agree
  bool others = false;              // dynamic bodies of other islands too
  bool self = false;                // dynamic bodies of its own island too
  bool sensor = false;              // reports overlaps, pushes nothing

  static void fields(auto& self, auto&& field) {
    field("friction", self.friction);
    field("restitution", self.restitution);
    field("groups", self.groups);
    field("with", self.with);
    field("others", self.others);
    field("self", self.self);
    field("sensor", self.sensor);
  }
};

/// Whether the groups of two bodies agree.
constexpr bool do_groups_agree(const Collision& a, const Collision& b) {
  return (a.groups & b.with) != 0 && (b.groups & a.with) != 0;
}

}  // namespace pantin
