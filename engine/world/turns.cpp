#include "engine/world/turns.hpp"

#include <algorithm>
#include <tuple>

namespace pantin::detail {
namespace {

auto order(const TurnCount& c) { return std::tuple(c.joint.index, c.coordinate); }

}  // namespace

void sort(TurnCounts& counts) {
  std::stable_sort(counts.begin(), counts.end(),
                   [](const TurnCount& c, const TurnCount& d) { return order(c) < order(d); });
  const auto is_one = [](const TurnCount& c, const TurnCount& d) { return order(c) == order(d); };
  counts.erase(std::unique(counts.begin(), counts.end(), is_one), counts.end());
}

const Real* find_count(std::span<const TurnCount> counts, Entity joint, Coordinate coordinate) {
  const auto wanted = std::tuple(joint.index, coordinate);
  const auto at = std::lower_bound(counts.begin(), counts.end(), wanted,
                                   [](const TurnCount& c, auto key) { return order(c) < key; });
  const bool is_found = at != counts.end() && order(*at) == wanted && at->joint == joint;
  return is_found ? &at->value : nullptr;
}

}  // namespace pantin::detail
