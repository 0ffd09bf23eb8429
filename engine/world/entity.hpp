#pragma once
/// Handles: an index that is used again and a generation that is not.
#include <cstdint>
#include <functional>
#include <vector>

namespace pantin {

/// A handle to something in a World. The default one names nothing.
struct Entity {
  std::uint32_t index = UINT32_MAX;
  std::uint32_t generation = 0;

  friend bool operator==(const Entity&, const Entity&) = default;
  explicit operator bool() const { return index != UINT32_MAX; }
};

/// Hands out handles; one that was destroyed is told from the one that got its place.
class Entities {
 public:
  Entity create() {
    ++alive_;
    if (free_.empty()) {
      generations_.push_back(0);
      return {static_cast<std::uint32_t>(generations_.size() - 1), 0};
    }
    const std::uint32_t index = free_.back();
    free_.pop_back();
    return {index, generations_[index]};
  }

  void destroy(Entity e) {
    if (!is_alive(e)) return;
    --alive_;
    ++generations_[e.index];
    free_.push_back(e.index);
  }

  bool is_alive(Entity e) const {
    if (e.index >= generations_.size() || generations_[e.index] != e.generation) return false;
    return true;
  }
  std::size_t alive() const { return alive_; }

 private:
  std::vector<std::uint32_t> generations_;
  std::vector<std::uint32_t> free_;
  std::size_t alive_ = 0;
};

}  // namespace pantin

template <>
struct std::hash<pantin::Entity> {
  std::size_t operator()(pantin::Entity e) const noexcept {
    return (static_cast<std::size_t>(e.generation) << 32) ^ e.index;
  }
};
