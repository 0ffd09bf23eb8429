#include "engine/base/complementarity.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/check.hpp"

namespace pantin::detail {
namespace {

/// A pivot below this fraction of the row's diagonal makes the row dependent on the free ones.
constexpr Real kDependent = 1e-13;
/// Relative to the terms of a velocity: its rounding error; the tolerated mismatch of redundant
/// rows.
constexpr Real kRounding = 1e-12, kConsistent = 1e-9;

/// Selection rule for the row at a bound that enters the free set.
enum class Entering : std::uint8_t { fastest, lowest };

class ActiveSet {
 public:
  ActiveSet(const ComplementarityProblem& p, std::span<Real> x, ComplementarityScratch& s)
      : p_(p), x_(x), s_(s), n_(p.bias.size()) {
    PANTIN_ASSERT(p.matrix.size() == n_ * n_ && p.bounds.size() == n_ && x.size() == n_);
    s.factor.resize(n_ * n_), s.velocity.resize(n_), s.step.resize(n_), s.column.resize(n_);
    s.free.clear(), s.free.reserve(n_), s.is_free.assign(n_, 0);
    std::fill(x.begin(), x.end(), Real(0));
  }

  bool solve() {
    bool consistent = true;
    const std::size_t most = 16 * n_ + 64;
    // Unbounded rows enter first and stay.
    for (std::uint32_t i = 0; i < n_; ++i)
      if (is_bilateral(i)) add(i);
    for (std::size_t round = 0; round < most; ++round) {
      if (!descend()) return false;
      // The lowest index after many rounds prevents cycling in degenerate steps. [Bland 1977]
      const Entering rule = round > 4 * n_ + 16 ? Entering::lowest : Entering::fastest;
      const std::uint32_t entering = find_entering(rule);
      if (entering == n_) return consistent;
      if (!add(entering) && !exchange(entering)) {
        // No impulse changes its velocity: the row is skipped.
        Real size = 0;
        const Real v = velocity_of(entering, size);
        consistent = consistent && !(std::abs(v) > kConsistent * size);
        s_.is_free[entering] = kLeft;
      }
    }
    return false;
  }

 private:
  static constexpr std::uint8_t kLeft = 2;

  Real w(std::size_t i, std::size_t j) const { return p_.matrix[i * n_ + j]; }
  Real& l(std::size_t i, std::size_t j) { return s_.factor[i * n_ + j]; }
  bool is_bilateral(std::size_t i) const {
    return p_.bounds[i].lower == -ImpulseBounds::kUnbounded &&
           p_.bounds[i].upper == ImpulseBounds::kUnbounded;
  }

  /// Computes the factor's column for row i in the free rows; returns the squared pivot.
  Real project(std::uint32_t i) {
    Real pivot = w(i, i);
    for (std::size_t k = 0; k < s_.free.size(); ++k) {
      Real sum = w(s_.free[k], i);
      for (std::size_t j = 0; j < k; ++j) sum -= l(k, j) * s_.column[j];
      s_.column[k] = sum / l(k, k);
      pivot -= s_.column[k] * s_.column[k];
    }
    return pivot;
  }

  /// Frees a row; returns false if it depends on the free ones.
  bool add(std::uint32_t i) {
    const Real pivot = project(i);
    if (!(pivot > kDependent * w(i, i))) return false;
    const std::size_t k = s_.free.size();
    for (std::size_t j = 0; j < k; ++j) l(k, j) = s_.column[j];
    l(k, k) = std::sqrt(pivot);
    s_.free.push_back(i), s_.is_free[i] = 1;
    return true;
  }

  /// Removes the k-th free row; updates the factor of the rows after it.
  void remove(std::size_t k) {
    const std::size_t count = s_.free.size();
    s_.is_free[s_.free[k]] = 0;
    for (std::size_t i = k + 1; i < count; ++i) s_.column[i] = l(i, k);
    s_.free.erase(s_.free.begin() + static_cast<std::ptrdiff_t>(k));
    for (std::size_t i = k; i + 1 < count; ++i) {
      for (std::size_t j = 0; j < k; ++j) l(i, j) = l(i + 1, j);
      for (std::size_t j = k; j <= i; ++j) l(i, j) = l(i + 1, j + 1);
    }
    for (std::size_t j = k; j + 1 < count; ++j) {
      const Real before = l(j, j), size = std::hypot(before, s_.column[j + 1]);
      const Real c = before / size, sine = s_.column[j + 1] / size;
      l(j, j) = size;
      for (std::size_t i = j + 1; i + 1 < count; ++i) {
        const Real under = l(i, j), beside = s_.column[i + 1];
        l(i, j) = c * under + sine * beside;
        s_.column[i + 1] = c * beside - sine * under;
      }
    }
  }

