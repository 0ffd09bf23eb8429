#pragma once
/// On which side of each pulley a belt runs.
///
/// Internal (pantin::detail).
#include <vector>

#include "engine/world/belt.hpp"

namespace pantin::detail {

struct BeltSides {
  std::vector<bool> is_outside;  // by pulley: it touches the belt from outside the loop
  bool crossed = false;          // spans may cross; with two pulleys the second turns the other way
};

/// Finds the sense of each pulley and lays the belt. Returns its fault in words ("pulleys 0 and 1
/// ..., expected ..."), or an empty string.
std::string lay_round(Belt& belt, PulleyPoses bodies, const BeltSides& sides);

}  // namespace pantin::detail
