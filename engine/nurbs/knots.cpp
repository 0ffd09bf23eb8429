#include "engine/nurbs/knots.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/check.hpp"

namespace pantin::detail::nurbs {

Real Knots::inside(Real t) const {
  const Range at = domain();
  if (at.holds(t)) return t;
  if (!is_periodic) return at.clamped(t);
  const Real width = at.width(), wrapped = t - width * std::floor((t - at.low) / width);
  return at.clamped(wrapped);
}

int Knots::span_at(Real t) const {
  const auto first = values.begin() + degree, last = values.begin() + count();
  // At or beyond the end: the span before the first copy of the last knot.
  if (!(t < *last))
    return static_cast<int>(std::lower_bound(first, last, *last) - values.begin()) - 1;
  const auto above = std::upper_bound(first, last, t);
  return std::max(degree, static_cast<int>(above - values.begin()) - 1);
}

int Knots::multiplicity(Real knot) const {
  const auto [first, last] = std::equal_range(values.begin(), values.end(), knot);
  return static_cast<int>(last - first);
}

std::vector<Real> Knots::breaks() const {
  std::vector<Real> distinct(values.begin() + degree, values.begin() + count() + 1);
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  return distinct;
}

std::vector<int> Knots::spans() const {
  std::vector<int> found;
  for (int i = degree; i < count(); ++i)
    if ((*this)[i] < (*this)[i + 1]) found.push_back(i);
  return found;
}

Knots uniform_knots(int degree, int count) {
  Knots knots{.degree = degree, .values = {}};
  const int inner = count - degree - 1;
  knots.values.assign(static_cast<std::size_t>(degree + 1), 0);
  for (int i = 1; i <= inner; ++i) knots.values.push_back(Real(i) / (inner + 1));
  knots.values.insert(knots.values.end(), static_cast<std::size_t>(degree + 1), 1);
  return knots;
}

namespace {

using Line = std::array<Real, kMostDegree + 1>;

// From the functions of degree q - 1 on a span to those of degree q, in place.
void raise(const Knots& knots, InSpan at, int q, Line& line) {
  const auto [span, t] = at;
  Real saved = 0;
  for (int j = 0; j < q; ++j) {
    const Real right = knots[span + 1 + j], left = knots[span + 1 - q + j];
    const Real part = line[j] / (right - left);
    line[j] = saved + (right - t) * part;
    saved = (t - left) * part;
  }
  line[q] = saved;
}

// From derivatives of functions of degree q - 1 to those, one order higher, of degree q.
void differentiate(const Knots& knots, int span, int q, Line& line) {
  Real saved = 0;
  for (int j = 0; j < q; ++j) {
    const Real part = q * line[j] / (knots[span + 1 + j] - knots[span + 1 - q + j]);
    line[j] = saved - part;
    saved = part;
  }
  line[q] = saved;
}

}  // namespace

void write_basis(const Knots& knots, InSpan at, int order, Basis& out) {
  const int p = knots.degree, top = std::min(order, p);
  Line line;
  line[0] = 1;
  for (int q = 1; q <= p - top; ++q) raise(knots, at, q, line);
  // Derivative k of degree p: functions of degree p - k, differentiated k times.
  for (int k = top; k >= 0; --k) {
    Line& row = out[k];
    std::copy_n(line.begin(), p - k + 1, row.begin());
    for (int q = p - k + 1; q <= p; ++q) differentiate(knots, at.span, q, row);
    if (k > 0) raise(knots, at, p - k + 1, line);
  }
  for (int k = top + 1; k <= order; ++k) std::fill_n(out[k].begin(), p + 1, 0.0);
}

namespace {

using Arguments = std::array<Real, kMostDegree + 1>;

struct Blossom {
  const Knots& knots;
  const Rows& rows;
  std::vector<Weighted> work = {};

  const std::vector<Weighted>& at(int span, const Arguments& at);
};

// The blossom of the polynomials on a span, for every column: in the last row of the result.
const std::vector<Weighted>& Blossom::at(int span, const Arguments& at) {
  const int p = knots.degree;
  const auto across = rows.across;
  work.assign(rows.points.begin() + (span - p) * static_cast<std::ptrdiff_t>(across),
              rows.points.begin() + (span + 1) * static_cast<std::ptrdiff_t>(across));
  for (int r = 1; r <= p; ++r)
    for (int j = p; j >= r; --j) {
      const Real left = knots[span - p + j], right = knots[span + 1 + j - r];
      const Real part = (at[r - 1] - left) / (right - left),
                 rest = (right - at[r - 1]) / (right - left);
      for (std::size_t c = 0; c < across; ++c) {
        Weighted& here = work[static_cast<std::size_t>(j) * across + c];
        here = part * here + rest * work[static_cast<std::size_t>(j - 1) * across + c];
      }
    }
  return work;
}

// The span of `to` that is not empty and closest to the middle of function i; -1 if there is none.
int middle_span(const Knots& to, int i) {
  int best = -1;
  for (int j = std::max(i, to.degree); j <= std::min(i + to.degree, to.count() - 1); ++j) {
    if (!(to[j] < to[j + 1])) continue;
    const auto off = [&](int k) { return std::abs(2 * (k - i) - to.degree); };
    if (best < 0 || off(j) < off(best)) best = j;
  }
  return best;
}

}  // namespace

Rows on_knots(const Knots& from, const Rows& rows, const Knots& to) {
  PANTIN_ASSERT(to.degree == from.degree || to.degree == from.degree + 1);
  const auto across = rows.across;
  const auto count = static_cast<std::size_t>(to.count());
  Rows result{std::vector<Weighted>(count * across), across};
  Blossom blossom{from, rows};
  Arguments at{};
  for (int i = 0; i < to.count(); ++i) {
    const int j = middle_span(to, i);
    if (j < 0) continue;  // beyond a seam of several knots: closed up below
    const int span = from.span_at((to[j] + to[j + 1]) / 2);
    Weighted* row = &result.points[static_cast<std::size_t>(i) * across];
    const int q = to.degree, rounds = q == from.degree ? 1 : q;
    // For one degree more: the mean over the arguments with one left out.
    for (int out = 0; out < rounds; ++out) {
      for (int k = 0, n = 0; k < q; ++k)
        if (rounds == 1 || k != out) at[n++] = to[i + 1 + k];
      const std::vector<Weighted>& work = blossom.at(span, at);
      const std::size_t last = static_cast<std::size_t>(from.degree) * across;
      for (std::size_t c = 0; c < across; ++c) row[c] = row[c] + (1.0 / rounds) * work[last + c];
    }
  }
  if (to.is_periodic && to.values.front() < to.low() && to.high() < to.values.back()) {
    const auto wrapped = static_cast<std::ptrdiff_t>(static_cast<std::size_t>(to.degree) * across);
    std::copy_n(result.points.begin(), wrapped, result.points.end() - wrapped);
  }
  return result;
}

Rows turned(const Rows& rows) {
  const std::size_t across = rows.points.size() / rows.across;
  Rows result{std::vector<Weighted>(rows.points.size()), across};
  for (std::size_t i = 0; i < across; ++i)
    for (std::size_t j = 0; j < rows.across; ++j)
      result.points[j * across + i] = rows.points[i * rows.across + j];
  return result;
}

}  // namespace pantin::detail::nurbs
