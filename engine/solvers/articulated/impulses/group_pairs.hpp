#pragma once
/// Pairs of bodies of a group that touch, and the batches of those that are solved side by side.
#include <cstddef>
#include <cstdint>

#include "engine/solvers/articulated/lane_layout.hpp"

namespace pantin::detail::articulated {

/// At most kMostPoints consecutive contacts of the same two bodies, iterated together.
struct GroupPair {
  std::uint32_t first = 0, count = 0;  // contacts
  std::uint32_t working = 0;           // of these, active
  std::size_t responses = 0;           // in GroupScratch::number_list, see prepare_pair()
  bool in_lanes = false;               // solved beside others, except in hard substeps
};
inline constexpr std::uint32_t kMostPoints = 8;

/// A pair in lanes. No body that moves is in two pairs of a colour.
struct LanedPair {
  std::uint32_t pair = 0, colour = 0;
};
/// Pairs of a colour that are solved side by side in a substep (group_lanes.cpp).
struct PairBatch {
  std::uint32_t pairs[kPairLanes] = {};
  std::uint32_t count = 0, points = 0;  // of the pairs; of the pair with the most active points
  std::uint32_t colour = 0;
  std::size_t numbers = 0;  // in Group::numbers
};

}  // namespace pantin::detail::articulated
