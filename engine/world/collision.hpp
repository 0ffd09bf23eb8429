#pragma once
/// Collision filters and surface properties.
#include <cstdint>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin {

/// A component: the body's Shapes collide. Bodies without it have no contacts.
///
/// A dynamic body collides with every fixed or kinematic body whose groups agree. Dynamic bodies
/// collide with one another only on request. Bodies connected by a joint never collide.
struct Collision {
  Real friction = 0.5;              // Coulomb; of two bodies the geometric mean counts
  Real restitution = 0;             // 0..1; of two bodies the larger counts
  std::uint32_t groups = 1;         // bits: groups that this body belongs to
  std::uint32_t with = UINT32_MAX;  // bits: groups that it collides with; both bodies must agree
  bool others = false;              // dynamic bodies of other islands too
  bool self = false;                // dynamic bodies of its own island too

  static void fields(auto& self, auto&& field) {
    field("friction", self.friction);
    field("restitution", self.restitution);
    field("groups", self.groups);
    field("with", self.with);
    field("others", self.others);
    field("self", self.self);
  }
};

}  // namespace pantin
