#pragma once
/// On which side of each pulley a belt runs.
///
/// Internal (pantin::detail).
#include <vector>

#include "engine/world/belt.hpp"

namespace pantin::detail {

struct BeltSides {
  std::vector<bool> is_outside;  // by pulley: it presses on the belt from outside
  bool crossed = false;          // spans may cross; of two pulleys: round the second the other way
};

/// Finds the sense of each pulley and lays the belt. What is wrong with it, in words ("pulleys 0
/// and 1 ..., expected ..."), or empty.
std::string lay_round(Belt& belt, PulleyPoses bodies, const BeltSides& sides);

}  // namespace pantin::detail
