#include "engine/modes/region.hpp"

#include <algorithm>
#include <limits>

#include "engine/modes/roots.hpp"

namespace pantin::detail::modes {
namespace {

/// Evaluates neighbouring coefficients in pairs, which fit one register.
Real affine(const Real* f, Real x, Real y) {
  Real pair[2];
  for (int i = 0; i < 2; ++i) pair[i] = f[i] + y * f[i + 2];
  return pair[0] + x * pair[1];
}
Real affine(const std::array<Real, 4>& f, Real x, Real y) { return affine(f.data(), x, y); }
Real affine(const std::array<Real, 8>& f, const OwnFriction& m) {
  Real four[4];
  for (std::size_t i = 0; i < 4; ++i) four[i] = f[i] + m[2] * f[i + 4];
  return affine(four, m[0], m[1]);
}

template <std::size_t N>
std::array<Real, N> absolute(std::array<Real, N> f) {
  for (Real& x : f) x = std::abs(x);
  return f;
}

/// p (base + t along) for a cubic that is short enough.
Cubic times(const Cubic& p, Real base, Real along) {
  Cubic out{};
  for (std::size_t i = 0; i < 4; ++i) {
    out[i] += p[i] * base;
    if (i < 3) out[i + 1] += p[i] * along;
  }
  return out;
}

struct Breakpoints {
  struct At {
    Real t;
    bool open;  // X is 0 there
  };
  std::array<At, 20> list;
  std::size_t count = 0;

  /// Roots of a form, or of X.
  void add(const Cubic& form) { add_all(form, At{0, false}); }
  void add_divisor(const Cubic& x) { add_all(x, At{0, true}); }
  void sort() {
    std::sort(list.begin(), list.begin() + count, [](At a, At b) { return a.t < b.t; });
    // Merges roots that differ by rounding.
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (kept > 0 && list[i].t - list[kept - 1].t <= 1e-13 * std::max(1.0, list[i].t))
        list[kept - 1].open |= list[i].open;
      else
        list[kept++] = list[i];
    }
    count = kept;
  }

 private:
  void add_all(const Cubic& p, At at) {
    for (const Real t : real_roots(p)) list[count++] = {t, at.open};
  }
};

OwnFriction at(const Line& line, Real t) {
  OwnFriction m;
  for (std::size_t i = 0; i < 3; ++i) m[i] = line.base[i] + t * line.along[i];
  return m;
}

void append(Intervals& all, const Interval& next) {
  if (all.count > 0) {
    Interval& last = all.list[static_cast<std::size_t>(all.count) - 1];
    if (last.high == next.low && last.high_closed && last.branch == next.branch) {
      last.high = next.high, last.high_closed = next.high_closed;
      return;
    }
  }
  all.list[static_cast<std::size_t>(all.count++)] = next;
}

struct Range {
  Real low = std::numeric_limits<Real>::infinity(), high = -low;
  void add(Real x) { low = std::min(low, x), high = std::max(high, x); }
};

}  // namespace

Values values(const Region& r, const OwnFriction& m) {
  Values v;
  v.divisor = affine(r.divisor, m);
  for (int i = 0; i < r.form_count(); ++i) {
    const auto [x, y] = form_variables(r.kind, i);
    v.forms[static_cast<std::size_t>(i)] = affine(r.forms[static_cast<std::size_t>(i)], m[x], m[y]);
  }
  return v;
}

Values magnitudes(const Region& r, const OwnFriction& m) {
  Region sums;
  sums.kind = r.kind;
  sums.divisor = absolute(r.divisor);
  for (std::size_t i = 0; i < 4; ++i) sums.forms[i] = absolute(r.forms[i]);
  return values(sums, m);
}

namespace {

/// 1 or -1 where X and all forms agree in sign, forms may be 0; otherwise 0. No branches, since the
/// outcome is unpredictable.
template <std::size_t N>
int agreed(Real x, const std::array<Real, N>& forms) {
  Real least = forms[0], most = forms[0];
  for (const Real f : forms) least = f < least ? f : least, most = f > most ? f : most;
  // Integer arithmetic instead of logic: no branch.
  const int plus = x > 0, minus = x < 0, above = least >= 0, below = most <= 0;
  return (plus & above) - (minus & below);
}

}  // namespace

int branch_of(const Region& r, const OwnFriction& m) {
  const auto& f = r.forms;
  if (r.kind == Kind::three_slide)
    return agreed<3>(affine(r.divisor, m), {affine(f[0], m[1], m[2]), affine(f[1], m[0], m[2]),
                                            affine(f[2], m[0], m[1])});
  const auto of = [&](std::size_t k) { return affine(f[k], m[0], m[1]); };
  return agreed<4>(affine(r.divisor, m), {of(0), of(1), of(2), of(3)});
}

