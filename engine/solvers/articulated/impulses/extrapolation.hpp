#pragma once
/// Extrapolation of sweeps that are iterated to convergence.
///
/// Sweeps over a few bodies that press on one another with friction leave nine tenths of their last
/// error: hundreds are needed. The error is soon that of one mode, which each sweep there and back
/// multiplies by the same ratio r. Once r is steady, the impulses are extrapolated by r / (1 - r)
/// times their last change, to the limit of that mode, and projected to Coulomb's cones. [Aitken
/// 1926]
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/solvers/articulated/impulses/group_points.hpp"

namespace pantin::detail::articulated {

class Extrapolation {
 public:
  Extrapolation(const Group& g, int most_sweeps)
      : g_(g),
        acts_(g.contacts.size() <= kMostContacts),
        last_extrapolation_(most_sweeps - kSweepsAfter) {}

  /// After a sweep that changed speeds by `most`, m/s.
  void follow(Real most) {
    if (!acts_ || ++sweeps_ < kPlainSweeps || sweeps_ % 2 != 0) return;
    const Real ratio = most / most_;
    const bool is_steady = std::abs(ratio - ratio_) < kSteady * ratio;
    const bool is_sound = ratio > kSlow && ratio < kStill && most < extrapolated_at_;
    const bool extrapolates = is_steady && is_sound && sweeps_ < last_extrapolation_;
    const Real by = ratio / (1 - ratio);
    for (std::size_t i = 0; i < g_.contacts.size(); ++i) {
      GroupContact& c = g_.contacts[i];
      const Vec3 swept = c.impulse;
      if (extrapolates && c.works) move(c, swept + by * (swept - last_[i]));
      last_[i] = swept;
    }
    if (extrapolates) extrapolated_at_ = most;
    ratio_ = extrapolates ? 0 : ratio, most_ = most;
  }

 private:
  /// Sweeps before the first that is looked at: most groups need no more. Sweeps at least after an
  /// extrapolation: these remove the energy that it may have added.
  static constexpr int kPlainSweeps = 8, kSweepsAfter = 12;
  static constexpr std::size_t kMostContacts = 48;
  /// Relative change of a steady ratio; ratios below which sweeps converge soon; above which bodies
  /// may be jammed, and impulses grow without end.
  static constexpr Real kSteady = 0.03, kSlow = 0.5, kStill = 0.96;

  void move(GroupContact& c, Vec3 to) {
    to.x = std::max(Real(0), to.x);
    const Real aside = std::hypot(to.y, to.z), bound = c.friction * to.x;
    if (aside > bound) to.y *= bound / aside, to.z *= bound / aside;
    const Vec3 from = c.impulse;
    c.impulse = to - from;
    push(g_, c);
    c.impulse = to;
  }

  const Group& g_;
  bool acts_;
  int last_extrapolation_, sweeps_ = 0;
  Real most_ = 0, ratio_ = 0;  // of the last pair of sweeps
  Real extrapolated_at_ = std::numeric_limits<Real>::infinity();
  std::array<Vec3, kMostContacts> last_;
};

}  // namespace pantin::detail::articulated
