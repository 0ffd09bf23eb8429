#pragma once
/// Entity handles: a reusable index and a generation that is never reused.
#include <cstdint>
#include <functional>
#include <vector>

#include "engine/base/fields.hpp"

namespace pantin {

/// A handle to an object in a World. The default one refers to nothing.
struct Entity {
  std::uint32_t index = UINT32_MAX;
  std::uint32_t generation = 0;

  friend bool operator==(const Entity&, const Entity&) = default;
  explicit operator bool() const { return index != UINT32_MAX; }

  static void fields(auto& self, auto&& field) {
    field("index", self.index);
    field("generation", self.generation);
  }
};

namespace detail {

/// Allocates handles. The generation distinguishes a destroyed handle from the one that reuses its
/// index.
class Entities {
 public:
  Entity create() {
    ++alive_;
    if (free_.empty()) return {count_++, 0};
    const std::uint32_t index = free_.back();
    free_.pop_back();
    return {index, generation_of(index)};
  }

  void destroy(Entity e) {
    if (!is_alive(e)) return;
    --alive_;
    if (e.index >= generations_.size()) generations_.resize(e.index + 1, 0);
    ++generations_[e.index];
    free_.push_back(e.index);
  }

  bool is_alive(Entity e) const {
    return e.index < count_ && generation_of(e.index) == e.generation;
  }
  std::size_t alive() const { return alive_; }
  /// The peak number of handles that were in use at once.
  std::size_t capacity() const { return count_; }

  /// Stores the generations of all handles, for saving. Otherwise those after the last destroyed
  /// handle are left out, since they are 0.
  void write_out() { generations_.resize(count_, 0); }

  // Complete after write_out() only.
  static void fields(auto& self, auto&& field) {
    field("generations", self.generations_);
    field("free", self.free_);
    field("count", derived(self.count_));
    field("alive", derived(self.alive_));
  }
  /// Counts the live handles after reading; returns null, or the fault.
  const char* restored() {
    if (free_.size() > generations_.size()) return "has more free indices than indices";
    std::vector<bool> seen(generations_.size(), false);
    for (std::uint32_t index : free_) {
      if (index >= seen.size() || seen[index]) return "lists an invalid free index";
      seen[index] = true;
    }
    count_ = static_cast<std::uint32_t>(generations_.size());
    alive_ = count_ - free_.size();
    while (!generations_.empty() && generations_.back() == 0) generations_.pop_back();
    generations_.shrink_to_fit();
    return nullptr;
  }

 private:
  std::uint32_t generation_of(std::uint32_t index) const {
    return index < generations_.size() ? generations_[index] : 0;
  }

  std::vector<std::uint32_t> generations_;  // up to the last handle that was ever destroyed
  std::vector<std::uint32_t> free_;
  std::uint32_t count_ = 0;
  std::size_t alive_ = 0;
};

/// For hash_fields: a handle counts by its index and whether it is alive, not by its generation. A
/// new handle that reuses an index hashes alike.
struct EntityRule {
  const Entities& entities;
  void operator()(Hash& hash, const Entity& e) const {
    hash.add(e.index), hash.add(entities.is_alive(e));
  }
};

}  // namespace detail
}  // namespace pantin

template <>
struct std::hash<pantin::Entity> {
  std::size_t operator()(pantin::Entity e) const noexcept {
    return (static_cast<std::size_t>(e.generation) << 32) ^ e.index;
  }
};
