#include "engine/solvers/articulated/impulses/graph_order.hpp"

#include <algorithm>
#include <bit>
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

namespace {

/// Vertices: the fill-in of larger graphs is not followed, at a bit for each pair.
constexpr std::size_t kMostByDegree = 1024;

/// Sets of neighbours as bits.
struct Neighbours {
  GroupScratch& r;
  std::size_t words;

  std::uint64_t* of(std::uint32_t i) const { return &r.fill[i * words]; }
  void set(std::uint32_t i, std::uint32_t j) const {
    of(i)[j / 64] |= std::uint64_t{1} << (j % 64);
  }
  void count(std::uint32_t i) const {
    r.degrees[i] = 0;
    for (std::size_t k = 0; k < words; ++k)
      r.degrees[i] += static_cast<std::uint32_t>(std::popcount(of(i)[k]));
  }
  /// Connects the neighbours of a vertex with one another, and takes it away.
  void eliminate(std::uint32_t vertex) const {
    const std::uint64_t* const own = of(vertex);
    for (std::size_t k = 0; k < words; ++k)
      for (std::uint64_t left = own[k]; left != 0; left &= left - 1) {
        const auto i =
            static_cast<std::uint32_t>(64 * k) + static_cast<std::uint32_t>(std::countr_zero(left));
        std::uint64_t* const other = of(i);
        for (std::size_t n = 0; n < words; ++n) other[n] |= own[n];
        for (const std::uint32_t gone : {vertex, i})
          other[gone / 64] &= ~(std::uint64_t{1} << (gone % 64));
        count(i);
      }
    r.degrees[vertex] = kNone;
  }
};

}  // namespace

void find_elimination_order(GroupScratch& r, std::size_t count) {
  if (count > kMostByDegree) {
    find_order(r, count);
    std::reverse(r.roots.begin(), r.roots.end());
  } else {
    const Neighbours all{r, (count + 63) / 64};
    r.fill.assign(count * all.words, 0), r.degrees.resize(count), r.roots.clear();
    for (std::uint32_t i = 0; i < count; ++i) {
      for (std::uint32_t k = r.ends[i]; k < r.ends[i + 1]; ++k)
        if (r.links[k] != i) all.set(i, r.links[k]);
      all.count(i);
    }
    while (r.roots.size() < count) {
      const auto least = std::min_element(r.degrees.begin(), r.degrees.end());
      r.roots.push_back(static_cast<std::uint32_t>(least - r.degrees.begin()));
      all.eliminate(r.roots.back());
    }
  }
  r.numbered.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) r.numbered[r.roots[i]] = i;
}

}  // namespace pantin::detail::articulated
