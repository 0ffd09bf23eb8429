#pragma once
/// A list whose values stay where they are when others come and go: large values that are inserted
/// and removed amid many others.
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "engine/base/fields.hpp"

namespace pantin::detail {

template <class T>
class StableVector {
  using Box = std::unique_ptr<T>;
  template <class Value, class At>
  class Iterator {
   public:
    using difference_type = std::ptrdiff_t;
    using value_type = T;
    explicit Iterator(At at = {}) : at_(at) {}
    Value& operator*() const { return **at_; }
    Iterator& operator++() { return ++at_, *this; }
    Iterator operator++(int) { return Iterator(at_++); }
    bool operator==(const Iterator&) const = default;

   private:
    At at_;
  };

 public:
  using value_type = T;

  StableVector() = default;
  StableVector(const StableVector& other) {
    reserve(other.size());
    for (const T& value : other) push_back(T(value));
  }
  StableVector(StableVector&&) = default;
  StableVector& operator=(const StableVector& other) { return *this = StableVector(other); }
  StableVector& operator=(StableVector&&) = default;

  std::size_t size() const { return boxes_.size(); }
  bool empty() const { return boxes_.empty(); }
  T& operator[](std::size_t i) { return *boxes_[i]; }
  const T& operator[](std::size_t i) const { return *boxes_[i]; }
  auto begin() { return Iterator<T, typename std::vector<Box>::iterator>(boxes_.begin()); }
  auto end() { return Iterator<T, typename std::vector<Box>::iterator>(boxes_.end()); }
  auto begin() const {
    return Iterator<const T, typename std::vector<Box>::const_iterator>(boxes_.begin());
  }
  auto end() const {
    return Iterator<const T, typename std::vector<Box>::const_iterator>(boxes_.end());
  }

  void reserve(std::size_t count) { boxes_.reserve(count); }
  void resize(std::size_t count) {
    const std::size_t before = size();
    boxes_.resize(count);
    for (std::size_t i = before; i < count; ++i) boxes_[i] = std::make_unique<T>();
  }
  void push_back(T&& value) { boxes_.push_back(std::make_unique<T>(std::move(value))); }
  /// Appends values [from, end) of another list, which loses them.
  void append_from(StableVector& other, std::size_t from) {
    for (std::size_t i = from; i < other.size(); ++i) boxes_.push_back(std::move(other.boxes_[i]));
    other.boxes_.resize(from);
  }
  /// Moves the value at `i` to the end of another list; its place must not be used again.
  void give(std::size_t i, StableVector& to) { to.boxes_.push_back(std::move(boxes_[i])); }

 private:
  std::vector<Box> boxes_;
};

/// It is saved and hashed like a vector.
template <class T>
inline constexpr bool fields::kIsVector<StableVector<T>> = true;

}  // namespace pantin::detail
