#pragma once
/// What may touch what, and the places where it does.
#include <cstdint>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/world/entity.hpp"

namespace pantin {

struct Articulation;

/// A component: the body's Shapes are solid. Bodies without it touch nothing.
///
/// A dynamic body touches every fixed or driven one whose groups agree. Dynamic bodies touch one
/// another only where asked for. Bodies of one joint never touch.
struct Collision {
  Real friction = 0.5;              // Coulomb; of two bodies the geometric mean counts
  Real restitution = 0;             // 0..1; of two bodies the larger counts
  std::uint32_t groups = 1;         // bits: what this body is
  std::uint32_t with = UINT32_MAX;  // bits: what it touches; both have to agree
  bool others = false;              // dynamic bodies of other articulations too
  bool self = false;                // dynamic bodies of its own articulation too

  static void fields(auto& self, auto&& field) {
    field("friction", self.friction);
    field("restitution", self.restitution);
    field("groups", self.groups);
    field("with", self.with);
    field("others", self.others);
    field("self", self.self);
  }
};

/// One point where two bodies touch or are about to.
struct Contact {
  std::uint32_t slot_a = 0, slot_b = 0;  // in World::bodies; a is dynamic
  std::uint64_t key = 0;                 // the shapes and features concerned: the same next step
  Vec3 point_a{0}, point_b{0};           // in the bodies' mass-centre frames, m
  Vec3 normal{0, 1, 0};                  // unit, world, from b to a
  Real gap = 0;                          // m, at the start of the step; below 0: overlap
  Real friction = 0, restitution = 0;
  // What the step left:
  Vec3 load{0};        // multiplier on a, kg m, world
  Vec3 before{0};      // the same after the step before
  Real sliding = 1;    // part of the sticking load that friction can bear; 1: sticks
  Real impact = 0;     // m/s, approach not yet given back by restitution
  bool active = false; // bears a load
  Vec3 force{0};       // N, on a, mean over the step
  Real depth = 0;      // m, overlap left after the step, never negative

  static void fields(auto& self, auto&& field) {
    field("slot_a", self.slot_a);
    field("slot_b", self.slot_b);
    field("key", self.key);
    field("point_a", passive(self.point_a));
    field("point_b", passive(self.point_b));
    field("normal", passive(self.normal));
    field("gap", passive(self.gap));
    field("friction", passive(self.friction));
    field("restitution", passive(self.restitution));
    field("load", self.load);
    field("before", passive(self.before));
    field("sliding", self.sliding);
    field("impact", self.impact);
    field("active", passive(self.active));
    field("force", passive(self.force));
    field("depth", passive(self.depth));
  }
};

/// Room for contacts, kept between steps.
struct TouchRoom {
  std::vector<Real> reach;  // m, by body slot: how far its surface may move in the step
  std::vector<Pose> ends;   // poses of driven bodies at the end of the step
  std::vector<Articulation*> mutual;
  bool stale = false;  // bodies were numbered anew: contacts are to be looked for again
};

}  // namespace pantin
