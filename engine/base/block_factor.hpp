#pragma once
/// L D L^T of a sparse symmetric positive definite matrix of 6 x 6 blocks. Rows are eliminated in
/// their order; the factor has the blocks that a symbolic factorisation finds. [George & Liu 1981,
/// ch. 5; Liu 1990, elimination trees]
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/base/invariants.hpp"
#include "engine/base/math.hpp"

namespace pantin::detail {

inline constexpr std::size_t kFactorWide = 6, kFactorBlock = 36;

/// The blocks of a row, in BlockPattern::columns: from `first` to `diagonal`, by column.
struct FactorRow {
  std::uint32_t first = 0, diagonal = 0;
};

/// Where a factor has blocks.
struct BlockPattern {
  std::span<FactorRow> rows;
  std::span<std::uint32_t> columns;  // room for those of all rows
  std::span<std::uint32_t> scratch;  // room for scratch_of() numbers

  static constexpr std::size_t scratch_of(std::size_t rows, std::size_t edges) {
    return 3 * rows + 2 * edges;
  }
  std::size_t blocks() const { return rows.empty() ? 0 : rows.back().diagonal + 1; }

  /// Finds it. `for_edges(visit)` calls visit(a, b) for all blocks (a, b) of the matrix beside its
  /// diagonal, each row with another; pairs may be repeated.
  template <class ForEdges>
  void find(const ForEdges& for_edges) const {
    std::uint32_t next = 0;
    each_row(for_edges, [&](std::uint32_t row, auto&& climb) {
      rows[row].first = next;
      climb([&](std::uint32_t column) {
        PANTIN_ASSERT(next < columns.size());
        columns[next++] = column;
      });
      std::sort(columns.begin() + rows[row].first, columns.begin() + next);
      PANTIN_ASSERT(next < columns.size());
      rows[row].diagonal = next, columns[next++] = row;
    });
  }
  /// The same for the numbers of blocks and of block products alone; needs no `columns`.
  struct Size {
    std::size_t blocks = 0, products = 0;
  };
  template <class ForEdges>
  Size size(const ForEdges& for_edges) const {
    Size size;
    for (FactorRow& r : rows) r.first = 0;  // the blocks below the diagonal of this column
    each_row(for_edges, [&](std::uint32_t, auto&& climb) {
      ++size.blocks;
      climb([&](std::uint32_t column) { ++size.blocks, ++rows[column].first; });
    });
    for (const FactorRow& r : rows) size.products += std::size_t(r.first) * (r.first + 1) / 2;
    return size;
  }

 private:
  static constexpr std::uint32_t kNone = UINT32_MAX;

  /// Calls `act(row, climb)` for each row; climb(visit) calls visit(column) for its blocks before
  /// the diagonal: those on the paths of the elimination tree from the matrix's to the row.
  template <class ForEdges, class Act>
  void each_row(const ForEdges& for_edges, const Act& act) const {
    const std::size_t count = rows.size();
    const std::span<std::uint32_t> parent = scratch.first(count),
                                   mark = scratch.subspan(count, count),
                                   head = scratch.subspan(2 * count, count),
                                   list = scratch.subspan(3 * count);
    std::fill_n(scratch.begin(), 3 * count, kNone);
    std::uint32_t edges = 0;
    for_edges([&](std::uint32_t a, std::uint32_t b) {
      PANTIN_ASSERT(a != b && 2 * edges + 1 < list.size());
      const auto [low, high] = std::minmax(a, b);
      list[2 * edges] = head[high], list[2 * edges + 1] = low, head[high] = edges++;
    });
    for (std::uint32_t row = 0; row < count; ++row) {
      mark[row] = row;
      act(row, [&](auto&& visit) {
        for (std::uint32_t e = head[row]; e != kNone; e = list[2 * e])
          for (std::uint32_t c = list[2 * e + 1]; mark[c] != row; c = parent[c]) {
            if (parent[c] == kNone) parent[c] = row;
            mark[c] = row, visit(c);
          }
      });
    }
  }
};

struct BlockFactor {
  BlockPattern pattern;
  std::span<Real> numbers;

  /// The block of a row and a column, with column <= row, which the pattern must have: six numbers
  /// for each unknown of the column. Of a diagonal block only the lower part is read.
  Real* block(std::size_t row, std::size_t column) const;
  /// Replaces the matrix by its factor. Returns false if a pivot is not positive.
  bool factor() const;
  /// Solves with the factor, in place: six numbers for each row.
  void solve(std::span<Real> x) const;
};

}  // namespace pantin::detail
