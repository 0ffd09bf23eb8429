#pragma once
/// Holds nothing: a spring and damper between the anchors, told by extras->slide.
#include "engine/joints/kind.hpp"

namespace pantin::joint_kinds {

struct spring : Line, TurnsFreely {
  static constexpr std::string_view name = "spring";
  static constexpr int rows = 0, freedoms = 6;
  static constexpr FreeCoordinate coordinates[] = {{Coordinate::slide}};
  static constexpr Parameter parameters[] = {
      {.key = "length",
       .range = ParameterRange::not_negative,
       .as_placed = true,
       .value = length},
      {.key = "stiffness",
       .needed = "how hard it pulls, in N/m",
       .range = ParameterRange::not_negative,
       .value = [](JointExtras& extras) -> Real& { return extras.slide.spring.stiffness; }},
      {.key = "damping",
       .range = ParameterRange::not_negative,
       .value = [](JointExtras& extras) -> Real& { return extras.slide.spring.damping; }}};
  static constexpr Mark marks[] = {Mark::zigzag};

  static void complete(JointExtras& extras) { extras.slide.spring.rest = extras.length; }
  static Real gap(const Joint&, const Pose&, const Pose&) { return 0; }
  static void write(const Joint&, const Placed&, const Placed&, RowsOut) {}
};

}  // namespace pantin::joint_kinds
