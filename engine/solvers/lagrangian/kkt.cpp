// The linear system of one instant,
//
//   [ M  J^T ] [  a     ]   [ f     ]
//   [ J  -e  ] [ -lambda] = [ right ]
//
// by block LDL^T. Bodies on few blocks have been eliminated on paper: what they leave is
// J M^-1 J^T. Hubs stay, with M of opposite sign: the matrix is quasi-definite, so every order of
// elimination finds its pivots. [Vanderbei 1995; method of Baraff 1996 with loops by fill]
#include <algorithm>
#include <cmath>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::lagrangian {
namespace {

/// Weight of rows against dependence on others, part of their mean diagonal; what it bends is put
/// right by refinement.
constexpr Real kRegular = 1e-8;
/// A pivot this small, part of the mean diagonal, means a row that follows from others.
constexpr Real kSingular = 1e-12;
/// Rows that follow from others are known by pivots that grow with the weight: this many times.
constexpr Real kProbe = 4;
constexpr int kRefinements = 8;
constexpr Real kExact = 2e-13;

Real dot2(const Vec3* x, const Vec3* y) { return glm::dot(x[0], y[0]) + glm::dot(x[1], y[1]); }

/// Row `row` of a block, the vectors of its body at `at`.
const Vec3* row_of(const Mechanism& m, const Block& b, std::size_t row, std::size_t at) {
  return &m.room.jacobian[b.first_vector + 2 * (row * b.count + at)];
}

/// S += W J^T for the blocks p and q of one meeting. R = 0: sizes known at run time only.
template <int R>
void add_product(const Vec3* w, const Vec3* j, std::size_t stride, std::size_t rows_p,
                 std::size_t rows_q, Real* to, std::size_t step_p, std::size_t step_q) {
  const std::size_t np = R ? R : rows_p, nq = R ? R : rows_q;
  for (std::size_t r = 0; r < np; ++r)
    for (std::size_t s = 0; s < nq; ++s)
      to[r * step_p + s * step_q] += dot2(w + 2 * r, j + s * stride);
}

void meet(Mechanism& m, const KktPattern::Meeting& k, const Vec3* w) {
  const Block &p = m.blocks[k.p], &q = m.blocks[k.q];
  const Vec3* j = row_of(m, q, 0, k.at_q);
  const std::size_t stride = 2u * q.count;
  Real* to = &m.room.values[k.target];
  const std::size_t step_p = k.flipped ? 1 : q.rows, step_q = k.flipped ? p.rows : 1;
  if (p.rows == 3 && q.rows == 3)
    add_product<3>(w, j, stride, 3, 3, to, step_p, step_q);
  else if (p.rows == 5 && q.rows == 5)
    add_product<5>(w, j, stride, 5, 5, to, step_p, step_q);
  else
    add_product<0>(w, j, stride, p.rows, q.rows, to, step_p, step_q);
}

/// The diagonal of J M^-1 J^T: rows of lengths and rows of angles may be far apart in size.
void find_scales(Mechanism& m) {
  const KktPattern& p = m.room.pattern;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    const Real* d = &m.room.values[p.diagonal[p.place[i]]];
    for (std::size_t r = 0; r < b.rows; ++r) {
      Real sum = d[r * b.rows + r];
      for (std::size_t k = 0; k < b.count; ++k) {
        const std::uint32_t body = b.body[k];
        if (body >= m.count() || p.hub_of[body] == UINT32_MAX) continue;
        const Vec3* j = row_of(m, b, r, k);
        sum += glm::dot(j[0], j[0]) / m.mass[body] + glm::dot(j[1], m.room.give[body] * j[1]);
      }
      m.room.scales[b.first_row + r] = sum;
    }
  }
}

void assemble(Mechanism& m) {
  const KktPattern& p = m.room.pattern;
  std::fill(m.room.values.begin(), m.room.values.end(), 0.0);
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Real per_mass = 1 / m.mass[b];
    const Mat3& give = m.room.give[b];
    Vec3 w[12];
    std::uint32_t last = UINT32_MAX;
    for (std::uint32_t i = p.first_meeting[b]; i < p.first_meeting[b + 1]; ++i) {
      const KktPattern::Meeting& k = p.meetings[i];
      if (k.p != last) {
        const Block& block = m.blocks[k.p];
        for (std::size_t r = 0; r < block.rows; ++r) {
          const Vec3* j = row_of(m, block, r, k.at_p);
          w[2 * r] = per_mass * j[0], w[2 * r + 1] = give * j[1];
        }
        last = k.p;
      }
      meet(m, k, w);
    }
  }
  for (const KktPattern::HubMeeting& k : p.hub_meetings) {
    const Block& block = m.blocks[k.block];
    Real* to = &m.room.values[k.target];
    for (std::size_t r = 0; r < block.rows; ++r) {
      const Vec3* j = row_of(m, block, r, k.at);
      for (int c = 0; c < 6; ++c)
        (k.flipped ? to[c * block.rows + r] : to[r * 6 + c]) = c < 3 ? j[0][c] : j[1][c - 3];
    }
  }
  for (std::size_t h = 0; h < p.hubs.size(); ++h) {
    const std::uint32_t b = p.hubs[h];
    Real* to = &m.room.values[p.diagonal[p.place[m.blocks.size() + h]]];
    const Mat3 inertia = world_inertia(m.room.placed[b].rotation, m.inertia[b]);
    for (int r = 0; r < 3; ++r) {
      to[7 * r] = -m.mass[b];
      for (int c = 0; c < 3; ++c) to[(3 + r) * 6 + 3 + c] = -inertia[c][r];
    }
  }
}

