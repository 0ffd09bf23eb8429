#pragma once
/// Belts: closed, flat, taut and massless, around round pulleys that turn about z.
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
  // State after the last step; whole turns are counted.
  Real angle = 0;      // rad, of the pulley's axes
  Real direction = 0;  // rad, of the span that leaves it
  Real offset = 0;     // m: C_0 of that span
  // Results of the last step, for the span that leaves this pulley:
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

/// Pulleys in the order in which the belt meets them; it returns from the last to the first.
///
/// Each span is a constraint row, so the belt keeps its length and does not slip. If one body
/// carries all axles, the rows of round pulleys are dependent and the last one is redundant; for
/// other outlines it cannot be satisfied. The last span (to the first pulley) then has no row, and
/// `defect` reports by how much the route is longer than the belt. Tensions are relative to that
/// span, or to `pretension`.
struct Belt {
  std::vector<BeltPulley> pulleys;
  Real turning = 0;     // rad, by which the belt's direction rotates in one round: whole turns
  Real friction = 0;    // coefficient, belts of two pulleys only; 0: it never slips
  Real pretension = 0;  // N
  Real width = 0.04;    // m, along z, as drawn
  std::uint32_t material = 0;
  Real travel = 0;  // m, of belt that has run past the first pulley
  // Results of the last step.
  Real length = 0;  // m, of the route
  Real defect = 0;  // m, by which the route is longer than when the belt was laid
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

/// The pulley at the present pose of its body; its angle continues from the previous one.
BeltPlace place_of(const BeltPulley& pulley, const Pose& body);

/// Poses of the bodies of a belt's pulleys, in their order.
using PulleyPoses = std::span<const Pose>;

/// Lays a belt: computes angles, directions, offsets, total rotation and length. Returns false if
/// two consecutive pulleys overlap.
bool lay_belt(Belt& belt, PulleyPoses bodies);

/// Updates a belt after a step from the pulley angles, rad, whole turns counted.
void follow_belt(Belt& belt, PulleyPoses bodies, std::span<const Real> angles);

/// Lays one span again, after the belt has slipped.
void lay_mark(Belt& belt, std::size_t span, PulleyPoses bodies);

/// The number of spans that have a constraint row: all, or all but the last. See Belt.
std::size_t held_spans(const World& world, const Belt& belt);

/// Largest difference of the two tensions without slip, N, for two pulleys (Euler's capstan
/// equation).
Real grip_of(const Belt& belt);

/// The fault of a belt that has been laid, in words; empty if there is none.
enum class Crossing : std::uint8_t { refused, allowed };
std::string fault_of(const Belt& belt, PulleyPoses bodies, Crossing crossing);

/// Appends the closed route of a belt, m; arcs are divided into steps of at most `turn` rad.
void trace_belt(const Belt& belt, PulleyPoses bodies, Real turn, std::vector<Vec3>& to);

}  // namespace pantin::detail
