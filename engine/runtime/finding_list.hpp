#pragma once
/// Findings of a run, each kind once for each body, joint or cable, in the order of time.
#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "engine/world/findings.hpp"

namespace pantin::detail {

/// Takes its memory when it is opened; what does not fit is counted with what is there.
class FindingList {
 public:
  void open() {
    if (findings_.capacity() == 0) findings_.reserve(kKinds * kMostOfKind);
    noted_.reserve(findings_.capacity());
  }
  /// From here on things are found at `time`, s.
  void set_time(Real time) { time_ = time; }
  /// What is found again after this counts as found in one step more.
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
  std::vector<std::uint64_t> noted_;  // the step in which each was last
  std::array<std::size_t, kKinds> counts_{};
  Real time_ = 0;
  std::uint64_t step_ = 0;
};

}  // namespace pantin::detail
