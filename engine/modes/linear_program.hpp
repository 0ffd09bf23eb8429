#pragma once
/// Small dense linear programmes by the simplex method with Bland's rule.
#include <array>

#include "engine/base/math.hpp"

namespace pantin::detail::modes {

inline constexpr std::size_t kMostRows = 4, kMostColumns = 200;

/// Minimise cost . x where A x = right side and x >= 0. Entries are of order one.
struct LinearProgram {
  using Column = std::array<Real, kMostRows>;
  std::size_t rows = 0, columns = 0;
  std::array<Column, kMostColumns> a;
  std::array<Real, kMostColumns> cost;
  Column right{};

  void add(const Column& column, Real its_cost) {
    a[columns] = column;
    cost[columns++] = its_cost;
  }
};

enum class Outcome : unsigned char { optimal, infeasible, unbounded, stalled };

struct Optimum {
  Outcome outcome = Outcome::infeasible;
  Real cost = 0;
  std::array<Real, kMostRows> multipliers{};  // one for each row
  std::array<int, kMostRows> basis{};         // column of each row, -1 where the row is redundant
  std::array<Real, kMostRows> x{};            // its value
};

/// Residuals of the rows below 1e-9 count as none.
Optimum solve(const LinearProgram& program);

}  // namespace pantin::detail::modes
