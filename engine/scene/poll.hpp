#pragma once
/// Lets long work be called off.
#include <cstdint>
#include <functional>

namespace pantin::detail {

/// Thrown where reading was called off; parse_scene() catches it.
struct Cancelled {};

/// Asks now and then whether the work is still wanted.
class Poll {
 public:
  Poll() = default;
  explicit Poll(std::function<bool()> is_cancelled) : is_cancelled_(std::move(is_cancelled)) {}

  /// To be called for every item; cheap. Throws Cancelled.
  void operator()() {
    if (is_cancelled_ && (++items_ & 0x3FF) == 0 && is_cancelled_()) throw Cancelled{};
  }

 private:
  std::function<bool()> is_cancelled_;
  std::uint32_t items_ = 0;
};

}  // namespace pantin::detail
