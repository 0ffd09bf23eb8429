#pragma once
/// Data that takes no room where there is none.
#include <memory>

namespace pantin {

/// A value that most owners leave as it is by default. A value itself: copies are deep.
template <class T>
class Rare {
 public:
  Rare() = default;
  Rare(const Rare& o) { *this = o; }
  Rare(Rare&&) = default;
  Rare& operator=(const Rare& o) {
    held_ = o.held_ ? std::make_unique<T>(*o.held_) : nullptr;
    return *this;
  }
  Rare& operator=(Rare&&) = default;

  const T& operator*() const {
    static const T kNone{};
    return held_ ? *held_ : kNone;
  }
  const T* operator->() const { return &**this; }
  bool any() const { return held_ != nullptr; }

  /// For changing it; it takes room from now on.
  T& edit() {
    if (!held_) held_ = std::make_unique<T>();
    return *held_;
  }

  static void fields(auto& self, auto&& field) { field("held", self.held_); }

 private:
  std::unique_ptr<T> held_;
};

}  // namespace pantin
