#pragma once
/// How much friction a motion tolerates that was planned without friction.
#include <limits>

#include "engine/modes/prepare.hpp"

namespace pantin::detail::modes {

/// Add the poses of a path in order. Bounds hold at the poses added, not between them.
struct PathBound {
  int poses = 0;
  int without_plan = 0;  // poses at which no mode of three sliding contacts holds without friction
  /// The mode holds at every pose for all coefficients from 0 to this, independent of each other.
  Real each = std::numeric_limits<Real>::infinity();
  /// It holds for one coefficient common to all contacts, from 0 to this.
  Real common = std::numeric_limits<Real>::infinity();
  int pose_of_each = -1, pose_of_common = -1;  // where the bounds were found
  int changes = 0;                             // of the three contacts, between neighbouring poses
  std::array<std::uint8_t, 3> contacts{};

  void add(const Prepared& pose);
};

}  // namespace pantin::detail::modes
