#pragma once
/// L D L^T of a symmetric positive definite matrix of 6 x 6 blocks in envelope (skyline) storage:
/// each block row is stored from its first nonzero block to the diagonal. The factor has the same
/// envelope. [George & Liu 1981, ch. 4]
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/base/math.hpp"

namespace pantin::detail {

inline constexpr std::size_t kEnvelopeWide = 6, kEnvelopeBlock = 36;

/// A block row: its first column, and the offset of its blocks in the matrix.
struct EnvelopeRow {
  std::uint32_t first = 0;
  std::size_t at = 0;
};

struct BlockEnvelope {
  std::span<const EnvelopeRow> rows;
  std::span<Real> numbers;

  /// The block of a row and a column, with rows[row].first <= column <= row: six numbers for each
  /// unknown of the column. Of a diagonal block only the lower part is read.
  Real* block(std::size_t row, std::size_t column) const {
    return numbers.data() + rows[row].at + (column - rows[row].first) * kEnvelopeBlock;
  }
  /// Replaces the matrix by its factor. Returns false if a pivot is not positive.
  bool factor() const;
  /// Solves with the factor, in place: six numbers for each row.
  void solve(std::span<Real> x) const;
};

}  // namespace pantin::detail
