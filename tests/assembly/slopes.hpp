#pragma once
// Derivatives of rows by design variables, against differences.
#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "engine/assembly/problem.hpp"

namespace pantin::test {

using namespace detail;
using namespace detail::assembly;

/// The largest slope exceeds `least`; numbers are displaced from their start by a few hundredths
/// times `off`.
struct SlopeTest {
  Real least = 0.1, off = 1;
  bool in_plane = false;  // z stays
};

/// The largest error of G against central differences of the rows.
inline Real error_of_slopes(const World& world, const DesignVariable& variable,
                            const SlopeTest& test = {}) {
  Problem p = make_problem(world, {}, std::vector{variable});
  REQUIRE(p.parts.size() == 1);
  Part& part = p.parts[0];
  const std::size_t n = part.design.numbers.size();
  REQUIRE(n == numbers_of(variable.quantity));
  // Off the start, where the rotation vector of an axis counts.
  std::vector<Real> at(n);
  for (std::size_t i = 0; i < n; ++i)
    at[i] = i == 2 && test.in_plane ? 0 : test.off * (0.02 + 0.03 * Real(i));
  const auto rows_at = [&](const std::vector<Real>& numbers) {
    set_design(p.world, part, numbers);
    look(p.world, part);
    return part.m.scratch.c;
  };
  rows_at(at);
  const std::vector<Real> slopes = part.design.slopes;
  Real worst = 0, most = 0;
  for (std::size_t i = 0; i < n; ++i) {
    constexpr Real h = 1e-5;
    std::vector<Real> up = at, down = at;
    up[i] += h, down[i] -= h;
    const std::vector<Real> above = rows_at(up), below = rows_at(down);
    for (std::size_t r = 0; r < part.m.rows; ++r) {
      const Real found = slopes[i * part.m.rows + r];
      most = std::max(most, std::abs(found));
      worst = std::max(worst, std::abs(found - (above[r] - below[r]) / (2 * h)));
    }
  }
  CHECK(most > test.least);
  return worst;
}

}  // namespace pantin::test
