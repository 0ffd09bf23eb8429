#pragma once
/// Exact solution of the bounded linear complementarity problem of impulses.
///
/// Rows are constraints at one moment: contacts, limits, cables, capped friction (bounded) and
/// bilateral joints (unbounded). W = J A^-1 J^T maps impulses to velocity changes of the rows, and
/// b are the velocities before. Find the impulses x and velocities w with
///
///   w = W x + b,   lower <= x <= upper,
///   w_i >= 0 where x_i = lower_i,   w_i <= 0 where x_i = upper_i,   w_i = 0 between.
///
/// The velocities w minimise the kinetic energy subject to the rows. They are unique; the impulses
/// need not be (redundant rows). Solved by an active-set method: a finite sequence of exact solves
/// with a Cholesky factor that is updated row by row. [Lawson & Hanson 1974, ch. 23; Gill, Golub,
/// Murray & Saunders 1974, method C1]
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "engine/base/math.hpp"

namespace pantin::detail {

/// The least and the largest impulse of a row; lower <= 0 <= upper.
struct ImpulseBounds {
  static constexpr Real kUnbounded = std::numeric_limits<Real>::infinity();
  Real lower = 0, upper = kUnbounded;  // default: a unilateral row, which only pushes
  static constexpr ImpulseBounds bilateral() { return {-kUnbounded, kUnbounded}; }
};

struct ComplementarityProblem {
  std::span<const Real> matrix;           // W: n x n, symmetric, positive semidefinite
  std::span<const Real> bias;             // b: n
  std::span<const ImpulseBounds> bounds;  // n
};

/// Memory of the solver; grows to the largest problem and is kept.
struct ComplementarityScratch {
  std::vector<Real> factor;         // lower triangular, of the free rows in their order
  std::vector<std::uint32_t> free;  // rows that are at neither bound
  std::vector<std::uint8_t> is_free;
  std::vector<Real> velocity, step, column;
};

/// Reserves memory for problems of n rows, which then allocate nothing.
void reserve(ComplementarityScratch& scratch, std::size_t n);

/// Writes the impulses to `x` (n), starting from zero. Returns false if the rows contradict one
/// another, so that no finite impulses satisfy them: x is then the best that was found, within its
/// bounds.
bool solve_complementarity(const ComplementarityProblem& problem, std::span<Real> x,
                           ComplementarityScratch& scratch);

}  // namespace pantin::detail
