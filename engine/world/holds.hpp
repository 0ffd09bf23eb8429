#pragma once
/// How many things may hold one body at places in the World.
///
/// Internal (pantin::detail).
#include <cstddef>

namespace pantin::detail {

/// Exact pins of a body under `lagrangian`. Three that do not lie in a line hold all of it; each
/// further one is redundant, and the equations of those at one body are dense: time grows with the
/// cube of their number (64: 0.3 s a step, 400: 35 s), memory likewise.
inline constexpr std::size_t kMostExactPins = 64;
/// Likewise of joints to the World or to bodies that are not dynamic (128: 0.3 s a step).
inline constexpr std::size_t kMostJointsToFixed = 128;

}  // namespace pantin::detail