/// Cholesky of `sign` times a square block, lower part, reciprocals on the diagonal. Returns the
/// number of pivots at or below `least` of the row's scale; those rows are cut out.
template <int R>
int decompose(Real* d, std::size_t rows, Real sign, const Real* scales, Real least) {
  const std::size_t n = R ? R : rows;
  int cut = 0;
  for (std::size_t c = 0; c < n; ++c) {
    Real pivot = sign * d[c * n + c];
    for (std::size_t k = 0; k < c; ++k) pivot -= d[c * n + k] * d[c * n + k];
    Real inverse = 0;  // cut out
    if (pivot > (scales ? least * scales[c] : 0))
      inverse = 1 / std::sqrt(pivot);
    else
      ++cut;
    for (std::size_t r = c + 1; r < n; ++r) {
      Real x = sign * d[r * n + c];
      for (std::size_t k = 0; k < c; ++k) x -= d[r * n + k] * d[c * n + k];
      d[r * n + c] = x * inverse;
    }
    d[c * n + c] = inverse;
  }
  return cut;
}

/// Y = B L^-T, row by row: `b` has `count` rows of n.
template <int R>
void divide(const Real* d, std::size_t rows, Real* b, std::size_t count) {
  const std::size_t n = R ? R : rows;
  for (std::size_t r = 0; r < count; ++r, b += n)
    for (std::size_t c = 0; c < n; ++c) {
      Real x = b[c];
      for (std::size_t k = 0; k < c; ++k) x -= b[k] * d[c * n + k];
      b[c] = x * d[c * n + c];
    }
}

/// T -= sign Y_i Y_j^T.
template <int R>
void take_off(const Real* yi, const Real* yj, std::size_t ni, std::size_t nj, std::size_t rows,
              Real sign, Real* t) {
  const std::size_t n = R ? R : rows, ri = R ? R : ni, rj = R ? R : nj;
  for (std::size_t r = 0; r < ri; ++r)
    for (std::size_t s = 0; s < rj; ++s) {
      Real sum = 0;
      for (std::size_t k = 0; k < n; ++k) sum += yi[r * n + k] * yj[s * n + k];
      t[r * rj + s] -= sign * sum;
    }
}

template <int R>
void eliminate(Mechanism& m, std::uint32_t at, Real sign, const Real* scales, Real least,
               int& cut) {
  const KktPattern& p = m.room.pattern;
  Real* v = m.room.values.data();
  Real* d = v + p.diagonal[at];
  const std::size_t n = p.size[at];
  cut = decompose<R>(d, n, sign, scales, least);
  const std::uint32_t from = p.first[at], to = p.first[at + 1];
  for (std::uint32_t i = from; i < to; ++i)
    divide<R>(d, n, v + p.offset[i], p.size[p.later[i]]);
  const std::uint32_t* target = &p.targets[p.first_target[at]];
  for (std::uint32_t i = from; i < to; ++i)
    for (std::uint32_t j = from; j <= i; ++j, ++target) {
      const std::size_t ni = p.size[p.later[i]], nj = p.size[p.later[j]];
      if (R && ni == R && nj == R)
        take_off<R>(v + p.offset[i], v + p.offset[j], ni, nj, n, sign, v + *target);
      else
        take_off<0>(v + p.offset[i], v + p.offset[j], ni, nj, n, sign, v + *target);
    }
}

