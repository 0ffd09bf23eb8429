// The factor of a sparse matrix of 6 x 6 blocks, against the matrix itself.
#include "engine/base/block_factor.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <vector>

#include "tests/base/random.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr std::size_t N = kFactorWide;
using Edges = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// A matrix with blocks at given places, and room for its factor.
struct Matrix {
  std::vector<FactorRow> rows;
  std::vector<std::uint32_t> columns, scratch;
  std::vector<Real> numbers, dense;
  BlockPattern::Size size;

  Matrix(Random& dice, std::size_t count, const Edges& edges)
      : rows(count),
        scratch(BlockPattern::scratch_of(count, edges.size())),
        dense(N * count * N * count) {
    const auto for_edges = [&](auto&& visit) {
      for (const auto& [a, b] : edges) visit(a, b);
    };
    size = BlockPattern{rows, {}, scratch}.size(for_edges);
    columns.resize(size.blocks), numbers.resize(kFactorBlock * size.blocks);
    BlockPattern{rows, columns, scratch}.find(for_edges);
    for (const auto& [a, b] : edges) fill(dice, std::max(a, b), std::min(a, b));
    for (std::size_t i = 0; i < count; ++i) {
      fill(dice, i, i);
      for (std::size_t r = 0; r < N; ++r) set(N * i + r, N * i + r, 60 + at(N * i + r, N * i + r));
    }
  }
  BlockFactor view() { return {{rows, columns, scratch}, numbers}; }
  Real at(std::size_t i, std::size_t j) const { return dense[i * N * rows.size() + j]; }

 private:
  /// Sets a number of the matrix, and the one across its diagonal.
  void set(std::size_t i, std::size_t j, Real x) {
    dense[i * N * rows.size() + j] = dense[j * N * rows.size() + i] = x;
    view().block(i / N, j / N)[j % N * N + i % N] = x;
    if (i / N == j / N) view().block(i / N, j / N)[i % N * N + j % N] = x;
  }
  void fill(Random& dice, std::size_t row, std::size_t column) {
    for (std::size_t r = 0; r < N; ++r)
      for (std::size_t c = 0; c < N; ++c) set(N * row + r, N * column + c, dice.between(-1, 1));
  }
};

Edges random_edges(Random& dice, std::uint32_t count, int each) {
  Edges edges;
  for (std::uint32_t i = 1; i < count; ++i)
    for (int n = 0; n < each; ++n)
      edges.emplace_back(i, static_cast<std::uint32_t>(dice.below(static_cast<int>(i))));
  return edges;
}

}  // namespace

TEST_CASE("what the factor solves satisfies the matrix, whatever its pattern") {
  Random dice(7);
  for (const std::uint32_t count : {1u, 2u, 5u, 30u})
    for (const int each : {1, 2, 4}) {
      Matrix m(dice, count, random_edges(dice, count, each));
      std::vector<Real> right(N * count);
      for (Real& x : right) x = dice.between(-1, 1);
      std::vector<Real> x = right;
      REQUIRE(m.view().pattern.blocks() == m.size.blocks);
      REQUIRE(m.view().factor());
      m.view().solve(x);
      for (std::size_t i = 0; i < x.size(); ++i) {
        Real sum = 0;
        for (std::size_t j = 0; j < x.size(); ++j) sum += m.at(i, j) * x[j];
        CHECK(std::abs(sum - right[i]) < 1e-13);
      }
    }
}

TEST_CASE("a pattern has the blocks of an elimination, row by row") {
  Random dice(9);
  for (int n = 0; n < 20; ++n) {
    const std::uint32_t count = 25;
    const Edges edges = random_edges(dice, count, 1 + n % 3);
    std::vector<std::set<std::uint32_t>> linked(count);
    for (const auto& [a, b] : edges) linked[a].insert(b), linked[b].insert(a);
    std::set<std::pair<std::uint32_t, std::uint32_t>> blocks;
    for (std::uint32_t i = 0; i < count; ++i)
      for (const std::uint32_t a : linked[i]) {
        if (a < i) continue;
        blocks.emplace(a, i);
        for (const std::uint32_t b : linked[i])
          if (b > i && b != a) linked[a].insert(b);
      }
    Matrix m(dice, count, edges);
    CHECK(m.size.blocks == blocks.size() + count);
    for (std::uint32_t i = 0; i < count; ++i)
      for (std::uint32_t e = m.rows[i].first; e < m.rows[i].diagonal; ++e)
        CHECK(blocks.count({i, m.columns[e]}) == 1);
  }
}

TEST_CASE("a matrix that is not positive definite has no factor") {
  Random dice(8);
  Matrix m(dice, 4, random_edges(dice, 4, 2));
  m.view().block(3, 3)[5 * N + 5] -= 200;
  CHECK_FALSE(m.view().factor());
}
