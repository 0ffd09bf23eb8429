#pragma once
/// Belts: closed, flat, taut, without mass, round pulleys that turn about z.
///
/// Internal (pantin::detail); installed because World::belts holds them.
#include <span>
#include <string>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/joints/belt_path.hpp"
#include "engine/world/entity.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail {

inline constexpr std::size_t kMostPulleys = 16;
inline constexpr Real kBeltThickness = 0.25;  // of the width, as drawn and of links

struct BeltPulley {
  Entity body;
  Vec3 anchor{0};          // its centre, in the body's mass-centre frame
  Quat frame{1, 0, 0, 0};  // likewise: the pulley's axes, z along that of the plane
  Real sense = 1;          // 1: the belt runs round it anticlockwise; -1
  BeltOutline outline;
  // After the last step; whole turns counted.
  Real angle = 0;      // rad, of the pulley's axes
  Real direction = 0;  // rad, of the span that leaves it
  Real offset = 0;     // m: C_0 of that span
  // Results of the last step, of that span:
  Real tension = 0;  // N, mean; see Belt

  static void fields(auto& self, auto&& field) {
    field("body", self.body);
    field("anchor", self.anchor);
    field("frame", self.frame);
    field("sense", self.sense);
    field("outline", self.outline);
    field("angle", self.angle);
    field("direction", self.direction);
    field("offset", self.offset);
    field("tension", passive(self.tension));
  }
};

/// Pulleys in the order in which the belt meets them; from the last one it goes to the first.
///
/// Every span is a row, so the belt keeps its length and slips nowhere. Where all axles are held by
/// one body, the last row follows from the others for round pulleys; for others it cannot be held.
/// Its span, that to the first pulley, is left to itself then: `defect` tells how much longer its
/// way is than the belt. Tensions are those beyond that of this span, or beyond `pretension`.
struct Belt {
  std::vector<BeltPulley> pulleys;
  Real turning = 0;     // rad, of the belt's direction in one round: whole turns
  Real friction = 0;    // of two pulleys; 0: it never slips
  Real pretension = 0;  // N
  Real width = 0.04;    // m, along z, as drawn
  std::uint32_t material = 0;
  Real travel = 0;  // m, by which the belt has run past the first pulley
  // Results of the last step.
  Real length = 0;  // m, of the way
  Real defect = 0;  // m, by which the way is longer than when the belt was laid
  bool slips = false;

  static void fields(auto& self, auto&& field) {
    field("pulleys", self.pulleys);
    field("turning", self.turning);
    field("friction", self.friction);
    field("pretension", self.pretension);
    field("width", passive(self.width));
    field("material", passive(self.material));
    field("travel", self.travel);
    field("length", passive(self.length));
    field("defect", passive(self.defect));
    field("slips", passive(self.slips));
  }
};

/// A pulley where its body stands; its angle is the nearest to the one before.
BeltPlace place_of(const BeltPulley& pulley, const Pose& body);

/// Poses of the bodies of a belt's pulleys, in their order.
using PulleyPoses = std::span<const Pose>;

/// Lays a belt: finds the angles, directions and offsets, the turning and the length. False where
/// two pulleys that follow one another are within one another.
bool lay_belt(Belt& belt, PulleyPoses bodies);

/// After a step: takes the angles of the pulleys, rad, whole turns counted, and what follows from
/// them.
void follow_belt(Belt& belt, PulleyPoses bodies, std::span<const Real> angles);

/// Lays a span anew, that of a belt which has slipped.
void lay_mark(Belt& belt, std::size_t span, PulleyPoses bodies);

/// How many spans of a belt are rows: all, or all but the last. See Belt.
std::size_t held_spans(const World& world, const Belt& belt);

/// N: the largest difference of its two tensions without a slip, of two pulleys. (Euler's capstan)
Real grip_of(const Belt& belt);

/// What is wrong with a belt that has been laid, in words; empty if nothing is.
enum class Crossing : std::uint8_t { refused, allowed };
std::string fault_of(const Belt& belt, PulleyPoses bodies, Crossing crossing);

/// Appends the closed way of a belt as it lies, m, arcs in steps of no more than `turn` rad.
void trace_belt(const Belt& belt, PulleyPoses bodies, Real turn, std::vector<Vec3>& to);

}  // namespace pantin::detail
