#pragma once
/// What solvers remember of a World from step to step. The World knows nothing of it but how to copy
/// it, so that a copy of a World is a snapshot and goes on alike.
#include <memory>
#include <type_traits>
#include <vector>

#include "engine/base/hash.hpp"
#include "engine/world/store.hpp"

namespace pantin {

/// Memory that may be thrown away between steps; a copy starts empty.
template <class T>
struct Scratch : T {
  Scratch() = default;
  Scratch(const Scratch&) : T() {}
  Scratch(Scratch&&) = default;
  Scratch& operator=(const Scratch&) {
    static_cast<T&>(*this) = T();
    return *this;
  }
  Scratch& operator=(Scratch&&) = default;
};

/// One value of each type that asks for one, copied and hashed together. A type offers
/// `void add_to(Hash&) const` for what decides the next step.
class Memories {
 public:
  Memories() = default;
  Memories(const Memories& other) { *this = other; }
  Memories(Memories&&) = default;
  Memories& operator=(Memories&&) = default;
  Memories& operator=(const Memories& other) {
    if (this == &other) return *this;
    std::vector<std::unique_ptr<Any>> copies;
    for (const auto& one : other.values_) copies.push_back(one->clone());
    values_ = std::move(copies);
    return *this;
  }

  /// The value of type `T`, made on first use.
  template <class T>
  T& of() {
    if (Any* found = find(&kTypeName<T>)) return static_cast<One<T>*>(found)->value;
    values_.push_back(std::make_unique<One<T>>());
    return static_cast<One<T>&>(*values_.back()).value;
  }
  /// ... or an empty one where none was made.
  template <class T>
  const T& of() const {
    if (const Any* found = find(&kTypeName<T>)) return static_cast<const One<T>*>(found)->value;
    static const T kNone{};
    return kNone;
  }

  void add_to(Hash& hash) const {
    for (const auto& one : values_) one->add_to(hash);
  }

 private:
  struct Any {
    explicit Any(const void* t) : type(t) {}
    virtual ~Any() = default;
    virtual std::unique_ptr<Any> clone() const = 0;
    virtual void add_to(Hash& hash) const = 0;
    const void* type;
  };
  template <class T>
  struct One final : Any {
    One() : Any(&kTypeName<T>) {}
    std::unique_ptr<Any> clone() const override {
      auto copy = std::make_unique<One>();
      copy->value = value;
      return copy;
    }
    void add_to(Hash& hash) const override { value.add_to(hash); }
    T value;
  };

  Any* find(const void* type) const {
    for (const auto& one : values_)
      if (one->type == type) return one.get();
    return nullptr;
  }

  std::vector<std::unique_ptr<Any>> values_;
};

}  // namespace pantin
