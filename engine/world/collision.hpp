#pragma once
/// Collision filters and surface properties.
#include <cstdint>
#include <optional>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin {

/// A component: the body's Shapes collide. Bodies without it have no contacts.
///
/// A dynamic body collides with every body whose groups match, but not with those that a joint
/// connects it to. `others` and `self` switch off collisions with dynamic bodies, whatever solver
/// these name: bodies that may touch are stepped by one solver.
///
/// A sensor reports which bodies overlap it and exerts no force: see ContactEvents. It detects
/// every colliding body whose groups match, whatever `others` and `self` say. It ignores other
/// sensors, bodies that a joint connects to it and, if it is fixed itself, fixed bodies. Call
/// World::mark_dirty() after changing `sensor`.
///
/// A conveyor's surface moves although its body need not: friction acts on the velocity relative to
/// `surface_velocity`, without its component along the contact normal. The surface velocities of
/// two bodies add up. It may change at any time.
///
/// A one-way surface is solid only for bodies that approach from the side that `one_way` points to.
/// Other bodies pass through it until they have left it. A platform that can be jumped onto from
/// below has {0, 1, 0}. Not for bodies of the solver "quasistatic".
struct Collision {
  Real friction = 0.5;              // Coulomb; of two bodies the geometric mean counts
  Real restitution = 0;             // 0..1; of two bodies the larger counts; not below 0.05 m/s
  std::uint32_t groups = 1;         // bits: groups that this body belongs to
  std::uint32_t with = UINT32_MAX;  // bits: groups that it collides with; both bodies must agree
  bool others = true;               // collide with dynamic bodies of other islands; one of the two
                                    // suffices
  bool self = true;                 // collide with dynamic bodies of its own island; both must have
                                    // it
  bool sensor = false;              // reports overlaps, pushes nothing
  Real rolling = 0;          // m: rolling-resistance torque over normal force; the larger counts
  Real spinning = 0;         // m: the same for spinning about the normal; the larger counts
  Vec3 surface_velocity{0};  // m/s, in the frame by which the body is placed
  Vec3 one_way{0};           // out of the solid side, any length, same frame; zero: solid on both

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

/// Properties of a pair of materials, by index into World::materials. They hold where shapes of the
/// two materials touch, in either order; both may be the same. What it leaves out is combined from
/// the Collisions of the two bodies.
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

/// Whether the groups of two bodies match.
constexpr bool do_groups_agree(const Collision& a, const Collision& b) {
  return (a.groups & b.with) != 0 && (b.groups & a.with) != 0;
}

}  // namespace pantin
