#include "engine/solvers/articulated/impulses/graph_order.hpp"

#include <algorithm>
#include <utility>

#include "engine/solvers/articulated/impulses/gather.hpp"

namespace pantin::detail::articulated {

namespace {

std::uint32_t degree(const GroupScratch& r, std::uint32_t i) { return r.ends[i + 1] - r.ends[i]; }

/// Numbers the vertices that are connected with `start`, in the order of their distance from it.
void number_from(GroupScratch& r, std::uint32_t start) {
  const auto add = [&](std::uint32_t i) {
    r.numbered[i] = static_cast<std::uint32_t>(r.roots.size()), r.roots.push_back(i);
  };
  const auto by_degree = [&](std::uint32_t i, std::uint32_t j) {
    return std::pair(degree(r, i), i) < std::pair(degree(r, j), j);
  };
  std::size_t next = r.roots.size();
  for (add(start); next < r.roots.size(); ++next) {
    const std::size_t first = r.roots.size();
    const std::uint32_t vertex = r.roots[next];
    for (std::uint32_t k = r.ends[vertex]; k < r.ends[vertex + 1]; ++k)
      if (r.numbered[r.links[k]] == kNone) add(r.links[k]);
    std::sort(r.roots.begin() + static_cast<std::ptrdiff_t>(first), r.roots.end(), by_degree);
    for (std::size_t i = first; i < r.roots.size(); ++i)
      r.numbered[r.roots[i]] = static_cast<std::uint32_t>(i);
  }
}

}  // namespace

void find_order(GroupScratch& r, std::size_t count) {
  r.roots.clear(), r.numbered.assign(count, kNone);
  while (r.roots.size() < count) {
    std::uint32_t start = kNone;
    for (std::uint32_t i = 0; i < count; ++i)
      if (r.numbered[i] == kNone && (start == kNone || degree(r, i) < degree(r, start))) start = i;
    const std::size_t before = r.roots.size();
    number_from(r, start);
    // The vertex found last is far from the start, and makes a better one.
    start = r.roots.back();
    for (std::size_t i = before; i < r.roots.size(); ++i) r.numbered[r.roots[i]] = kNone;
    r.roots.resize(before);
    number_from(r, start);
  }
}

}  // namespace pantin::detail::articulated
