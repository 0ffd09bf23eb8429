// Impulses of rows that act at once, against every combination of active rows.
#include "engine/base/complementarity.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/base/random.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kNoBound = ImpulseBounds::kUnbounded;

struct Problem {
  std::size_t n;
  std::vector<Real> matrix, bias;
  std::vector<ImpulseBounds> bounds;
  ComplementarityProblem view() const { return {matrix, bias, bounds}; }
};

/// W = J J^T and b = J v of `n` random rows on `freedoms` coordinates: redundant where n exceeds
/// them, and always consistent with x >= 0 rows, since v = 0 satisfies all.
Problem random_problem(Random& dice, std::size_t n, std::size_t freedoms) {
  std::vector<Real> j(n * freedoms), v(freedoms);
  for (Real& x : j) x = dice.between(-1, 1);
  for (Real& x : v) x = dice.between(-1, 1);
  Problem p{n, std::vector<Real>(n * n), std::vector<Real>(n), std::vector<ImpulseBounds>(n)};
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t k = 0; k < freedoms; ++k) {
      p.bias[a] += j[a * freedoms + k] * v[k];
      for (std::size_t b = 0; b < n; ++b)
        p.matrix[a * n + b] += j[a * freedoms + k] * j[b * freedoms + k];
    }
  return p;
}

std::vector<Real> velocities(const Problem& p, const std::vector<Real>& x) {
  std::vector<Real> w = p.bias;
  for (std::size_t i = 0; i < p.n; ++i)
    for (std::size_t j = 0; j < p.n; ++j) w[i] += p.matrix[i * p.n + j] * x[j];
  return w;
}

/// The largest violation of bounds, signs and complementarity.
Real worst_of(const Problem& p, const std::vector<Real>& x) {
  const std::vector<Real> w = velocities(p, x);
  Real worst = 0;
  for (std::size_t i = 0; i < p.n; ++i) {
    worst = std::max({worst, p.bounds[i].lower - x[i], x[i] - p.bounds[i].upper});
    if (x[i] < p.bounds[i].upper) worst = std::max(worst, -w[i]);
    if (x[i] > p.bounds[i].lower) worst = std::max(worst, w[i]);
  }
  return worst;
}

}  // namespace

TEST_CASE("impulses of random rows keep bounds, signs and complementarity") {
  Random dice(1);
  ComplementarityScratch scratch;
  Real worst = 0;
  int failed = 0;
  for (int run = 0; run < 4000; ++run) {
    const std::size_t n = 1 + dice.below(std::size_t(12));
    Problem p = random_problem(dice, n, 1 + dice.below(std::size_t(8)));
    for (ImpulseBounds& b : p.bounds) {
      const int kind = dice.below(4);
      if (kind == 0) b = ImpulseBounds::bilateral();
      if (kind == 1) b = {-dice.between(0, 0.5), dice.between(0, 0.5)};
    }
    std::vector<Real> x(n);
    failed += !solve_complementarity(p.view(), x, scratch);
    worst = std::max(worst, worst_of(p, x));
  }
  CHECK(failed == 0);
  CHECK(worst < 1e-9);
}

TEST_CASE("rows that push only: the velocities are those that every combination agrees on") {
  Random dice(2);
  ComplementarityScratch scratch;
  for (int run = 0; run < 200; ++run) {
    const std::size_t n = 2 + dice.below(std::size_t(6));
    const Problem p = random_problem(dice, n, 9);  // no redundant row
    std::vector<Real> x(n), own(n);
    REQUIRE(solve_complementarity(p.view(), x, scratch));
    int found = 0;
    for (unsigned set = 0; set < 1u << n; ++set) {
      // Gauss-Seidel to the end on the rows of the set alone.
      std::fill(own.begin(), own.end(), 0);
      for (int sweep = 0; sweep < 20000; ++sweep)
        for (std::size_t i = 0; i < n; ++i) {
          if (!(set >> i & 1u)) continue;
          Real w = p.bias[i];
          for (std::size_t j = 0; j < n; ++j) w += p.matrix[i * n + j] * own[j];
          own[i] -= w / p.matrix[i * n + i];
        }
      if (worst_of(p, own) > 1e-7) continue;
      ++found;
      for (std::size_t i = 0; i < n; ++i) CHECK(own[i] == Approx(x[i]).margin(1e-5));
      if (found > 0) break;
    }
    CHECK(found == 1);
  }
}

TEST_CASE("a cradle: the row of balls that touch moves on as one without restitution") {
  // Seven equal balls, the first moves: gaps between neighbours close by v_i - v_(i+1).
  constexpr std::size_t n = 6;
  Problem p{n, std::vector<Real>(n * n), std::vector<Real>(n), std::vector<ImpulseBounds>(n)};
  for (std::size_t i = 0; i < n; ++i) {
    p.matrix[i * n + i] = 2;
    if (i + 1 < n) p.matrix[i * n + i + 1] = p.matrix[(i + 1) * n + i] = -1;
  }
  p.bias[0] = -1;
  std::vector<Real> x(n);
  ComplementarityScratch scratch;
  REQUIRE(solve_complementarity(p.view(), x, scratch));
  for (std::size_t i = 0; i < n; ++i) CHECK(x[i] == Approx(Real(6 - i) / 7).epsilon(1e-14));
}

TEST_CASE("rows that contradict one another are told") {
  // Two closed rows ask one coordinate for two speeds; two walls that close on a body do likewise.
  const Problem closed{2, {1, 1, 1, 1}, {-1, 1}, {2, ImpulseBounds::bilateral()}};
  const Problem walls{2, {1, -1, -1, 1}, {-1, -1}, {{0, kNoBound}, {0, kNoBound}}};
  std::vector<Real> x(2);
  ComplementarityScratch scratch;
  CHECK_FALSE(solve_complementarity(closed.view(), x, scratch));
  CHECK_FALSE(solve_complementarity(walls.view(), x, scratch));
  CHECK((std::isfinite(x[0]) && std::isfinite(x[1])));
  // A cap makes them agree: the walls press as hard as they may.
  const Problem capped{2, {1, -1, -1, 1}, {-1, -1}, {{0, 3}, {0, kNoBound}}};
  CHECK(solve_complementarity(capped.view(), x, scratch));
  CHECK(worst_of(capped, x) < 1e-12);
}

TEST_CASE("a hundred redundant rows on twenty freedoms are solved to rounding") {
  Random dice(3);
  ComplementarityScratch scratch;
  for (int run = 0; run < 20; ++run) {
    const Problem p = random_problem(dice, 100, 20);
    std::vector<Real> x(100);
    CHECK(solve_complementarity(p.view(), x, scratch));
    CHECK(worst_of(p, x) < 1e-9);
  }
}
