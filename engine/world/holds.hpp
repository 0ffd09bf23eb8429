#pragma once
/// Upper bounds on the number of constraints that hold one body.
///
/// Internal (pantin::detail).
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

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
/// The same for joints between the same two dynamic bodies.
inline constexpr HoldBound kJointsOfPair{"joints between the same two bodies", 128};

/// A joint, and the indices of its two bodies.
struct PairedJoint {
  std::uint32_t joint, a, b;
};
/// The joints of a pair of bodies: their number, and the first of them.
struct JointsOfPair {
  std::size_t count;
  PairedJoint first;
};
/// The pairs with more joints than kJointsOfPair.
inline std::vector<JointsOfPair> list_crowded_pairs(std::vector<PairedJoint> joints) {
  const auto pair = [](const PairedJoint& j) { return std::minmax(j.a, j.b); };
  std::stable_sort(joints.begin(), joints.end(),
                   [&](const PairedJoint& j, const PairedJoint& k) { return pair(j) < pair(k); });
  std::vector<JointsOfPair> crowded;
  for (std::size_t first = 0, end = 0; first < joints.size(); first = end) {
    while (end < joints.size() && pair(joints[end]) == pair(joints[first])) ++end;
    if (end - first > kJointsOfPair.most) crowded.push_back({end - first, joints[first]});
  }
  return crowded;
}

}  // namespace pantin::detail
