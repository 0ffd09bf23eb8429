#pragma once
/// Distance joint: the anchors stay a length L > 0 apart: C = (d.d - L L) / (2 L), close to |d| -
/// L.
#include "engine/joints/kind.hpp"

namespace pantin::detail::joint_kinds {

struct distance : Line, TurnsFreely {
  static constexpr std::string_view name = "distance";
  static constexpr int rows = 1, degrees_of_freedom = 5;
  static constexpr FreeCoordinate coordinates[] = {{Coordinate::travel}};
  static constexpr Parameter parameters[] = {
      {.key = "length", .range = ParameterRange::size, .as_placed = true, .value = length}};
  static constexpr Mark marks[] = {Mark::rod};

  static Real gap(const Joint& joint, const Pose& a, const Pose& b) {
    return std::abs(glm::length(residual(joint, a, b)) - joint.parameters->length);
  }
  static void write(const Joint& joint, const BodyState& a, const BodyState& b, RowsOut out) {
    write_distance(0, joint.parameters->length, span_of(joint, a, b, out), out);
  }
};

}  // namespace pantin::detail::joint_kinds
