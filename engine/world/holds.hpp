#pragma once
/// How many things may hold one body at places in the World.
///
/// Internal (pantin::detail).
#include <cstddef>
#include <string_view>

namespace pantin::detail {

/// So many of these, as messages call them.
struct HoldBound {
  std::string_view what;
  std::size_t most;
};

/// Exact pins of a body under `lagrangian`. Three that do not lie in a line hold all of it; each
/// further one is redundant, and the equations of those at one body are dense: time grows with the
/// cube of their number (64: 0.3 s a step, 400: 35 s), memory likewise.
inline constexpr HoldBound kExactPins{"exact pins", 64};
/// Likewise of joints to the World or to bodies that are not dynamic (128: 0.3 s a step).
inline constexpr HoldBound kJointsToFixed{"joints to fixed bodies", 128};

}  // namespace pantin::detail
