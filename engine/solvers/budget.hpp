#pragma once
/// The time in which a step should be computed, shared among groups of bodies in contact.
#include <algorithm>
#include <chrono>
#include <functional>

#include "engine/base/math.hpp"
#include "engine/world/entity.hpp"

namespace pantin::detail {

using Clock = std::chrono::steady_clock;

/// When a substep has to end, and who decides what matters.
struct Budget {
  Clock::time_point until;
  const std::function<Real(Entity)>* importance = nullptr;  // StepSettings::importance
};

/// The number of equal substeps that a group can afford, from the measured duration of the last.
class Pace {
 public:
  Pace() = default;
  /// `expected`: s, of a substep, 0 if unknown.
  Pace(Clock::time_point until, Real expected)
      : is_bounded_(true), now_(Clock::now()), until_(until), each_(expected) {}

  /// Of `left` substeps that accuracy asks for, as many as there is time for; of a step at least
  /// two, since bodies would pass through one another.
  int affordable(int left) {
    if (taken_ == 0) planned_ = left;
    if (!is_bounded_ || !(each_ > 0)) return left;
    const Real time = std::chrono::duration<Real>(until_ - now_).count();
    const int least = std::clamp(kLeastSubsteps - taken_, 1, left);
    return std::clamp(static_cast<int>(std::clamp(time / each_, Real(0), Real(left))), least, left);
  }
  /// All of `left` substeps: for groups that cannot do with fewer.
  int all_of(int left) {
    if (taken_ == 0) planned_ = left;
    return left;
  }
  /// After each substep.
  void note_substep() {
    ++taken_;
    if (!is_bounded_) return;
    const Clock::time_point before = now_;
    now_ = Clock::now();
    each_ = std::chrono::duration<Real>(now_ - before).count();
  }
  int planned() const { return planned_; }
  int taken() const { return taken_; }

 private:
  static constexpr int kLeastSubsteps = 2;

  bool is_bounded_ = false;
  Clock::time_point now_, until_;
  Real each_ = 0;
  int planned_ = 0, taken_ = 0;
};

}  // namespace pantin::detail
