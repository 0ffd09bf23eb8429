#pragma once
/// Collision filters and surface properties.
#include <cstdint>
#include <optional>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin {

/// A component: the body's Shapes collide. Bodies without it have no contacts.
///
/// A dynamic body collides with every body whose groups agree, but not with those that a joint
/// connects it to. `others` and `self` spare it dynamic ones, whichever solver they ask for: what
/// may touch is stepped by one.
///
/// A sensor reports which bodies overlap it and pushes none: see ContactEvents. It sees every body
/// that collides and whose groups agree, whatever `others` and `self` say; neither other sensors,
/// nor bodies that a joint connects to it, nor, where it is fixed itself, fixed bodies. Call
/// World::mark_dirty() after changing `sensor`.
///
/// The surface of a belt moves while its body need not: friction works on the velocity relative to
/// `surface_velocity`, whose part along the normal of a contact does not count. Those of two bodies
/// add up. It may change at any time.
///
/// Through a one-way surface bodies pass that do not come from the side that `one_way` points to,
/// until they have left it; then it is solid for them as for those that come from there. A platform
/// that one may jump onto from below has {0, 1, 0}. Not for bodies of the solver "quasistatic".
struct Collision {
  Real friction = 0.5;              // Coulomb; of two bodies the geometric mean counts
  Real restitution = 0;             // 0..1; of two bodies the larger counts
  std::uint32_t groups = 1;         // bits: groups that this body belongs to
  std::uint32_t with = UINT32_MAX;  // bits: groups that it collides with; both bodies must agree
  bool others = true;               // dynamic bodies of other islands; one of the two says so
  bool self = true;                 // dynamic bodies of its own island; both have to
  bool sensor = false;              // reports overlaps, pushes nothing
  Real rolling = 0;          // m: torque against rolling over normal force; the larger counts
  Real spinning = 0;         // m: the same about the normal; the larger counts
  Vec3 surface_velocity{0};  // m/s, in the frame that the body is placed by
  Vec3 one_way{0};           // outwards of the solid side, of any length, likewise; zero: all are

  static void fields(auto& self, auto&& field) {
    field("friction", self.friction);
    field("restitution", self.restitution);
    field("groups", self.groups);
    field("with", self.with);
    field("others", self.others);
    field("self", self.self);
    field("sensor", self.sensor);
    field("rolling", self.rolling);
    field("spinning", self.spinning);
    field("surface_velocity", self.surface_velocity);
    field("one_way", self.one_way);
  }
};

/// What two materials are to each other, by index into World::materials: it holds where shapes of
/// them touch, in either order, or two of the same one. What it does not say is combined from the
/// Collisions of the two bodies.
struct MaterialPair {
  std::uint32_t a = 0, b = 0;
  std::optional<Real> friction = {}, restitution = {}, rolling = {}, spinning = {};

  static void fields(auto& self, auto&& field) {
    field("a", self.a);
    field("b", self.b);
    field("friction", self.friction);
    field("restitution", self.restitution);
    field("rolling", self.rolling);
    field("spinning", self.spinning);
  }
};

/// Whether the groups of two bodies agree.
constexpr bool do_groups_agree(const Collision& a, const Collision& b) {
  return (a.groups & b.with) != 0 && (b.groups & a.with) != 0;
}

}  // namespace pantin
