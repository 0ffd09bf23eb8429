#pragma once
/// Connections between bodies: links, cables, gears and pins. The descriptions of
/// <pantin/joints.hpp> are converted to links, cables and gears.
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/joints/cable.hpp"
#include "engine/joints/joint.hpp"
#include "engine/world/entity.hpp"

namespace pantin {

namespace detail {

/// Two bodies and a joint. Either body may be the one nearer to the root. A joint that closes a
/// loop of dynamic bodies, or anchors a tree a second time, constrains its point only; the
/// rotations must follow from the other joints.
struct Link {
  Entity a, b;
  Joint joint;

  static void fields(auto& self, auto&& field) {
    field("a", self.a);
    field("b", self.b);
    field("joint", self.joint);
  }
};

/// A guide of a frictionless cable: a ring, or the groove of a pulley.
struct CableGuide {
  Entity body;
  Vec3 anchor{0};  // in the body's mass-centre frame
  Vec3 axis{0, 0,
            1};     // likewise, of unit length; from a to b the cable runs round it anticlockwise
  Real radius = 0;  // m, of the pulley; 0: a ring
  // Angle of wrap after the last step, rad, whole turns counted; the first is within half a turn.
  Real wrap = kFirstWrap;

  static void fields(auto& self, auto&& field) {
    field("body", self.body);
    field("anchor", self.anchor);
    field("axis", self.axis);
    field("radius", self.radius);
    field("wrap", self.wrap);
  }
};

/// Two bodies and a cable from a to b over guides.
struct Cable {
  Entity a, b;
  CableParameters joint;
  Real tension = 0;                     // N, mean over the last step; 0 when slack
  std::vector<CableGuide> guides = {};  // only the Lagrangian solver supports them

  static void fields(auto& self, auto&& field) {
    field("a", self.a);
    field("b", self.b);
    field("joint", self.joint);
    field("guides", self.guides);
    field("tension", passive(self.tension));
  }
};

/// Couples a coordinate of one link to a coordinate of another, as gears, belts and racks do:
///
///   coordinate of second = ratio * coordinate of first + offset
///
/// Only the Lagrangian solver supports it. Whole turns are counted from the initial pose; an
/// `offset` that is not set follows from that pose.
struct Gear {
  Entity first, second;         // links with a hinge, prismatic joint or screw
  bool first_travels = false;   // the travel along x (m) of `first`, not its angle (rad)
  bool second_travels = false;  // likewise
  Real ratio = 1;               // rad/rad, m/rad ...
  Real offset = 0;              // rad or m
  bool has_offset = false;

  static void fields(auto& self, auto&& field) {
    field("first", self.first);
    field("second", self.second);
    field("first_travels", self.first_travels);
    field("second_travels", self.second_travels);
    field("ratio", self.ratio);
    field("offset", self.offset);
    field("has_offset", self.has_offset);
  }
};

}  // namespace detail

enum class PinKind : std::uint8_t {
  exact,   // a hard constraint: the point reaches its target
  spring,  // a spring of `stiffness` with a damper of `damping`
};
constexpr PinKind last_of(PinKind) { return PinKind::spring; }

/// A pin constraint: a point of a body held at a point of the world or of another body.
struct Pin {
  Entity body;
  Vec3 anchor{0};    // in the body's mass-centre frame
  Vec3 target{0};    // world, m; where `to` names a body: in its mass-centre frame
  Entity to{};       // the other body, or none
  int priority = 0;  // among exact pins that conflict, the highest priority is met exactly
  PinKind kind = PinKind::exact;
  Real stiffness = 200;  // N/m, of a spring
  Real damping = 0;      // N s/m, likewise, of the point's velocity relative to its target
  // Results of the last step:
  Real residual = 0;    // m, distance of the point from its target
  bool missed = false;  // exact pins: `residual` exceeds the solver's tolerance
  bool reachable =
      true;  // false: the links between this pin and one of higher priority are too short

  static void fields(auto& self, auto&& field) {
    field("body", self.body);
    field("anchor", self.anchor);
    field("target", self.target);
    field("to", self.to);
    field("priority", self.priority);
    field("kind", self.kind);
    field("stiffness", self.stiffness);
    field("damping", self.damping);
    field("residual", passive(self.residual));
    field("missed", passive(self.missed));
    field("reachable", passive(self.reachable));
  }
};

}  // namespace pantin