/// The unknowns from the right-hand side, in place, with the factor.
void back_solve(Mechanism& m) {
  const KktPattern& p = m.room.pattern;
  const Real* v = m.room.values.data();
  Real* y = m.room.unknowns.data();
  const std::size_t blocks = m.blocks.size();
  for (std::uint32_t at = 0; at < p.order.size(); ++at) {
    const std::size_t n = p.size[at];
    const Real sign = p.order[at] < blocks ? 1 : -1;
    const Real* d = v + p.diagonal[at];
    Real* own = y + p.unknown[at];
    for (std::size_t r = 0; r < n; ++r) {
      Real x = own[r];
      for (std::size_t k = 0; k < r; ++k) x -= d[r * n + k] * own[k];
      own[r] = x * d[r * n + r];
    }
    for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i) {
      const Real* b = v + p.offset[i];
      Real* other = y + p.unknown[p.later[i]];
      for (std::size_t r = 0; r < p.size[p.later[i]]; ++r) {
        Real sum = 0;
        for (std::size_t k = 0; k < n; ++k) sum += b[r * n + k] * own[k];
        other[r] -= sign * sum;
      }
    }
  }
  for (std::uint32_t at = static_cast<std::uint32_t>(p.order.size()); at-- > 0;) {
    const std::size_t n = p.size[at];
    const Real sign = p.order[at] < blocks ? 1 : -1;
    const Real* d = v + p.diagonal[at];
    Real* own = y + p.unknown[at];
    for (std::size_t k = 0; k < n; ++k) own[k] *= sign;
    for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i) {
      const Real* b = v + p.offset[i];
      const Real* other = y + p.unknown[p.later[i]];
      for (std::size_t r = 0; r < p.size[p.later[i]]; ++r)
        for (std::size_t k = 0; k < n; ++k) own[k] -= sign * (b[r * n + k] * other[r]);
    }
    for (std::size_t r = n; r-- > 0;) {
      Real x = own[r];
      for (std::size_t k = r + 1; k < n; ++k) x -= d[k * n + r] * own[k];
      own[r] = x * d[r * n + r];
    }
  }
}

/// Factors with this weight on the rows. False: a row of a tree follows from others.
bool factor_weighted(Mechanism& m, Real weight) {
  MechanismRoom& room = m.room;
  const KktPattern& p = room.pattern;
  assemble(m);
  find_scales(m);
  for (std::uint32_t at = 0; at < p.order.size(); ++at) {
    const std::uint32_t node = p.order[at];
    const std::size_t n = p.size[at];
    Real* d = &room.values[p.diagonal[at]];
    int cut = 0;
    if (node >= m.blocks.size()) {
      eliminate<6>(m, at, -1, nullptr, 0, cut);
      continue;
    }
    const Block& b = m.blocks[node];
    const Real* scales = &room.scales[b.first_row];
    for (std::size_t r = 0; r < n; ++r) {
      if (bears(m, node)) d[r * n + r] += weight * scales[r];
      else d[r * n + r] = 1;
      d[r * n + r] += room.weights[b.first_row + r];
    }
    const Real least = weight > 0 ? 0.5 * weight : kSingular;
    switch (n) {
      case 1: eliminate<1>(m, at, 1, scales, least, cut); break;
      case 3: eliminate<3>(m, at, 1, scales, least, cut); break;
      case 5: eliminate<5>(m, at, 1, scales, least, cut); break;
      default: eliminate<0>(m, at, 1, scales, least, cut);
    }
    if (weight == 0 && cut > 0 && bears(m, node)) return false;
  }
  ++m.solves;
  return true;
}

/// 1 / pivot of a row of the factor; 0: the row was cut out.
Real inverse_pivot(const Mechanism& m, std::size_t block, std::size_t row) {
  const KktPattern& p = m.room.pattern;
  const Real root =
      m.room.values[p.diagonal[p.place[block]] + row * m.blocks[block].rows + row];
  return root * root;
}

/// Rank and redundant blocks, by the factor and that of kProbe times the weight in room.lack.
void find_redundant(Mechanism& m) {
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i) {
    if (!bears(m, i)) continue;
    int dependent = 0;
    for (std::size_t r = 0; r < m.blocks[i].rows; ++r) {
      const Real now = inverse_pivot(m, i, r), probe = m.room.lack[m.blocks[i].first_row + r];
      if (now == 0 || now * 2 > kProbe * probe) ++dependent;
    }
    if (dependent == 0) continue;
    m.rank -= static_cast<std::size_t>(dependent);
    MechanismFault f;
    f.kind = MechanismFault::redundant, f.block = i, f.rows = dependent;
    m.faults.push_back(f);
  }
}

}  // namespace

void factor(Mechanism& m, bool report) {
  if (report) m.rank = m.rows, m.faults.clear();
  if (!m.loops) {
    if (factor_weighted(m, 0)) return;
    m.loops = true;  // a tree, but stretched out: as if it had loops from now on
  }
  if (report) {
    factor_weighted(m, kProbe * kRegular);
    for (std::size_t i = 0; i < m.blocks.size(); ++i)
      for (std::size_t r = 0; r < m.blocks[i].rows; ++r)
        m.room.lack[m.blocks[i].first_row + r] = inverse_pivot(m, i, r);
  }
  factor_weighted(m, kRegular);
  if (report) find_redundant(m);
}

