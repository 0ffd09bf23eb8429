#pragma once
/// Structs with `fields` to bytes and back. Numbers are stored in their memory representation, so
/// that the same bits come back; the byte order is that of the machine.
///
/// Internal (pantin::detail); installed because stores of user components read and write
/// themselves.
#include <cstring>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "engine/base/fields.hpp"

namespace pantin::detail {

/// A function that a type runs once all its fields are read: it rebuilds derived data, and returns
/// null, or the fault as a clause.
template <class T>
concept HasRestored = requires(T& value) {
  { value.restored() } -> std::convertible_to<const char*>;
};

/// Writes fields to bytes.
class FieldWriter {
 public:
  template <class T>
  void write(const T& value) {
    if constexpr (Leaf<T>) {
      put(&value, sizeof value);
    } else if constexpr (std::same_as<T, std::string>) {
      put_count(value.size()), put(value.data(), value.size());
    } else if constexpr (FixedParts<const T>) {
      write_parts(value);
    } else if constexpr (fields::kIsVector<T>) {
      put_count(value.size());
      for (const auto& element : value) write(element);
    } else if constexpr (fields::kIsVariant<T>) {
      put_byte(static_cast<unsigned char>(value.index()));
      std::visit([&](const auto& held) { write(held); }, value);
    } else if constexpr (fields::kIsOptional<T> || fields::kIsBox<T>) {
      put_byte(value ? 1 : 0);
      if (value) write(*value);
    } else if constexpr (fields::kIsShared<T>) {
      write_shared(value);
    } else {
      static_assert(HasFields<T>, "this type needs `static void fields(auto& self, auto&& field)`");
    }
  }

  void put(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }
  const std::string& bytes() const { return bytes_; }
  std::string take() { return std::move(bytes_); }
  /// The name of a field whose value cannot be written, or empty.
  const std::string& unwritable() const { return unwritable_; }

 private:
  template <class T>
  void write_parts(const T& value) {
    for_each_part(value, [&](const char* name, const auto& part) {
      if constexpr (!kIsDerived<std::remove_cvref_t<decltype(part)>>) {
        field_ = name;
        unwrap(part, [&](Role, const auto& member) { write(member); });
      }
    });
  }

  /// A shared value is written once: its number, and the value itself where the number first
  /// occurs.
  template <class T>
  void write_shared(const T& value) {
    using Held = std::remove_cv_t<typename T::element_type>;
    if constexpr (HasFields<Held>) {
      if (!value) return put_count(0);
      const auto [at, is_new] = shared_.emplace(value.get(), shared_.size() + 1);
      put_count(at->second);
      if (is_new) write(*value);
    } else {
      put_count(0);
      if (value) unwritable_ = field_;
    }
  }

  void put_byte(unsigned char byte) { put(&byte, 1); }
  void put_count(std::uint64_t count) { put(&count, sizeof count); }

  std::string bytes_, unwritable_;
  const char* field_ = "";
  std::unordered_map<const void*, std::uint64_t> shared_;
};

/// Reads fields from bytes. For arbitrary bytes it stays within them, allocates at most a small
/// multiple of their size, and rejects invalid values of enums and bools. After the first fault it
/// reads nothing more.
class FieldReader {
 public:
  explicit FieldReader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  void read(T& value) {
    if (!ok()) return;
    if constexpr (std::same_as<T, bool>) {
      read_bool(value);
    } else if constexpr (std::is_enum_v<T>) {
      std::underlying_type_t<T> number{};
      get(&number, sizeof number);
      if constexpr (HasLast<T>)
        if (std::cmp_less(number, 0) || std::cmp_greater(number, last_number<T>()))
          return fail("has an unknown type");
      value = static_cast<T>(number);
    } else if constexpr (Leaf<T>) {
      get(&value, sizeof value);
    } else if constexpr (std::same_as<T, std::string>) {
      const std::size_t size = get_count();
      value.resize(size), get(value.data(), size);
    } else if constexpr (FixedParts<T>) {
      read_parts(value);
    } else if constexpr (fields::kIsVector<T>) {
      const std::size_t size = get_count();
      value.clear();
      for (std::size_t i = 0; i < size && ok(); ++i) read(value.emplace_back());
    } else if constexpr (fields::kIsVariant<T>) {
      read_variant(value);
    } else if constexpr (fields::kIsOptional<T>) {
      bool held = false;
      read_bool(held);
      held ? read(value.emplace()) : value.reset();
    } else if constexpr (fields::kIsBox<T>) {
      bool held = false;
      read_bool(held);
      value = held ? std::make_unique<typename T::element_type>() : nullptr;
      if (held) read(*value);
    } else if constexpr (fields::kIsShared<T>) {
      read_shared(value);
    } else {
      static_assert(HasFields<T>, "this type needs `static void fields(auto& self, auto&& field)`");
    }
    if constexpr (HasRestored<T>) {
      if (ok())
        if (const char* why = value.restored()) fail(why);
    }
  }

