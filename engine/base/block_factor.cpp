#include "engine/base/block_factor.hpp"

#include "engine/base/dense_blocks.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t N = kFactorWide;
constexpr BlockSize kBlock{N, N};
constexpr PairSize kPair{N, N, N};

}  // namespace

Real* BlockFactor::block(std::size_t row, std::size_t column) const {
  const FactorRow& r = pattern.rows[row];
  const auto first = pattern.columns.begin() + r.first, end = pattern.columns.begin() + r.diagonal;
  const auto at = std::lower_bound(first, end, column);
  PANTIN_ASSERT(*at == column);
  return numbers.data() + kFactorBlock * static_cast<std::size_t>(at - pattern.columns.begin());
}

bool BlockFactor::factor() const {
  Real y[kFactorBlock];
  const auto at = [&](std::uint32_t place) { return numbers.data() + kFactorBlock * place; };
  const std::span<std::uint32_t> place = pattern.scratch;  // of the row's blocks, by column
  for (const FactorRow& row : pattern.rows) {
    for (std::uint32_t e = row.first; e < row.diagonal; ++e) place[pattern.columns[e]] = e;
    // While the row is processed its blocks hold L^-1 A; afterwards D^-1 L^-1 A.
    for (std::uint32_t e = row.first; e < row.diagonal; ++e) {
      const FactorRow& other = pattern.rows[pattern.columns[e]];
      for (std::uint32_t f = other.first; f < other.diagonal; ++f) {
        const std::uint32_t own = place[pattern.columns[f]];
        if (own >= row.first && own < e && pattern.columns[own] == pattern.columns[f])
          subtract_product<N>(at(f), at(own), at(e), kPair);
      }
      solve_lower<N>(at(other.diagonal), at(e), y, kBlock);
      std::copy_n(y, kFactorBlock, at(e));
    }
    Real* const diagonal = at(row.diagonal);
    for (std::uint32_t e = row.first; e < row.diagonal; ++e) {
      Real* const own = at(e);
      const Real* const d = at(pattern.rows[pattern.columns[e]].diagonal);
      std::copy_n(own, kFactorBlock, y);
      for (std::size_t r = 0; r < N; ++r)
        for (std::size_t c = 0; c < N; ++c) own[r * N + c] *= d[r * N + r];
      subtract_product<N>(own, y, diagonal, kPair);
    }
    if (!(diagonal[0] > 0) || decompose<N>(diagonal, N, {}) > 0) return false;
  }
  return true;
}

void BlockFactor::solve(std::span<Real> x) const {
  const std::span<const FactorRow> rows = pattern.rows;
  PANTIN_ASSERT(x.size() == N * rows.size());
  const auto at = [&](std::uint32_t place) { return numbers.data() + kFactorBlock * place; };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Real* own = &x[N * i];
    for (std::uint32_t e = rows[i].first; e < rows[i].diagonal; ++e)
      update_forward<N>(at(e), &x[N * pattern.columns[e]], own, kBlock);
    const Real* d = at(rows[i].diagonal);
    for (std::size_t r = 1; r < N; ++r)
      for (std::size_t k = 0; k < r; ++k) own[r] -= d[r * N + k] * own[k];
  }
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t r = 0; r < N; ++r) x[N * i + r] *= at(rows[i].diagonal)[r * N + r];
  for (std::size_t i = rows.size(); i-- > 0;) {
    Real* own = &x[N * i];
    const Real* d = at(rows[i].diagonal);
    for (std::size_t r = N; r-- > 1;)
      for (std::size_t k = 0; k < r; ++k) own[k] -= d[r * N + k] * own[r];
    for (std::uint32_t e = rows[i].first; e < rows[i].diagonal; ++e)
      update_back<N>(at(e), &x[N * pattern.columns[e]], own, kBlock);
  }
}

}  // namespace pantin::detail
