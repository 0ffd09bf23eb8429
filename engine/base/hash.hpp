#pragma once
/// A 64-bit hash of state, computed from the bits of the numbers: equal states have equal hashes.
///
/// Internal (pantin::detail); installed because stores of user components hash themselves.
#include <cstdint>
#include <cstring>
#include <string_view>

#include "engine/base/math.hpp"

namespace pantin::detail {

__extension__ using Wide = unsigned __int128;

/// Multiply-and-fold over 64-bit words (the mixing step of wyhash, public domain).
class Hash {
 public:
  void add(std::uint64_t word) {
    const auto wide = static_cast<Wide>(state_ ^ word) * 0x9E3779B97F4A7C15ull;
    state_ = static_cast<std::uint64_t>(wide) ^ static_cast<std::uint64_t>(wide >> 64) ^
             (word + 0xD1B54A32D192ED03ull);
  }
  void add(Real number) {
    std::uint64_t bits;
    std::memcpy(&bits, &number, sizeof bits);
    add(bits);
  }
  void add(std::int64_t number) { add(static_cast<std::uint64_t>(number)); }
  void add(std::uint32_t number) { add(static_cast<std::uint64_t>(number)); }
  void add(std::int32_t number) { add(static_cast<std::uint64_t>(number)); }
  void add(bool yes) { add(static_cast<std::uint64_t>(yes)); }
  void add(Vec3 v) { add(v.x), add(v.y), add(v.z); }
  void add(Quat q) { add(q.x), add(q.y), add(q.z), add(q.w); }
  void add(const Pose& p) { add(p.position), add(p.rotation); }
  void add(std::string_view text) {
    add(static_cast<std::uint64_t>(text.size()));
    for (char c : text) add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
  }

  std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_ = 0x243F6A8885A308D3ull;
};

}  // namespace pantin::detail
