#pragma once
/// L D L^T of a symmetric positive definite matrix of 6 x 6 blocks that is stored by its envelope:
/// of each row of blocks those from the first that is not zero to the diagonal. The factor fills
/// the envelope and no more. [George & Liu 1981, ch. 4]
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/base/math.hpp"

namespace pantin::detail {

inline constexpr std::size_t kEnvelopeWide = 6, kEnvelopeBlock = 36;

/// A row of blocks: its first column, and where its blocks begin among the matrix's numbers.
struct EnvelopeRow {
  std::uint32_t first = 0;
  std::size_t at = 0;
};

struct BlockEnvelope {
  std::span<const EnvelopeRow> rows;
  std::span<Real> numbers;

  /// Of what couples a row and a column, with rows[row].first <= column <= row: six numbers for
  /// each unknown of the column. Of that on the diagonal the lower part is read.
  Real* block(std::size_t row, std::size_t column) const {
    return numbers.data() + rows[row].at + (column - rows[row].first) * kEnvelopeBlock;
  }
  /// Replaces the matrix by its factor. False where a pivot is not positive.
  bool factor() const;
  /// Solves with the factor, in place: six numbers for each row.
  void solve(std::span<Real> x) const;
};

}  // namespace pantin::detail
