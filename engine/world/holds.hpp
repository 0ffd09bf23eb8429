#pragma once
/// Upper bounds on the number of constraints that hold one body in the World.
///
/// Internal (pantin::detail).
#include <cstddef>
#include <string_view>

namespace pantin::detail {

/// A bound, and the name of the constraints in messages.
struct HoldBound {
  std::string_view what;
  std::size_t most;
};

/// Exact pins of a body under `lagrangian`. Three that are not collinear hold it completely; each
/// further pin is redundant. The equations of pins on one body are dense: time grows with the cube
/// of their number (64: 0.3 s a step, 400: 35 s), and so does memory.
inline constexpr HoldBound kExactPins{"exact pins", 64};
/// The same for joints to the World or to bodies that are not dynamic (128: 0.3 s a step).
inline constexpr HoldBound kJointsToFixed{"joints to fixed bodies", 128};

}  // namespace pantin::detail
