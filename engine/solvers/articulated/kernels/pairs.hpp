#pragma once
/// Contact points of two bodies, iterated in impulse space (impulses/group_points.cpp).
#include "engine/solvers/articulated/kernels.hpp"
#include "engine/solvers/articulated/kernels/vectors.hpp"

namespace pantin::detail::articulated {
namespace {

void multiply_motions(const RowMotions& m, double* to) {
  for (std::size_t column = 0; column < m.rows; ++column) {
    const double* const by = m.caused + kMotionNumbers * column;
    for (std::size_t row = 0; row < m.stride; row += 4) {
      Four sums[2] = {};
      for (std::size_t k = 0; k < kMotionNumbers; k += 2) {
        sums[0] = sums[0] + by[k] * load(m.seen + k * m.stride + row);
        sums[1] = sums[1] + by[k + 1] * load(m.seen + (k + 1) * m.stride + row);
      }
      store(to + column * m.stride + row, sums[0] + sums[1]);
    }
  }
}

/// Solves one point: its normal impulse, then friction within Coulomb's cone. Leaves the change of
/// impulse.
INLINE void solve_point(PairPoint& p, const double* speed, double* change) {
  const double least = p.impulse[0] > 0 ? p.speed : p.parted;
  const double wanted = p.kept * p.impulse[0] + p.gain * (least - speed[0]);
  const double normal = wanted > 0 ? wanted : 0;
  const double more = normal - p.impulse[0];
  double first = p.impulse[1] - (speed[1] + p.cross[0] * more) * p.per_aside,
         second = p.impulse[2] - (speed[2] + p.cross[1] * more) * p.per_aside;
  const double held = first * first + second * second, most = p.friction * normal;
  if (normal == 0) {
    first = second = 0;  // squares of tiny values may underflow to zero
  } else if (held > most * most) {
    const double part = most / ::sqrt(held);
    first *= part, second *= part;
  }
  change[0] = more, change[1] = first - p.impulse[1], change[2] = second - p.impulse[2];
  p.impulse[0] = normal, p.impulse[1] = first, p.impulse[2] = second;
}

double iterate_pair(const PairIteration& pair) {
  double most = 0;
  for (std::size_t n = 0; n < pair.points; ++n) {
    const std::size_t i = pair.backwards ? pair.points - 1 - n : n;
    PairPoint& p = pair.at[i];
    double change[3];
    solve_point(p, pair.speeds + 3 * i, change);
    const double square = change[0] * change[0] + change[1] * change[1] + change[2] * change[2];
    if (square == 0) continue;
    const double faster = p.along * p.along * square;
    most = faster > most ? faster : most;
    const double* const by = pair.responses + 3 * i * pair.stride;
    for (std::size_t row = 0; row < pair.stride; row += 4)
      store(pair.speeds + row,
            load(pair.speeds + row) +
                (change[0] * load(by + row) + change[1] * load(by + pair.stride + row) +
                 change[2] * load(by + 2 * pair.stride + row)));
  }
  return ::sqrt(most);
}

}  // namespace
}  // namespace pantin::detail::articulated
