#pragma once
/// Products of 3 x 3 blocks whose columns are padded to four numbers (impulses/group_loops.cpp),
/// and row operations of dense elimination (smooth/tie_equations.cpp).
#include "engine/solvers/articulated/kernels.hpp"
#include "engine/solvers/articulated/kernels/vectors.hpp"

namespace pantin::detail::articulated {
namespace {

/// Three columns of a block.
struct BlockColumns {
  Four at[3];
  INLINE static BlockColumns from(const double* p) {
    return {{load(p), load(p + kBlockWide), load(p + 2 * kBlockWide)}};
  }
  INLINE void put(double* p) const {
    store(p, at[0]), store(p + kBlockWide, at[1]), store(p + 2 * kBlockWide, at[2]);
  }
  /// Adds left * right; `right` holds three columns of three numbers.
  INLINE void add(const BlockColumns& left, const double* right) {
    for (int c = 0; c < 3; ++c)
      at[c] = at[c] + (right[3 * c] * left.at[0] + right[3 * c + 1] * left.at[1] +
                       right[3 * c + 2] * left.at[2]);
  }
};

void add_path_responses(const PathJoint& joint, double* row) {
  const BlockColumns by_torque = BlockColumns::from(joint.by_torque),
                     by_force = BlockColumns::from(joint.by_force);
  for (std::uint32_t k = joint.first; k != kNoPathStep; k = joint.steps[k].next) {
    const PathStep& step = joint.steps[k];
    if (step.tie > joint.last_tie) break;
    double* const to = row + kBlockNumbers * step.tie;
    BlockColumns sum = BlockColumns::from(to);
    sum.add(by_torque, step.torque);
    if (joint.is_free_root) sum.add(by_force, step.force);
    sum.put(to);
  }
}

/// to -= a b^T over `columns` columns. Even and odd columns are summed apart.
void subtract_products(double* to, const double* a, const double* b, std::size_t columns) {
  BlockColumns sums[2] = {};
  std::size_t k = 0;
  const auto add = [&](BlockColumns& sum) {
    const Four left = load(a + kBlockWide * k);
    for (int c = 0; c < 3; ++c)
      sum.at[c] = sum.at[c] + b[kBlockWide * k + static_cast<std::size_t>(c)] * left;
    ++k;
  };
  while (k + 1 < columns) add(sums[0]), add(sums[1]);
  if (k < columns) add(sums[0]);
  BlockColumns result = BlockColumns::from(to);
  for (int c = 0; c < 3; ++c) result.at[c] = result.at[c] - (sums[0].at[c] + sums[1].at[c]);
  result.put(to);
}

void subtract_row(double* to, const double* row, double factor, std::size_t count) {
  std::size_t j = 0;
  for (; j + 4 <= count; j += 4) store(to + j, load(to + j) - factor * load(row + j));
  for (; j < count; ++j) to[j] -= factor * row[j];
}

}  // namespace
}  // namespace pantin::detail::articulated
