#pragma once
/// Extrapolation of sweeps that are iterated to convergence.
///
/// Sweeps over a few bodies that press on one another with friction leave nine tenths of their last
/// error: hundreds are needed. The error is soon that of one mode, which each sweep there and back
/// multiplies by the same ratio r. Once r is steady, the impulses are extrapolated by r / (1 - r)
/// times their last change, to the limit of that mode, and projected to Coulomb's cones. [Aitken
/// 1926] Where r is near 1, as between masses of 1 and 1,000, its distance from 1 is too uncertain:
/// there the impulses move along their last change to the least kinetic energy, exactly. Not of a
/// body alone, which walls that close may jam. What that gives several bodies between such walls is
/// bounded by the energy (group_few.cpp).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/solvers/articulated/impulses/group_points.hpp"

namespace pantin::detail::articulated {

class Extrapolation {
 public:
  Extrapolation(const Group& g, const Substep& s, Sweep sweep)
      : g_(g),
        substep_(s),
        sweep_(sweep),
        acts_(g.contacts.size() <= kMostContacts),
        last_extrapolation_(s.most_sweeps - kSweepsAfter) {}

  /// After a sweep that changed speeds by `most`, m/s.
  void follow(Real most) {
    if (!acts_ || ++sweeps_ < kPlainSweeps || sweeps_ % 2 != 0) return;
    const Real ratio = most / most_;
    const bool is_steady = std::abs(ratio - ratio_) < kSteady * ratio;
    const bool is_sound =
        ratio > kSlow && ratio < (substep_.alone ? kStill : 1) && most < extrapolated_at_;
    const bool extrapolates = is_steady && is_sound && sweeps_ < last_extrapolation_;
    const Real by = !extrapolates ? 0 : ratio < kStill ? ratio / (1 - ratio) : least_energy();
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
  /// Relative speeds of a contact, less those that it may keep, along its axes, m/s.
  Vec3 speed_of(const GroupContact& c) const {
    const Vec3 u = speed_at(g_.a(c), c.arm_a) - speed_at(g_.b(c), c.arm_b);
    const Real goal = goal_of(c, spring_of(g_, c, substep_), substep_, sweep_).speed;
    return {glm::dot(c.axes[0], u) - goal, glm::dot(c.axes[1], u) + c.surface_first,
            glm::dot(c.axes[2], u) + c.surface_second};
  }
  /// The multiple of the last change of the impulses that leaves the least energy. 0 if they
  /// balance one another, as between bodies that are jammed.
  Real least_energy() {
    Real slope = 0, bend = 0, own = 0;
    for (std::size_t i = 0; i < g_.contacts.size(); ++i) {
      const GroupContact& c = g_.contacts[i];
      if (!c.works) continue;
      const Vec3 change = c.impulse - last_[i];
      slope += glm::dot(change, speed_of(c)), own += glm::dot(change, change) * c.along;
    }
    const auto push_all = [&](Real by) {
      for (std::size_t i = 0; i < g_.contacts.size(); ++i)
        if (g_.contacts[i].works) push_by(g_.contacts[i], by * (g_.contacts[i].impulse - last_[i]));
    };
    push_all(1);
    for (std::size_t i = 0; i < g_.contacts.size(); ++i) {
      const GroupContact& c = g_.contacts[i];
      if (c.works) bend += glm::dot(c.impulse - last_[i], speed_of(c));
    }
    push_all(-1);
    bend -= slope;
    const Real balanced = closing_speed_of_walls(g_, substep_) > 0 ? kWedged : kBalanced;
    return bend > balanced * own ? std::max(Real(0), -slope / bend) : 0;
  }

  /// Sweeps before the first that is looked at: most groups need no more. Sweeps at least after an
  /// extrapolation: these remove the energy that it may have added.
  static constexpr int kPlainSweeps = 8, kSweepsAfter = 12;
  static constexpr std::size_t kMostContacts = 48;
  /// Relative change of a steady ratio; ratios below which sweeps converge soon; above which bodies
  /// may be jammed, and impulses grow without end.
  static constexpr Real kSteady = 0.03, kSlow = 0.5, kStill = 0.96;
  /// Response to a change of all impulses, relative to those of the contacts alone, of bodies that
  /// are jammed; between walls that close, where a wedge of half a degree still moves.
  static constexpr Real kBalanced = 1e-8, kWedged = 1e-4;

  void move(GroupContact& c, Vec3 to) {
    to.x = std::max(Real(0), to.x);
    const Real aside = std::hypot(to.y, to.z), bound = c.friction * to.x;
    if (aside > bound) to.y *= bound / aside, to.z *= bound / aside;
    push_by(c, to - c.impulse);
    c.impulse = to;
  }
  /// Applies an impulse without adding it to the contact's.
  void push_by(GroupContact& c, Vec3 impulse) {
    const Vec3 kept = std::exchange(c.impulse, impulse);
    push(g_, c);
    c.impulse = kept;
  }

  const Group& g_;
  const Substep& substep_;
  const Sweep sweep_;
  bool acts_;
  int last_extrapolation_, sweeps_ = 0;
  Real most_ = 0, ratio_ = 0;  // of the last pair of sweeps
  Real extrapolated_at_ = std::numeric_limits<Real>::infinity();
  std::array<Vec3, kMostContacts> last_;
};

}  // namespace pantin::detail::articulated
