#pragma once
/// Disjoint sets (union-find).
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace pantin::detail {

/// Numbers below `count`, merged into sets one pair at a time. The representative of a set is its
/// lowest number.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) { reset(count); }
  /// Makes each number a set of its own again; keeps its memory.
  void reset(std::size_t count) {
    parent_.resize(count);
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace pantin::detail
