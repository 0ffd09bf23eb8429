#pragma once
/// What may touch what.
#include <cstdint>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin {

/// A component: the body's Shapes are solid. Bodies without it touch nothing.
///
/// A dynamic body touches every fixed or driven one whose groups agree. Dynamic bodies touch one
/// another only where asked for. Bodies of one joint never touch.
struct Collision {
  Real friction = 0.5;              // Coulomb; of two bodies the geometric mean counts
  Real restitution = 0;             // 0..1; of two bodies the larger counts
  std::uint32_t groups = 1;         // bits: what this body is
  std::uint32_t with = UINT32_MAX;  // bits: what it touches; both have to agree
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