namespace {

/// right - J a - weights lambda, into room.lack. Returns its worst part, and in `asked` how large
/// its terms are.
Real find_lack(Mechanism& m, std::span<const Real> right, std::span<const Vec3> a,
               std::span<const Real> lambda, Real& asked) {
  MechanismRoom& room = m.room;
  Real worst = 0;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    const bool on = bears(m, i);
    for (std::size_t r = 0; r < b.rows; ++r) {
      const std::size_t row = b.first_row + r;
      Real sum = 0, size = std::abs(right[row]);
      for (std::size_t k = 0; k < b.count; ++k) {
        if (b.body[k] >= m.count()) continue;
        const Real part = dot2(row_of(m, b, r, k), &a[2 * b.body[k]]);
        sum += part, size = std::max(size, std::abs(part));
      }
      const Real lack = on ? right[row] - sum - room.weights[row] * lambda[row] : 0;
      room.lack[row] = lack;
      worst = std::max(worst, std::abs(lack));
      if (on) asked = std::max(asked, size);
    }
  }
  return worst;
}

/// a = M^-1 (force + J^T lambda); hubs too, though they have been unknowns.
void find_motion(Mechanism& m, std::span<const Vec3> force, std::span<const Real> lambda,
                 std::span<Vec3> a) {
  for (std::size_t b = 0; b < m.count(); ++b)
    a[2 * b] = force.empty() ? Vec3(0) : force[2 * b],
          a[2 * b + 1] = force.empty() ? Vec3(0) : force[2 * b + 1];
  for (const Block& b : m.blocks)
    for (std::size_t r = 0; r < b.rows; ++r) {
      const Real load = lambda[b.first_row + r];
      if (load == 0) continue;
      for (std::size_t k = 0; k < b.count; ++k) {
        if (b.body[k] >= m.count()) continue;
        const Vec3* j = row_of(m, b, r, k);
        a[2 * b.body[k]] += load * j[0], a[2 * b.body[k] + 1] += load * j[1];
      }
    }
  for (std::size_t b = 0; b < m.count(); ++b)
    a[2 * b] *= 1 / m.mass[b], a[2 * b + 1] = m.room.give[b] * a[2 * b + 1];
}

/// One solve with the factor: room.lack on the right, no force; lambda into `to`.
void find_loads(Mechanism& m, std::span<Real> to) {
  MechanismRoom& room = m.room;
  const KktPattern& p = room.pattern;
  std::fill(room.unknowns.begin(), room.unknowns.end(), 0.0);
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    for (std::size_t r = 0; r < m.blocks[i].rows; ++r)
      room.unknowns[p.unknown[p.place[i]] + r] = room.lack[m.blocks[i].first_row + r];
  back_solve(m);
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    for (std::size_t r = 0; r < m.blocks[i].rows; ++r)
      to[m.blocks[i].first_row + r] = room.unknowns[p.unknown[p.place[i]] + r];
}

}  // namespace

void loads_for(Mechanism& m, std::span<const Real> right, std::span<Real> lambda) {
  std::copy(right.begin(), right.end(), m.room.lack.begin());
  find_loads(m, lambda);
}

Real solve(Mechanism& m, std::span<const Vec3> force, std::span<const Real> right,
           std::span<Vec3> a, std::span<Real> lambda) {
  MechanismRoom& room = m.room;
  std::fill(lambda.begin(), lambda.end(), 0.0);
  find_motion(m, force, lambda, a);
  Real asked = 1e-300;
  Real lack = find_lack(m, right, a, lambda, asked);
  for (int n = 0; n < kRefinements && lack > 0; ++n) {
    find_loads(m, room.step_lambda);
    for (std::size_t r = 0; r < m.rows; ++r) lambda[r] += room.step_lambda[r];
    find_motion(m, force, lambda, a);
    const Real before = lack;
    lack = find_lack(m, right, a, lambda, asked);
    if (lack <= kExact * asked || (n > 0 && !(lack < 0.5 * before))) break;
  }
  const Real part = lack / asked;
  if (part > room.worst_lack) {
    room.worst_lack = part;
    for (std::uint32_t i = 0; i < m.blocks.size(); ++i)
      for (std::size_t r = 0; r < m.blocks[i].rows; ++r)
        if (std::abs(room.lack[m.blocks[i].first_row + r]) == lack) room.worst_lack_block = i;
  }
  return part;
}

}  // namespace pantin::lagrangian
