#pragma once
/// Optional data on the heap.
///
/// Internal (pantin::detail); installed because joints in World::links hold such values.
#include <memory>

namespace pantin::detail {

/// A value that most owners leave at its default; needs no memory then. Copies are deep.
template <class T>
class Boxed {
 public:
  Boxed() = default;
  Boxed(const Boxed& o) { *this = o; }
  Boxed(Boxed&&) = default;
  Boxed& operator=(const Boxed& o) {
    held_ = o.held_ ? std::make_unique<T>(*o.held_) : nullptr;
    return *this;
  }
  Boxed& operator=(Boxed&&) = default;

  const T& operator*() const {
    static const T kNone{};
    return held_ ? *held_ : kNone;
  }
  const T* operator->() const { return &**this; }
  bool any() const { return held_ != nullptr; }

  /// For changing it; allocates memory.
  T& edit() {
    if (!held_) held_ = std::make_unique<T>();
    return *held_;
  }

  static void fields(auto& self, auto&& field) { field("held", self.held_); }

 private:
  std::unique_ptr<T> held_;
};

}  // namespace pantin::detail
