#pragma once
/// What ties bodies together and to the world.
#include "engine/base/fields.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/joints/string.hpp"
#include "engine/world/entity.hpp"

namespace pantin {

/// Two bodies and a joint. Either body may be the one nearer to the root. A joint that closes a loop
/// of dynamic bodies, or holds a tree once more, holds its point; the turns must follow from the
/// other joints.
struct Link {
  Entity a, b;
  Joint joint;

  static void fields(auto& self, auto&& field) {
    field("a", self.a);
    field("b", self.b);
    field("joint", self.joint);
  }
};

/// Two bodies and a string.
struct String {
  Entity a, b;
  StringJoint joint;
  Real tension = 0;  // N, mean over the last step; 0 when slack

  static void fields(auto& self, auto&& field) {
    field("a", self.a);
    field("b", self.b);
    field("joint", self.joint);
    field("tension", passive(self.tension));
  }
};

/// Couples a freedom of one link to a freedom of another, as gears, belts and racks do:
///
///   coordinate of second = ratio * coordinate of first + offset
///
/// Only the Lagrangian solver knows it. Turns are counted in whole from the pose the World was
/// given in; `offset` then follows from that pose where it is not set.
struct Ratio {
  Entity first, second;                      // links with a hinge, slide or screw
  bool slides_first = false;                 // the slide along x (m) of `first`, not its turn (rad)
  bool slides_second = false;                // likewise
  Real ratio = 1;                            // rad/rad, m/rad ...
  Real offset = 0;                           // rad or m
  bool has_offset = false;

  static void fields(auto& self, auto&& field) {
    field("first", self.first);
    field("second", self.second);
    field("slides_first", self.slides_first);
    field("slides_second", self.slides_second);
    field("ratio", self.ratio);
    field("offset", self.offset);
    field("has_offset", self.has_offset);
  }
};

enum class Grip : std::uint8_t {
  exact,   // the point goes to its target, whatever it weighs
  spring,  // the point is drawn by a damped spring of `stiffness`
};
constexpr Grip last_of(Grip) { return Grip::spring; }

/// A point of a body held at a place in the world, or at a point of another body: a nail, a hand.
struct Pin {
  Entity body;
  Vec3 anchor{0};    // in the body's mass-centre frame
  Vec3 target{0};    // world, m; where `to` names a body: in its mass-centre frame
  Entity to{};       // the body that is held on to, or none
  int priority = 0;  // of several exact pins the highest is met exactly
  Grip grip = Grip::exact;
  Real stiffness = 200;  // N/m, for a spring grip
  // What the last step left:
  Real residual = 0;      // m, distance of the point from its target
  bool missed = false;    // exact: that is more than the solver's tolerance
  bool reachable = true;  // false: the links between this pin and a better one are too short

  static void fields(auto& self, auto&& field) {
    field("body", self.body);
    field("anchor", self.anchor);
    field("target", self.target);
    field("to", self.to);
    field("priority", self.priority);
    field("grip", self.grip);
    field("stiffness", self.stiffness);
    field("residual", passive(self.residual));
    field("missed", passive(self.missed));
    field("reachable", passive(self.reachable));
  }
};

}  // namespace pantin
