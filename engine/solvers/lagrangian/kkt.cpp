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
/// ... and are looked for where pivots are below this part of the scale.
constexpr Real kSuspect = 1e-4;
constexpr int kRefinements = 8;

/// L D L^T of a square block, lower part; the diagonal becomes 1 / D. Pivots of `sign` at or below
/// `least` of the row's scale are cut out, as rows without a load. Returns how many.
template <int R>
int decompose(Real* d, std::size_t rows, Real sign, const Real* scales, Real least) {
  const std::size_t n = R ? R : rows;
  int cut = 0;
  for (std::size_t c = 0; c < n; ++c) {
    const Real pivot = d[c * n + c];
    const bool stands = sign * pivot > (scales ? least * scales[c] : 0);
    const Real inverse = stands ? 1 / pivot : 0;
    cut += stands ? 0 : 1;
    // The column below, and what it takes off the rest.
    for (std::size_t r = c + 1; r < n; ++r) {
      const Real x = d[r * n + c];
      const Real l = x * inverse;
      for (std::size_t k = c + 1; k < r; ++k) d[r * n + k] -= x * d[k * n + c];
      d[r * n + r] -= x * l;
      d[r * n + c] = l;
    }
    d[c * n + c] = inverse;
  }
  return cut;
}

/// Y = L^-1 B into `y`, and D^-1 Y in place of B: `rows` by `count` numbers, as in the factor.
template <int R>
void divide(const Real* d, std::size_t rows, Real* b, Real* y, std::size_t count) {
  const std::size_t n = R ? R : rows, width = R ? R : count;
  for (std::size_t c = 0; c < n; ++c) {
    Real own[6];  // stays in registers: nothing else can point to it
    for (std::size_t r = 0; r < width; ++r) own[r] = b[c * width + r];
    for (std::size_t k = 0; k < c; ++k) {
      const Real l = d[c * n + k];
      for (std::size_t r = 0; r < width; ++r) own[r] -= l * y[k * width + r];
    }
    const Real inverse = d[c * n + c];
    for (std::size_t r = 0; r < width; ++r)
      y[c * width + r] = own[r], b[c * width + r] = own[r] * inverse;
  }
}

/// T -= Z^T Y. Of a block on the diagonal only the lower part is read later.
template <int R>
void take_off(const Real* z, const Real* y, std::size_t nz, std::size_t ny, std::size_t rows,
              Real* t) {
  const std::size_t n = R ? R : rows, wz = R ? R : nz, wy = R ? R : ny;
  for (std::size_t r = 0; r < wz; ++r) {
    Real row[6];
    for (std::size_t s = 0; s < wy; ++s) row[s] = t[r * wy + s];
    for (std::size_t k = 0; k < n; ++k) {
      const Real part = z[k * wz + r];
      for (std::size_t s = 0; s < wy; ++s) row[s] -= part * y[k * wy + s];
    }
    for (std::size_t s = 0; s < wy; ++s) t[r * wy + s] = row[s];
  }
}

template <int R>
void eliminate(Island& m, std::uint32_t at, Real sign, const Real* scales, Real least,
               int& cut) {
  const KktPattern& p = m.room.pattern;
  Real* v = m.room.values.data();
  Real* d = v + p.diagonal[at];
  const std::size_t n = p.size[at];
  cut = decompose<R>(d, n, sign, scales, least);
  const std::uint32_t from = p.first[at], to = p.first[at + 1];
  const std::uint32_t* target = p.targets.data() + p.first_target[at];
  Real y[36];
  for (std::uint32_t i = from; i < to; ++i) {
    const std::size_t ni = p.size[p.later[i]];
    if (R && ni == R) divide<R>(d, n, v + p.offset[i], y, R);
    else divide<0>(d, n, v + p.offset[i], y, ni);
    for (std::uint32_t j = from; j <= i; ++j, ++target) {
      const std::size_t nj = p.size[p.later[j]];
      if (R && ni == R && nj == R)
        take_off<R>(v + p.offset[j], y, nj, ni, n, v + *target);
      else
        take_off<0>(v + p.offset[j], y, nj, ni, n, v + *target);
    }
  }
}

/// other -= B^T own, and own -= B other, for one block of the factor beside the diagonal.
template <int R>
void take_forward(const Real* b, const Real* own, std::size_t rows, Real* other,
                  std::size_t count) {
  const std::size_t n = R ? R : rows, width = R ? R : count;
  Real sum[6];
  for (std::size_t r = 0; r < width; ++r) sum[r] = other[r];
  for (std::size_t k = 0; k < n; ++k) {
    const Real part = own[k];
    for (std::size_t r = 0; r < width; ++r) sum[r] -= b[k * width + r] * part;
  }
  for (std::size_t r = 0; r < width; ++r) other[r] = sum[r];
}
template <int R>
void take_back(const Real* b, Real* own, std::size_t rows, const Real* other, std::size_t count) {
  const std::size_t n = R ? R : rows, width = R ? R : count;
  for (std::size_t k = 0; k < n; ++k) {
    Real sum = own[k];
    for (std::size_t r = 0; r < width; ++r) sum -= b[k * width + r] * other[r];
    own[k] = sum;
  }
}

