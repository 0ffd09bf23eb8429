#pragma once
/// Cancels long work.
#include <cstdint>
#include <functional>

namespace pantin::detail {

/// Thrown when reading is cancelled; parse_scene() catches it.
struct Cancelled {};

/// Checks from time to time whether the work was cancelled.
class Poll {
 public:
  Poll() = default;
  explicit Poll(std::function<bool()> is_cancelled) : is_cancelled_(std::move(is_cancelled)) {}

  /// Call it for every item; it is cheap. Throws Cancelled.
  void operator()() {
    if (is_cancelled_ && (++items_ & 0x3FF) == 0 && is_cancelled_()) throw Cancelled{};
  }

 private:
  std::function<bool()> is_cancelled_;
  std::uint32_t items_ = 0;
};

}  // namespace pantin::detail