std::array<Real, 3> forces(const Region& r, const OwnFriction& mu) {
  const Values v = values(r, mu);
  const auto& f = v.forms;
  if (r.kind == Kind::three_slide) return {f[0] / v.divisor, f[1] / v.divisor, f[2] / v.divisor};
  const Real tangential = r.forms[1][0] + r.forms[1][2] * mu[1];
  return {f[3] / v.divisor, tangential / v.divisor, f[0] / v.divisor};
}

int index_of(const Region& r, int branch) { return r.determinant > 0 ? branch : -branch; }

Cubic divisor_along(const Region& r, const Line& line) {
  Cubic sum{};
  for (std::size_t mask = 0; mask < 8; ++mask) {
    Cubic term{r.divisor[mask], 0, 0, 0};
    for (std::size_t i = 0; i < 3; ++i)
      if (mask >> i & 1) term = times(term, line.base[i], line.along[i]);
    for (std::size_t k = 0; k < 4; ++k) sum[k] += term[k];
  }
  return sum;
}

Cubic form_along(const Region& r, int form, const Line& line) {
  const auto variables = form_variables(r.kind, form);
  Cubic sum{};
  for (std::size_t mask = 0; mask < 4; ++mask) {
    Cubic term{r.forms[static_cast<std::size_t>(form)][mask], 0, 0, 0};
    for (std::size_t i = 0; i < 2; ++i)
      if (mask >> i & 1) term = times(term, line.base[variables[i]], line.along[variables[i]]);
    for (std::size_t k = 0; k < 4; ++k) sum[k] += term[k];
  }
  return sum;
}

Intervals intervals_along(const Region& r, const Line& line) {
  Breakpoints breaks;
  breaks.list[breaks.count++] = {0, false};
  breaks.add_divisor(divisor_along(r, line));
  for (int i = 0; i < r.form_count(); ++i) breaks.add(form_along(r, i, line));
  breaks.sort();
  Intervals all;
  for (std::size_t i = 0; i < breaks.count; ++i) {
    const bool last = i + 1 == breaks.count;
    const Real low = breaks.list[i].t;
    const Real high = last ? std::numeric_limits<Real>::infinity() : breaks.list[i + 1].t;
    const int branch = branch_of(r, at(line, last ? 2 * low + 1 : (low + high) / 2));
    if (branch == 0) continue;
    append(all, {low, high, branch, !breaks.list[i].open, !last && !breaks.list[i + 1].open});
  }
  return all;
}

Intervals equal_friction(const Region& r) { return intervals_along(r, {{0, 0, 0}, {1, 1, 1}}); }

Real cube_bound(const Region& r) {
  if (!contains(r, {})) return 0;
  Real bound = std::numeric_limits<Real>::infinity();
  for (int corner = 1; corner < 1 << r.variables(); ++corner) {
    Line line;
    for (std::size_t i = 0; i < 3; ++i) line.along[i] = corner >> i & 1;
    const Intervals all = intervals_along(r, line);
    if (all.count == 0 || all.list[0].low > 0) return 0;
    bound = std::min(bound, all.list[0].high);
  }
  return bound;
}

BoxVerdict box(const Region& r, const OwnFriction& low, const OwnFriction& high) {
  Range divisor;
  std::array<Range, 4> forms;
  const int count = r.form_count();
  for (int corner = 0; corner < 1 << r.variables(); ++corner) {
    OwnFriction m{};
    for (std::size_t i = 0; i < 3; ++i) m[i] = corner >> i & 1 ? high[i] : low[i];
    const Values v = values(r, m);
    divisor.add(v.divisor);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) forms[i].add(v.forms[i]);
  }
  const auto first = forms.begin(), last = forms.begin() + count;
  const auto no_negative = [](const Range& f) { return f.low >= 0; };
  const auto no_positive = [](const Range& f) { return f.high <= 0; };
  if (divisor.low > 0 && std::all_of(first, last, no_negative)) return BoxVerdict::inside;
  if (divisor.high < 0 && std::all_of(first, last, no_positive)) return BoxVerdict::inside;
  const bool no_plus =
      divisor.high <= 0 || std::any_of(first, last, [](const Range& f) { return f.high < 0; });
  const bool no_minus =
      divisor.low >= 0 || std::any_of(first, last, [](const Range& f) { return f.low > 0; });
  return no_plus && no_minus ? BoxVerdict::outside : BoxVerdict::undecided;
}

}  // namespace pantin::detail::modes