  /// Solves `step` = -W_FF^-1 r for the free rows, in place.
  void solve_free() {
    const std::size_t count = s_.free.size();
    std::vector<Real>& z = s_.column;
    for (std::size_t k = 0; k < count; ++k) {
      Real sum = -s_.step[s_.free[k]];
      for (std::size_t j = 0; j < k; ++j) sum -= l(k, j) * z[j];
      z[k] = sum / l(k, k);
    }
    for (std::size_t k = count; k-- > 0;) {
      for (std::size_t j = k + 1; j < count; ++j) z[k] -= l(j, k) * z[j];
      z[k] /= l(k, k);
    }
    for (std::size_t k = 0; k < count; ++k) s_.step[s_.free[k]] = z[k];
  }

  /// w = W x + b, and the magnitude of the terms of row i.
  Real velocity_of(std::size_t i, Real& size) const {
    Real sum = p_.bias[i];
    size = std::abs(sum);
    for (std::size_t j = 0; j < n_; ++j) {
      if (x_[j] == 0) continue;
      const Real term = w(i, j) * x_[j];
      sum += term, size += std::abs(term);
    }
    return sum;
  }

  /// Ratio test: the largest fraction of `step`, up to `most`, that keeps the free rows within
  /// their bounds; and the position of the blocking row among them.
  Real find_way(Real most, std::size_t& at) const {
    at = s_.free.size();
    for (std::size_t k = 0; k < s_.free.size(); ++k) {
      const std::uint32_t i = s_.free[k];
      const Real d = s_.step[i];
      const Real bound = d < 0 ? p_.bounds[i].lower : p_.bounds[i].upper;
      if (d == 0 || std::isinf(bound)) continue;
      const Real way = std::max(Real(0), (bound - x_[i]) / d);
      if (way < most) most = way, at = k;
    }
    return most;
  }

  void move(Real way) {
    for (const std::uint32_t i : s_.free) x_[i] += way * s_.step[i];
  }

  void stop_at_bound(std::size_t k) {
    const std::uint32_t i = s_.free[k];
    x_[i] = s_.step[i] < 0 ? p_.bounds[i].lower : p_.bounds[i].upper;
    remove(k);
  }

  /// Moves to the minimum over the free rows; rows that reach a bound are fixed there.
  bool descend() {
    for (std::size_t left = s_.free.size() + 1; left-- > 0;) {
      for (const std::uint32_t i : s_.free) s_.step[i] = velocity_of(i, s_.velocity[i]);
      solve_free();
      std::size_t at = 0;
      const Real way = find_way(1, at);
      if (!std::isfinite(way)) return false;
      for (const std::uint32_t i : s_.free)
        if (!std::isfinite(s_.step[i])) return false;
      move(way);
      if (at == s_.free.size()) return true;
      stop_at_bound(at);
    }
    return true;
  }

  /// The row at a bound with an inadmissible velocity, largest relative to its response; n if none.
  std::uint32_t find_entering(Entering rule) const {
    std::uint32_t best = static_cast<std::uint32_t>(n_);
    Real most = 0;
    for (std::uint32_t i = 0; i < n_; ++i) {
      if (s_.is_free[i] != 0 || !(w(i, i) > 0)) continue;
      Real size = 0;
      const Real v = velocity_of(i, size);
      const bool rises = v < 0 && x_[i] < p_.bounds[i].upper;
      const bool falls = v > 0 && x_[i] > p_.bounds[i].lower;
      const Real weighed = std::abs(v) / std::sqrt(w(i, i));
      if (!(rises || falls) || !(std::abs(v) > kRounding * size) || !(weighed > most)) continue;
      best = i, most = weighed;
      if (rule == Entering::lowest) break;
    }
    return best;
  }

  /// Row i depends on the free ones. Moves the impulses in the null direction until a free row
  /// reaches its bound, then exchanges it for i. Returns false if none ever does.
  bool exchange(std::uint32_t i) {
    Real size = 0;
    const Real sign = velocity_of(i, size) < 0 ? 1 : -1;
    for (const std::uint32_t j : s_.free) s_.step[j] = sign * w(j, i);
    solve_free();
    const Real own = sign > 0 ? p_.bounds[i].upper - x_[i] : x_[i] - p_.bounds[i].lower;
    std::size_t at = 0;
    const Real way = find_way(own, at);
    if (!std::isfinite(way)) return false;
    move(way), x_[i] += sign * way;
    if (at == s_.free.size()) {
      x_[i] = sign > 0 ? p_.bounds[i].upper : p_.bounds[i].lower;
      return true;
    }
    stop_at_bound(at);
    return add(i);
  }

  const ComplementarityProblem& p_;
  std::span<Real> x_;
  ComplementarityScratch& s_;
  std::size_t n_;
};

}  // namespace

void reserve(ComplementarityScratch& scratch, std::size_t n) {
  scratch.factor.reserve(n * n), scratch.free.reserve(n), scratch.is_free.reserve(n);
  scratch.velocity.reserve(n), scratch.step.reserve(n), scratch.column.reserve(n);
}

bool solve_complementarity(const ComplementarityProblem& problem, std::span<Real> x,
                           ComplementarityScratch& scratch) {
  return ActiveSet(problem, x, scratch).solve();
}

}  // namespace pantin::detail