template <int R>
void go_forward(const KktPattern& p, const Real* v, Real* y, std::uint32_t at) {
  const std::size_t n = R ? R : p.size[at];
  const Real* d = v + p.diagonal[at];
  Real* own = y + p.unknown[at];
  for (std::size_t r = 1; r < n; ++r)
    for (std::size_t k = 0; k < r; ++k) own[r] -= d[r * n + k] * own[k];
  for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i) {
    const std::uint32_t to = p.later[i];
    if (R && p.size[to] == R) take_forward<R>(v + p.offset[i], own, n, y + p.unknown[to], R);
    else take_forward<0>(v + p.offset[i], own, n, y + p.unknown[to], p.size[to]);
  }
  for (std::size_t r = 0; r < n; ++r) own[r] *= d[r * n + r];
}
template <int R>
void go_back(const KktPattern& p, const Real* v, Real* y, std::uint32_t at) {
  const std::size_t n = R ? R : p.size[at];
  const Real* d = v + p.diagonal[at];
  Real* own = y + p.unknown[at];
  for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i) {
    const std::uint32_t to = p.later[i];
    if (R && p.size[to] == R) take_back<R>(v + p.offset[i], own, n, y + p.unknown[to], R);
    else take_back<0>(v + p.offset[i], own, n, y + p.unknown[to], p.size[to]);
  }
  for (std::size_t r = n; r-- > 1;)
    for (std::size_t k = 0; k < r; ++k) own[k] -= d[r * n + k] * own[r];
}

/// The unknowns from the right-hand side, in place, with the factor.
void back_solve(const Island& m, Real* y) {
  const KktPattern& p = m.room.pattern;
  const Real* v = m.room.values.data();
  const auto count = static_cast<std::uint32_t>(p.order.size());
  for (std::uint32_t at = 0; at < count; ++at) {
    if (p.size[at] == 3) go_forward<3>(p, v, y, at);
    else if (p.size[at] == 5) go_forward<5>(p, v, y, at);
    else go_forward<0>(p, v, y, at);
  }
  for (std::uint32_t at = count; at-- > 0;) {
    if (p.size[at] == 3) go_back<3>(p, v, y, at);
    else if (p.size[at] == 5) go_back<5>(p, v, y, at);
    else go_back<0>(p, v, y, at);
  }
}

/// Factors with this weight on the rows. False: a row of a tree follows from others.
bool factor_weighted(Island& m, Real weight) {
  StepScratch& room = m.room;
  const KktPattern& p = room.pattern;
  assemble(m);
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
Real inverse_pivot(const Island& m, std::size_t block, std::size_t row) {
  const KktPattern& p = m.room.pattern;
  return m.room.values[p.diagonal[p.place[block]] + row * m.blocks[block].rows + row];
}

/// Rank and redundant blocks, by the factor and that of kProbe times the weight in room.lack.
void find_redundant(Island& m) {
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i) {
    if (!bears(m, i) || m.blocks[i].kind == BlockKind::spring) continue;
    int dependent = 0;
    for (std::size_t r = 0; r < m.blocks[i].rows; ++r) {
      const Real now = inverse_pivot(m, i, r), probe = m.room.lack[m.blocks[i].first_row + r];
      if (now == 0 || now * 2 > kProbe * probe) ++dependent;
    }
    if (dependent == 0) continue;
    m.rank -= static_cast<std::size_t>(dependent);
    Fault f;
    f.kind = Fault::redundant, f.block = i, f.rows = dependent;
    m.faults.push_back(f);
  }
}

/// Whether a pivot is so small that its row may follow from others.
bool any_suspect(const Island& m) {
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    for (std::size_t r = 0; r < m.blocks[i].rows && bears(m, i); ++r)
      if (const Real inverse = inverse_pivot(m, i, r);
          inverse == 0 || inverse * m.room.scales[m.blocks[i].first_row + r] * kSuspect > 1)
        return true;
  return false;
}

/// With the rows as written: which follow from others, by factors of two weights.
void probe(Island& m) {
  StepScratch& room = m.room;
  factor_weighted(m, kProbe * kRegular);
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    for (std::size_t r = 0; r < m.blocks[i].rows; ++r)
      room.lack[m.blocks[i].first_row + r] = inverse_pivot(m, i, r);
  factor_weighted(m, kRegular);
  find_redundant(m);
}

}  // namespace

void factor_soft(Island& m, Real weight) { factor_weighted(m, weight); }

void factor(Island& m, bool report) {
  const bool hubs = !m.room.pattern.hubs.empty();
  if (report && !hubs) m.rank = m.equations(), m.faults.clear();
  if (!m.loops) {
    if (factor_weighted(m, 0)) return;
    m.loops = true;  // a tree, but stretched out: as if it had loops from now on
  }
  factor_weighted(m, kRegular);
  if (!report || hubs || !any_suspect(m)) return;
  probe(m);
}

