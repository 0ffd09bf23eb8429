#include "engine/base/block_envelope.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/invariants.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t N = kEnvelopeWide;

/// C -= A B^T.
void subtract_product(const Real* a, const Real* b, Real* c) {
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = 0; j < N; ++j) {
      Real sum = 0;
      for (std::size_t k = 0; k < N; ++k) sum += a[i * N + k] * b[j * N + k];
      c[i * N + j] -= sum;
    }
}

/// The lower part becomes L with A = L L^T.
bool factor_block(Real* a) {
  for (std::size_t j = 0; j < N; ++j) {
    Real pivot = a[j * N + j];
    for (std::size_t k = 0; k < j; ++k) pivot -= a[j * N + k] * a[j * N + k];
    if (!(pivot > 0)) return false;
    const Real root = std::sqrt(pivot);
    a[j * N + j] = root;
    for (std::size_t i = j + 1; i < N; ++i) {
      Real x = a[i * N + j];
      for (std::size_t k = 0; k < j; ++k) x -= a[i * N + k] * a[j * N + k];
      a[i * N + j] = x / root;
    }
  }
  return true;
}

/// A becomes A L^-T.
void divide(const Real* l, Real* a) {
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = 0; j < N; ++j) {
      Real x = a[i * N + j];
      for (std::size_t k = 0; k < j; ++k) x -= a[i * N + k] * l[j * N + k];
      a[i * N + j] = x / l[j * N + j];
    }
}

}  // namespace

bool BlockEnvelope::factor() const {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    PANTIN_ASSERT(rows[i].first <= i);
    for (std::size_t j = rows[i].first; j <= i; ++j) {
      Real* own = block(i, j);
      for (std::size_t k = std::max(rows[i].first, rows[j].first); k < j; ++k)
        subtract_product(block(i, k), block(j, k), own);
      if (j < i)
        divide(block(j, j), own);
      else if (!factor_block(own))
        return false;
    }
  }
  return true;
}

void BlockEnvelope::solve(std::span<Real> x) const {
  PANTIN_ASSERT(x.size() == N * rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Real* own = &x[N * i];
    for (std::size_t j = rows[i].first; j < i; ++j) {
      const Real *b = block(i, j), *other = &x[N * j];
      for (std::size_t r = 0; r < N; ++r)
        for (std::size_t k = 0; k < N; ++k) own[r] -= b[r * N + k] * other[k];
    }
    const Real* l = block(i, i);
    for (std::size_t r = 0; r < N; ++r) {
      for (std::size_t k = 0; k < r; ++k) own[r] -= l[r * N + k] * own[k];
      own[r] /= l[r * N + r];
    }
  }
  for (std::size_t i = rows.size(); i-- > 0;) {
    Real* own = &x[N * i];
    const Real* l = block(i, i);
    for (std::size_t r = N; r-- > 0;) {
      for (std::size_t k = r + 1; k < N; ++k) own[r] -= l[k * N + r] * own[k];
      own[r] /= l[r * N + r];
    }
    for (std::size_t j = rows[i].first; j < i; ++j) {
      const Real* b = block(i, j);
      Real* other = &x[N * j];
      for (std::size_t r = 0; r < N; ++r)
        for (std::size_t k = 0; k < N; ++k) other[k] -= b[r * N + k] * own[r];
    }
  }
}

}  // namespace pantin::detail
