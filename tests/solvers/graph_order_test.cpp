// The order in which the rows of a sparse factor are stored: couplings lie near the diagonal.
#include "engine/solvers/articulated/impulses/graph_order.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>
#include <vector>

namespace {

using namespace pantin::detail;
using namespace pantin::detail::articulated;
using Edges = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Largest distance in the order between the ends of an edge.
std::uint32_t bandwidth(std::size_t count, const Edges& edges) {
  GroupScratch r;
  find_links(r, count, [&](auto&& visit) {
    for (const auto& [a, b] : edges) visit(a, b);
  });
  find_order(r, count);
  REQUIRE(r.roots.size() == count);
  for (std::uint32_t i = 0; i < count; ++i) CHECK(r.numbered[r.roots[i]] == i);
  std::uint32_t widest = 0;
  for (const auto& [a, b] : edges) {
    const std::uint32_t i = r.numbered[a], j = r.numbered[b];
    widest = std::max(widest, i > j ? i - j : j - i);
  }
  return widest;
}

/// A number that visits all vertices, in an order that has nothing to do with their neighbours.
std::uint32_t mixed(std::uint32_t i, std::uint32_t count) { return (i * 37 + 11) % count; }

}  // namespace

TEST_CASE("a path is ordered from one end to the other") {
  constexpr std::uint32_t kCount = 100;
  Edges path;
  for (std::uint32_t i = 1; i < kCount; ++i)
    path.emplace_back(mixed(i - 1, kCount), mixed(i, kCount));
  CHECK(bandwidth(kCount, path) == 1);
}

TEST_CASE("the bandwidth of a grid is about the number of its shorter side") {
  constexpr std::uint32_t kWide = 7, kLong = 41, kCount = kWide * kLong;
  Edges grid;
  for (std::uint32_t i = 0; i < kLong; ++i)
    for (std::uint32_t j = 0; j < kWide; ++j) {
      const std::uint32_t own = mixed(i * kWide + j, kCount);
      if (i + 1 < kLong) grid.emplace_back(own, mixed((i + 1) * kWide + j, kCount));
      if (j + 1 < kWide) grid.emplace_back(own, mixed(i * kWide + j + 1, kCount));
    }
  CHECK(bandwidth(kCount, grid) <= kWide + 1);
}

TEST_CASE("parts without edges between them, and single vertices, are all ordered") {
  CHECK(bandwidth(9, {{0, 8}, {8, 4}, {1, 5}, {5, 2}, {2, 1}}) <= 2);
  CHECK(bandwidth(3, {}) == 0);
}

namespace {

/// Blocks of the factor below the diagonal where vertices are eliminated in the order found.
std::size_t fill_of(std::uint32_t count, const Edges& edges) {
  GroupScratch r;
  find_links(r, count, [&](auto&& visit) {
    for (const auto& [a, b] : edges) visit(a, b);
  });
  find_elimination_order(r, count);
  std::vector<bool> seen(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    CHECK(r.numbered[r.roots[i]] == i);
    seen[r.roots[i]] = true;
  }
  CHECK(std::count(seen.begin(), seen.end(), true) == count);
  std::vector<FactorRow> rows(count);
  std::vector<std::uint32_t> scratch(BlockPattern::scratch_of(count, edges.size()));
  return BlockPattern{rows, {}, scratch}
             .size([&](auto&& visit) {
               for (const auto& [a, b] : edges) visit(r.numbered[a], r.numbered[b]);
             })
             .blocks -
         count;
}

}  // namespace

TEST_CASE("an elimination of paths and trees has no fill-in, that of a grid little") {
  Edges path, tree, grid;
  constexpr std::uint32_t kCount = 200, kWide = 14;
  for (std::uint32_t i = 1; i < kCount; ++i) {
    path.emplace_back(mixed(i - 1, kCount), mixed(i, kCount));
    tree.emplace_back(mixed((i - 1) / 3, kCount), mixed(i, kCount));
    if (i % kWide > 0) grid.emplace_back(mixed(i - 1, kCount), mixed(i, kCount));
    if (i >= kWide) grid.emplace_back(mixed(i - kWide, kCount), mixed(i, kCount));
  }
  CHECK(fill_of(kCount, path) == path.size());
  CHECK(fill_of(kCount, tree) == tree.size());
  CHECK(fill_of(kCount, grid) < 4 * grid.size());
}

TEST_CASE("large graphs have an order, too") {
  Edges path;
  for (std::uint32_t i = 1; i < 3000; ++i) path.emplace_back(i - 1, i);
  CHECK(fill_of(3000, path) == path.size());
}