void find_rank(Island& m) {
  StepScratch& room = m.room;
  if (room.pattern.hubs.empty()) return;  // told by factor()
  m.rank = m.equations(), m.faults.clear();
  if (!m.loops) return;
  KktPattern other = make_pattern(m, false);  // without hubs, for as long as it takes
  std::swap(room.pattern, other);
  room.values.resize(std::max(room.values.size(), room.pattern.numbers));
  factor_weighted(m, kRegular);
  probe(m);
  std::swap(room.pattern, other);
  factor_weighted(m, kRegular);
}

namespace {

/// right - J a, into room.lack; no motion means none.
void find_lack(Island& m, std::span<const Real> right, std::span<const Vec3> a) {
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    Real* lack = &m.room.lack[b.first_row];
    const bool on = bears(m, i);
    for (std::size_t r = 0; r < b.rows; ++r) lack[r] = on ? right[b.first_row + r] : 0;
    for (std::size_t k = 0; k < b.count && on && !a.empty(); ++k)
      if (b.body[k] < m.count())
        add_rates(b, jacobian_of(m, b), k, -a[2 * b.body[k]], -a[2 * b.body[k] + 1], lack);
  }
}

/// right - J a - weights lambda, into room.lack. Returns its worst part, and in `asked` how large
/// its terms are.
Real measure_lack(Island& m, std::span<const Real> right, std::span<const Vec3> a,
                  std::span<const Real> lambda, Real& asked) {
  StepScratch& room = m.room;
  Real worst = 0;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    Real* lack = &room.lack[b.first_row];
    if (!bears(m, i)) {
      std::fill(lack, lack + b.rows, 0.0);
      continue;
    }
    for (std::size_t r = 0; r < b.rows; ++r) {
      const std::size_t row = b.first_row + r;
      lack[r] = right[row] - room.weights[row] * lambda[row];
      if (b.kind != BlockKind::spring) asked = std::max(asked, std::abs(right[row]));
    }
    for (std::size_t k = 0; k < b.count; ++k) {
      if (b.body[k] >= m.count()) continue;
      Real part[6] = {};
      add_rates(b, jacobian_of(m, b), k, a[2 * b.body[k]], a[2 * b.body[k] + 1], part);
      for (std::size_t r = 0; r < b.rows; ++r)
        lack[r] -= part[r], asked = std::max(asked, std::abs(part[r]));
    }
    for (std::size_t r = 0; r < b.rows; ++r) worst = std::max(worst, std::abs(lack[r]));
  }
  return worst;
}

/// a = M^-1 force.
void find_free_motion(const Island& m, std::span<const Vec3> force, std::span<Vec3> a) {
  for (std::size_t b = 0; b < m.count(); ++b)
    a[2 * b] = 1 / m.mass[b] * force[2 * b], a[2 * b + 1] = m.room.give[b] * force[2 * b + 1];
}

/// a += M^-1 J^T lambda; hubs too, though they have been unknowns.
void add_motion(const Island& m, std::span<const Real> lambda, std::span<Vec3> a) {
  const KktPattern& p = m.room.pattern;
  for (std::size_t body = 0; body < m.count(); ++body) {
    Vec3 pull[2] = {Vec3(0), Vec3(0)};
    for (std::uint32_t i = p.first_incident[body]; i < p.first_incident[body + 1]; ++i) {
      const Block& b = m.blocks[p.incidents[i].block];
      add_pull(b, jacobian_of(m, b), p.incidents[i].at, &lambda[b.first_row], pull);
    }
    a[2 * body] += 1 / m.mass[body] * pull[0];
    a[2 * body + 1] += m.room.give[body] * pull[1];
  }
}

/// One solve with the factor: room.lack, which it uses up, on the right, no force.
void find_loads(Island& m, std::span<Real> lambda) {
  std::vector<Real>& lack = m.room.lack;
  std::fill(lack.begin() + static_cast<std::ptrdiff_t>(m.rows), lack.end(), 0.0);
  back_solve(m, lack.data());
  std::copy_n(lack.begin(), m.rows, lambda.begin());
}

}  // namespace

void loads_for(Island& m, std::span<const Real> right, std::span<Real> lambda) {
  std::copy(right.begin(), right.end(), m.room.lack.begin());
  find_loads(m, lambda);
}

Real solve(Island& m, std::span<const Vec3> force, std::span<const Real> right,
           std::span<Vec3> a, std::span<Real> lambda, Real enough) {
  StepScratch& room = m.room;
  if (force.empty()) std::fill(a.begin(), a.end(), Vec3(0));
  else find_free_motion(m, force, a);
  find_lack(m, right, force.empty() ? std::span<const Vec3>{} : a);
  find_loads(m, lambda);
  add_motion(m, lambda, a);
  if (!m.loops) return 0;  // the factor is exact
  Real asked = 1e-300, lack = std::numeric_limits<Real>::infinity();
  for (int n = 0;; ++n) {
    const Real before = lack;
    lack = measure_lack(m, right, a, lambda, asked);
    if (lack <= enough * asked || n == kRefinements || !(lack < 0.5 * before)) break;
    find_loads(m, room.step_lambda);
    for (std::size_t r = 0; r < m.rows; ++r) lambda[r] += room.step_lambda[r];
    add_motion(m, room.step_lambda, a);
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
