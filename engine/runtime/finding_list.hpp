#pragma once
/// Findings of a run, one of each kind for each body, joint or cable, in the order of time.
#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "engine/world/findings.hpp"

namespace pantin::detail {

/// Allocates when it is opened. If it is full, further findings are counted with existing ones.
class FindingList {
 public:
  void open() {
    if (findings_.capacity() == 0) findings_.reserve(kKinds * kMostOfKind);
    noted_.reserve(findings_.capacity());
  }
  /// Sets the time of the following findings, s.
  void set_time(Real time) { time_ = time; }
  /// Ends a step: later notes of the same finding count as one step more.
  void end_step() { ++step_; }

  void note(FindingKind kind, Entity where, Real amount) {
    const auto same = [&](const Finding& f) { return f.kind == kind && f.where == where; };
    const auto found = std::find_if(findings_.begin(), findings_.end(), same);
    if (found == findings_.end()) {
      std::size_t& count = counts_[static_cast<std::size_t>(kind)];
      if (count == kMostOfKind) return;
      ++count;
      findings_.push_back({kind, where, time_, amount, 1}), noted_.push_back(step_);
      return;
    }
    std::uint64_t& noted = noted_[static_cast<std::size_t>(found - findings_.begin())];
    found->amount = std::max(found->amount, amount);
    if (noted != step_) ++found->steps, noted = step_;
  }

  std::span<const Finding> all() const { return findings_; }

 private:
  static constexpr std::size_t kMostOfKind = 64,
                               kKinds = static_cast<std::size_t>(last_of(FindingKind{})) + 1;

  std::vector<Finding> findings_;
  std::vector<std::uint64_t> noted_;  // the step in which each was last noted
  std::array<std::size_t, kKinds> counts_{};
  Real time_ = 0;
  std::uint64_t step_ = 0;
};

}  // namespace pantin::detail