  void get(void* to, std::size_t size) {
    if (!ok()) return;
    if (size > left()) return fail("is cut off");
    if (size > 0) std::memcpy(to, bytes_.data() + at_, size);
    at_ += size;
  }

  std::size_t left() const { return bytes_.size() - at_; }
  bool ok() const { return fault_.empty(); }
  /// "<field> <fault>", or empty.
  const std::string& fault() const { return fault_; }
  void fail(const char* why) {
    if (!ok()) return;
    fault_ = field_;
    fault_ += ' ';
    fault_ += why;
  }

 private:
  template <HasLast T>
  static constexpr auto last_number() {
    return static_cast<std::underlying_type_t<T>>(last_of(T{}));
  }

  template <class T>
  void read_parts(T& value) {
    for_each_part(value, [&](const char* name, auto&& part) {
      if constexpr (!kIsDerived<std::remove_cvref_t<decltype(part)>>) {
        field_ = name;
        if constexpr (kIsInPlace<std::remove_cvref_t<decltype(part)>>)
          read_in_place(part.value);
        else
          unwrap(part, [&](Role, auto& member) { read(member); });
      }
    });
  }

  template <class List>
  void read_in_place(List& list) {
    std::uint64_t count = 0;
    get(&count, sizeof count);
    if (count != list.size()) return fail("has a length that does not match the structure");
    for (auto& element : list) read(element);
  }

  template <class... Kinds>
  void read_variant(std::variant<Kinds...>& value) {
    unsigned char index = 0;
    get(&index, 1);
    if (index >= sizeof...(Kinds)) return fail("has an unknown type");
    unsigned char kind = 0;
    (..., (kind++ == index ? read(value.template emplace<Kinds>()) : void()));
  }

  template <class T>
  void read_shared(T& value) {
    using Held = std::remove_cv_t<typename T::element_type>;
    std::uint64_t number = 0;
    get(&number, sizeof number);
    value = nullptr;
    if (!ok() || number == 0) return;
    if constexpr (HasFields<Held>) {
      if (number <= shared_.size()) {
        const Shared& known = shared_[number - 1];
        if (known.kind != &kKind<Held>) return fail("refers to an object of another type");
        value = std::static_pointer_cast<const Held>(known.value);
        return;
      }
      if (number != shared_.size() + 1) return fail("refers to an object that does not exist");
      const auto made = std::make_shared<Held>();
      shared_.push_back({made, &kKind<Held>});
      read(*made);
      value = made;
    } else {
      fail("cannot be read");
    }
  }

  void read_bool(bool& value) {
    unsigned char byte = 0;
    get(&byte, 1);
    if (byte > 1) return fail("is not a boolean");
    value = byte != 0;
  }

  /// A count of items that take at least one byte each.
  std::size_t get_count() {
    std::uint64_t count = 0;
    get(&count, sizeof count);
    if (count > left()) fail("is cut off");
    return ok() ? static_cast<std::size_t>(count) : 0;
  }

  template <class T>
  static constexpr char kKind = 0;
  struct Shared {
    std::shared_ptr<const void> value;
    const char* kind = nullptr;
  };

  std::string_view bytes_;
  std::size_t at_ = 0;
  std::string fault_;
  const char* field_ = "";
  std::vector<Shared> shared_;
};

/// Whether the saved state of two values is equal, bit for bit.
template <class T>
bool same_fields(const T& one, const T& other) {
  FieldWriter a, b;
  a.write(one), b.write(other);
  return a.bytes() == b.bytes();
}

}  // namespace pantin::detail
