#pragma once
/// Solver state that belongs to a World. The World only copies and hashes it, so that a copy is a
/// snapshot that continues identically.
///
/// Internal (pantin::detail); installed because a World holds it.
#include <memory>
#include <string>
#include <string_view>
#include <typeinfo>
#include <vector>

#include "engine/base/archive.hpp"
#include "engine/world/store.hpp"

namespace pantin::detail {

/// Scratch memory that does not persist between steps; a copy starts empty.
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

/// One value of each requested type; all are copied, hashed and saved together. A type lists its
/// fields: see base/fields.hpp. In files its key is `T::name`, or the compiler's name of the type.
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

  /// The value of type `T`, created on first use.
  template <class T>
  T& of() {
    if (Any* found = find(&kTypeName<T>)) return static_cast<One<T>*>(found)->value;
    return create<T>();
  }
  /// The same for reading; an empty value if there is none.
  template <class T>
  const T& of() const {
    if (const Any* found = find(&kTypeName<T>)) return static_cast<const One<T>*>(found)->value;
    return none<T>();
  }

  void add_to(Hash& hash, const EntityRule& rule) const {
    for (const auto& one : values_) one->add_to(hash, rule);
  }

  /// Writes the part of each value that the step needs, with its name.
  void write(FieldWriter& to) const {
    for (const auto& one : values_) {
      FieldWriter own;
      one->write(own);
      if (own.bytes().empty()) continue;
      to.write(std::string(one->name())), to.write(one->fingerprint()), to.write(own.bytes());
    }
    to.write(std::string());
  }
  /// Reads into existing values, compiled for the same structure; returns null, or the fault.
  const char* read(FieldReader& from) {
    for (std::string name, bytes; from.ok();) {
      std::uint64_t fingerprint = 0;
      from.read(name);
      if (name.empty()) break;
      from.read(fingerprint), from.read(bytes);
      if (!from.ok()) break;
      Any* one = find(name);
      if (!one || one->fingerprint() != fingerprint) return "contains data of an unknown solver";
      FieldReader own(bytes);
      one->read(own);
      if (!own.ok() || own.left() > 0)
        return "contains solver data that does not match the structure";
    }
    return nullptr;
  }

 private:
  struct Any {
    explicit Any(const void* t) : type(t) {}
    virtual ~Any() = default;
    virtual std::unique_ptr<Any> clone() const = 0;
    virtual void add_to(Hash& hash, const EntityRule& rule) const = 0;
    virtual std::string_view name() const = 0;
    virtual std::uint64_t fingerprint() const = 0;
    virtual void write(FieldWriter& to) const = 0;
    virtual void read(FieldReader& from) = 0;
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
    void add_to(Hash& hash, const EntityRule& rule) const override {
      hash_fields(hash, value, rule);
    }
    std::string_view name() const override {
      if constexpr (requires { std::string_view(T::name); })
        return T::name;
      else
        return typeid(T).name();
    }
    std::uint64_t fingerprint() const override { return fields_fingerprint<T>(); }
    void write(FieldWriter& to) const override { to.write(value); }
    void read(FieldReader& from) override { from.read(value); }
    T value;
  };

  template <class T>
  T& create();
  template <class T>
  static const T& none();

  Any* find(const void* type) const {
    for (const auto& one : values_)
      if (one->type == type) return one.get();
    return nullptr;
  }

  Any* find(std::string_view name) const {
    for (const auto& one : values_)
      if (one->name() == name) return one.get();
    return nullptr;
  }

  std::vector<std::unique_ptr<Any>> values_;
};

// Defined outside the class so that they are not inline; otherwise all code that copies, hashes and
// saves T is compiled in each unit. A large T declares them `extern` and instantiates them in one
// unit.
template <class T>
T& Memories::create() {
  values_.push_back(std::make_unique<One<T>>());
  return static_cast<One<T>&>(*values_.back()).value;
}

template <class T>
const T& Memories::none() {
  static const T kNone{};
  return kNone;
}

}  // namespace pantin::detail
