// The factor of a matrix of 6 x 6 blocks by its envelope, against the matrix itself.
#include "engine/base/block_envelope.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/base/random.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr std::size_t N = kEnvelopeWide;

struct Matrix {
  std::vector<EnvelopeRow> rows;
  std::vector<Real> numbers;
  BlockEnvelope view() { return {rows, numbers}; }
  Real at(std::size_t i, std::size_t j) {
    if (j > i) return at(j, i);
    if (j / N < rows[i / N].first) return 0;
    return view().block(i / N, j / N)[j % N * N + i % N];
  }
};

/// Of random blocks where the envelope has any, with a heavier diagonal: positive definite.
Matrix random_matrix(Random& dice, std::size_t count) {
  Matrix m;
  for (std::size_t i = 0; i < count; ++i) {
    const auto back = static_cast<std::size_t>(dice.between(0, 4));
    m.rows.push_back({static_cast<std::uint32_t>(i - std::min(i, back)), m.numbers.size()});
    m.numbers.resize(m.numbers.size() + (i - m.rows[i].first + 1) * kEnvelopeBlock);
  }
  for (Real& x : m.numbers) x = dice.between(-1, 1);
  for (std::size_t i = 0; i < count; ++i) {
    Real* own = m.view().block(i, i);
    for (std::size_t r = 0; r < N; ++r)
      for (std::size_t c = 0; c < r; ++c) own[c * N + r] = own[r * N + c];
    for (std::size_t r = 0; r < N; ++r) own[r * N + r] += 60;
  }
  return m;
}

}  // namespace

TEST_CASE("what the factor solves satisfies the matrix, whatever its envelope") {
  Random dice(7);
  for (const std::size_t count : {1u, 2u, 5u, 30u}) {
    Matrix m = random_matrix(dice, count);
    Matrix whole = m;
    std::vector<Real> right(N * count);
    for (Real& x : right) x = dice.between(-1, 1);
    std::vector<Real> x = right;
    REQUIRE(m.view().factor());
    m.view().solve(x);
    for (std::size_t i = 0; i < x.size(); ++i) {
      Real sum = 0;
      for (std::size_t j = 0; j < x.size(); ++j) sum += whole.at(i, j) * x[j];
      CHECK(std::abs(sum - right[i]) < 1e-13);
    }
  }
}

TEST_CASE("a matrix that is not positive definite has no factor") {
  Random dice(8);
  Matrix m = random_matrix(dice, 4);
  m.view().block(3, 3)[5 * N + 5] -= 200;
  CHECK_FALSE(m.view().factor());
}
