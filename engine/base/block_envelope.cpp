#include "engine/base/block_envelope.hpp"

#include <algorithm>

#include "engine/base/dense_blocks.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t N = kEnvelopeWide;
constexpr BlockSize kBlock{N, N};
constexpr PairSize kPair{N, N, N};

}  // namespace

bool BlockEnvelope::factor() const {
  Real y[kEnvelopeBlock];
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t first = rows[i].first;
    PANTIN_ASSERT(first <= i);
    // While the row is processed its blocks hold L^-1 A; afterwards D^-1 L^-1 A.
    for (std::size_t j = first; j < i; ++j) {
      Real* own = block(i, j);
      for (std::size_t k = std::max<std::size_t>(first, rows[j].first); k < j; ++k)
        subtract_product<N>(block(j, k), block(i, k), own, kPair);
      solve_lower<N>(block(j, j), own, y, kBlock);
      std::copy_n(y, kEnvelopeBlock, own);
    }
    Real* diagonal = block(i, i);
    for (std::size_t j = first; j < i; ++j) {
      Real* own = block(i, j);
      std::copy_n(own, kEnvelopeBlock, y);
      for (std::size_t r = 0; r < N; ++r)
        for (std::size_t c = 0; c < N; ++c) own[r * N + c] *= block(j, j)[r * N + r];
      subtract_product<N>(own, y, diagonal, kPair);
    }
    if (!(diagonal[0] > 0) || decompose<N>(diagonal, N, {}) > 0) return false;
  }
  return true;
}

void BlockEnvelope::solve(std::span<Real> x) const {
  PANTIN_ASSERT(x.size() == N * rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Real* own = &x[N * i];
    for (std::size_t j = rows[i].first; j < i; ++j)
      update_forward<N>(block(i, j), &x[N * j], own, kBlock);
    const Real* d = block(i, i);
    for (std::size_t r = 1; r < N; ++r)
      for (std::size_t k = 0; k < r; ++k) own[r] -= d[r * N + k] * own[k];
  }
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t r = 0; r < N; ++r) x[N * i + r] *= block(i, i)[r * N + r];
  for (std::size_t i = rows.size(); i-- > 0;) {
    Real* own = &x[N * i];
    const Real* d = block(i, i);
    for (std::size_t r = N; r-- > 1;)
      for (std::size_t k = 0; k < r; ++k) own[k] -= d[r * N + k] * own[r];
    for (std::size_t j = rows[i].first; j < i; ++j)
      update_back<N>(block(i, j), &x[N * j], own, kBlock);
  }
}

}  // namespace pantin::detail
