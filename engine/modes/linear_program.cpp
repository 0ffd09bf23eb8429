#include "engine/modes/linear_program.hpp"

namespace pantin::detail::modes {
namespace {

constexpr Real kFeasible = 1e-9, kPivot = 1e-11, kReduced = 1e-11;
constexpr int kMostPivots = 2000;
constexpr std::size_t kWidth = kMostColumns + kMostRows;

/// Rows of [A | artificial | right side] in the current basis; artificial columns are at the end.
struct Tableau {
  std::size_t rows, columns;  // columns without artificial ones
  std::array<std::array<Real, kWidth>, kMostRows> a;
  std::array<Real, kMostRows> right;
  std::array<Real, kMostRows> sign;  // of each row, so that its right side is not negative
  std::array<std::size_t, kMostRows> basis;
  std::array<Real, kWidth> reduced;  // costs

  bool artificial(std::size_t column) const { return column >= columns; }
};

void fill(const LinearProgram& program, Tableau& t) {
  t.rows = program.rows, t.columns = program.columns;
  for (std::size_t i = 0; i < t.rows; ++i) {
    t.sign[i] = program.right[i] < 0 ? -1 : 1;
    t.right[i] = t.sign[i] * program.right[i];
    for (std::size_t j = 0; j < t.columns; ++j) t.a[i][j] = t.sign[i] * program.a[j][i];
    for (std::size_t j = 0; j < t.rows; ++j) t.a[i][t.columns + j] = i == j;
    t.basis[i] = t.columns + i;
  }
}

template <class Cost>
Real price(Tableau& t, Cost cost) {
  Real sum = 0;
  for (std::size_t j = 0; j < t.columns + t.rows; ++j) t.reduced[j] = cost(j);
  for (std::size_t i = 0; i < t.rows; ++i) {
    const Real c = cost(t.basis[i]);
    sum += c * t.right[i];
    if (c == 0) continue;
    for (std::size_t j = 0; j < t.columns + t.rows; ++j) t.reduced[j] -= c * t.a[i][j];
  }
  return sum;
}

void pivot(Tableau& t, std::size_t row, std::size_t column) {
  const std::size_t width = t.columns + t.rows;
  const Real inverse = 1 / t.a[row][column];
  for (std::size_t j = 0; j < width; ++j) t.a[row][j] *= inverse;
  t.a[row][column] = 1;
  t.right[row] *= inverse;
  const auto clear = [&](std::array<Real, kWidth>& line) {
    const Real times = line[column];
    if (times == 0) return times;
    for (std::size_t j = 0; j < width; ++j) line[j] -= times * t.a[row][j];
    line[column] = 0;
    return times;
  };
  for (std::size_t i = 0; i < t.rows; ++i)
    if (i != row) {
      const Real times = clear(t.a[i]);
      t.right[i] -= times * t.right[row];
      if (t.right[i] < 0 && t.right[i] > -kPivot) t.right[i] = 0;
    }
  clear(t.reduced);
  t.basis[row] = column;
}

/// The row that bounds the column's growth, ties by the lowest basic column; rows if none does.
std::size_t leaving(const Tableau& t, std::size_t column) {
  std::size_t best = t.rows;
  Real least = 0;
  for (std::size_t i = 0; i < t.rows; ++i) {
    if (t.a[i][column] <= kPivot) continue;
    const Real ratio = t.right[i] / t.a[i][column];
    if (best == t.rows || ratio < least || (ratio == least && t.basis[i] < t.basis[best]))
      best = i, least = ratio;
  }
  return best;
}

Outcome descend(Tableau& t) {
  for (int k = 0; k < kMostPivots; ++k) {
    std::size_t column = 0;
    while (column < t.columns && t.reduced[column] >= -kReduced) ++column;
    if (column == t.columns) return Outcome::optimal;
    const std::size_t row = leaving(t, column);
    if (row == t.rows) return Outcome::unbounded;
    pivot(t, row, column);
  }
  return Outcome::stalled;
}

/// Removes artificial columns from the basis where another column can replace them.
void expel(Tableau& t) {
  for (std::size_t i = 0; i < t.rows; ++i) {
    if (!t.artificial(t.basis[i])) continue;
    t.right[i] = 0;
    std::size_t best = t.columns;
    for (std::size_t j = 0; j < t.columns; ++j)
      if (std::abs(t.a[i][j]) > (best == t.columns ? 1e-9 : std::abs(t.a[i][best]))) best = j;
    if (best < t.columns) pivot(t, i, best);
  }
}

}  // namespace

Optimum solve(const LinearProgram& program) {
  Tableau t;
  Optimum out;
  fill(program, t);
  price(t, [&](std::size_t j) { return t.artificial(j) ? 1.0 : 0.0; });
  if (descend(t) == Outcome::stalled) {
    out.outcome = Outcome::stalled;
    return out;
  }
  Real residual = 0;
  for (std::size_t i = 0; i < t.rows; ++i)
    if (t.artificial(t.basis[i])) residual += t.right[i];
  if (residual > kFeasible) return out;
  expel(t);
  const auto cost = [&](std::size_t j) { return t.artificial(j) ? 0.0 : program.cost[j]; };
  price(t, cost);
  out.outcome = descend(t);
  out.cost = price(t, cost);
  for (std::size_t i = 0; i < t.rows; ++i) {
    out.multipliers[i] = -t.sign[i] * t.reduced[t.columns + i];
    out.basis[i] = t.artificial(t.basis[i]) ? -1 : static_cast<int>(t.basis[i]);
    out.x[i] = t.right[i];
  }
  return out;
}

}  // namespace pantin::detail::modes
