#pragma once
/// No constraint: a spring and damper between the anchors, given by parameters->translation.
#include "engine/joints/kind.hpp"

namespace pantin::detail::joint_kinds {

struct spring : Line, TurnsFreely {
  static constexpr std::string_view name = "spring";
  static constexpr int rows = 0, degrees_of_freedom = 6;
  static constexpr FreeCoordinate coordinates[] = {{Coordinate::travel}};
  static constexpr Parameter parameters[] = {
      {.key = "length", .range = ParameterRange::not_negative, .as_placed = true, .value = length},
      {.key = "stiffness",
       .needed = "its stiffness, in N/m",
       .range = ParameterRange::not_negative,
       .value = [](JointParameters& own) -> Real& { return own.translation.spring.stiffness; }},
      {.key = "damping",
       .range = ParameterRange::not_negative,
       .value = [](JointParameters& own) -> Real& { return own.translation.spring.damping; }}};
  static constexpr Mark marks[] = {Mark::zigzag};

  static void complete(JointParameters& own) { own.translation.spring.rest = own.length; }
  static Real gap(const Joint&, const Pose&, const Pose&) { return 0; }
  static void write(const Joint&, const BodyState&, const BodyState&, RowsOut) {}
};

}  // namespace pantin::detail::joint_kinds
