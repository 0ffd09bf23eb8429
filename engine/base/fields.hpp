#pragma once
/// One list of members per struct, from which hash, copy, comparison, save and load follow.
///
///   struct Pin {
///     Entity body;
///     Real stiffness = 200;
///     Real residual = 0;
///     static void fields(auto& self, auto&& field) {
///       field("body", self.body);
///       field("stiffness", self.stiffness);
///       field("residual", passive(self.residual));
///     }
///   };
///
/// A plain field is state: the next step depends on it. So is `in_place`, a list whose length
/// follows from the structure. `passive` fields are copied and saved, but no step reads them:
/// results, names, appearance. `derived` fields follow from the rest (caches, scratch): they are
/// rebuilt, never saved. The name "" is reserved.
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "engine/base/hash.hpp"
#include "engine/base/math.hpp"

namespace pantin::detail {

/// Copied and saved, but not read by any step.
template <class T>
struct PassiveField {
  T& value;
};
/// Rebuilt from the rest.
template <class T>
struct DerivedField {
  T& value;
};
/// State in a list whose length is known: read into the existing elements.
template <class T>
struct InPlaceField {
  T& value;
};

}  // namespace pantin::detail

namespace pantin {

/// Marks a field of your struct: copied and saved, but not read by any step.
template <class T>
detail::PassiveField<T> passive(T& member) {
  return {member};
}
/// Marks a field of your struct: rebuilt from the rest, never saved.
template <class T>
detail::DerivedField<T> derived(T& member) {
  return {member};
}

}  // namespace pantin

namespace pantin::detail {

template <class T>
InPlaceField<T> in_place(T& member) {
  return {member};
}

template <class T>
inline constexpr bool kIsMarked = false;
template <class T>
inline constexpr bool kIsMarked<PassiveField<T>> = true;
template <class T>
inline constexpr bool kIsMarked<DerivedField<T>> = true;
template <class T>
inline constexpr bool kIsInPlace = false;
template <class T>
inline constexpr bool kIsInPlace<InPlaceField<T>> = true;
template <class T>
inline constexpr bool kIsDerived = false;
template <class T>
inline constexpr bool kIsDerived<DerivedField<T>> = true;
template <class T>
inline constexpr bool kIsPassive = false;
template <class T>
inline constexpr bool kIsPassive<PassiveField<T>> = true;

/// The role of a field.
enum class Role : std::uint8_t { state, passive, derived };

/// Unwraps the mark of a field: calls `to(role, member)`.
template <class T, class To>
requires(!kIsMarked<T> && !kIsInPlace<T>) void unwrap(T& member, To&& to) {
  to(Role::state, member);
}
template <class T, class To>
void unwrap(const InPlaceField<T>& field, To&& to) {
  to(Role::state, field.value);
}
template <class T, class To>
void unwrap(const PassiveField<T>& field, To&& to) {
  to(Role::passive, field.value);
}
template <class T, class To>
void unwrap(const DerivedField<T>& field, To&& to) {
  to(Role::derived, field.value);
}

/// A struct that lists its members.
template <class T>
concept HasFields = requires(const std::remove_cv_t<T>& value) {
  std::remove_cv_t<T>::fields(value, [](const char*, const auto&) {});
};

/// Numbers, bools and enums: the leaves of all fields.
template <class T>
concept Leaf = std::is_arithmetic_v<T> || std::is_enum_v<T>;

namespace fields {

template <class T>
inline constexpr bool kIsVector = false;
template <class T>
inline constexpr bool kIsVector<std::vector<T>> = true;
template <class T>
inline constexpr bool kIsOptional = false;
template <class T>
inline constexpr bool kIsOptional<std::optional<T>> = true;
template <class T>
inline constexpr bool kIsVariant = false;
template <class... T>
inline constexpr bool kIsVariant<std::variant<T...>> = true;
template <class T>
inline constexpr bool kIsBox = false;
template <class T>
inline constexpr bool kIsBox<std::unique_ptr<T>> = true;
template <class T>
inline constexpr bool kIsShared = false;
template <class T>
inline constexpr bool kIsShared<std::shared_ptr<T>> = true;
template <class T>
inline constexpr bool kIsArray = std::is_array_v<T>;
template <class T, std::size_t N>
inline constexpr bool kIsArray<std::array<T, N>> = true;

template <class T>
inline constexpr bool kIsSpace = std::same_as<T, Vec3> || std::same_as<T, Quat> ||
                                 std::same_as<T, Mat3> || std::same_as<T, Pose>;

}  // namespace fields

/// An enum that names its last value by a function `last_of(E)`; larger values in files are
/// rejected.
template <class T>
concept HasLast = std::is_enum_v<T> && requires(T value) {
  last_of(value);
};

/// Types with fixed parts: calls `part(name, member)` for each, with its mark.
template <class T>
concept FixedParts =
    HasFields<T> || fields::kIsSpace<std::remove_cv_t<T>> || fields::kIsArray<std::remove_cv_t<T>>;

template <FixedParts T, class Part>
void for_each_part(T& value, Part&& part) {
  using Plain = std::remove_cv_t<T>;
  if constexpr (HasFields<T>) {
    Plain::fields(value, part);
  } else if constexpr (std::same_as<Plain, Vec3>) {
    part("x", value.x), part("y", value.y), part("z", value.z);
  } else if constexpr (std::same_as<Plain, Quat>) {
    part("x", value.x), part("y", value.y), part("z", value.z), part("w", value.w);
  } else if constexpr (std::same_as<Plain, Mat3>) {
    part("0", value[0]), part("1", value[1]), part("2", value[2]);
  } else if constexpr (std::same_as<Plain, Pose>) {
    part("position", value.position), part("rotation", value.rotation);
  } else {
    for (auto& element : value) part("[]", element);
  }
}

/// No special rule for any type; see hash_fields.
struct NoRule {};

/// Adds the state of `value` to `hash`, without passive and derived fields. `rule(hash, part)`
/// takes precedence for the types that it accepts.
template <class T, class Rule = NoRule>
void hash_fields(Hash& hash, const T& value, const Rule& rule = {}) {
  if constexpr (requires { rule(hash, value); }) {
    rule(hash, value);
  } else if constexpr (std::is_enum_v<T>) {
    hash.add(static_cast<std::uint64_t>(value));
  } else if constexpr (std::is_floating_point_v<T>) {
    hash.add(static_cast<Real>(value));
  } else if constexpr (std::is_integral_v<T>) {
    hash.add(static_cast<std::uint64_t>(value));
  } else if constexpr (std::same_as<T, std::string>) {
    hash.add(std::string_view(value));
  } else if constexpr (FixedParts<const T>) {
    for_each_part(value, [&](const char*, const auto& part) {
      if constexpr (!kIsMarked<std::remove_cvref_t<decltype(part)>>)
        unwrap(part, [&](Role, const auto& member) { hash_fields(hash, member, rule); });
    });
  } else if constexpr (fields::kIsVector<T>) {
    hash.add(static_cast<std::uint64_t>(value.size()));
    for (const auto& element : value) hash_fields(hash, element, rule);
  } else if constexpr (fields::kIsVariant<T>) {
    hash.add(static_cast<std::uint64_t>(value.index()));
    std::visit([&](const auto& held) { hash_fields(hash, held, rule); }, value);
  } else if constexpr (fields::kIsOptional<T> || fields::kIsBox<T>) {
    hash.add(static_cast<bool>(value));
    if (value) hash_fields(hash, *value, rule);
  } else if constexpr (fields::kIsShared<T>) {
    hash.add(static_cast<bool>(value));
    if constexpr (requires { value->fingerprint(); }) {
      if (value) hash.add(static_cast<std::uint64_t>(value->fingerprint()));
    } else {
      if (value) hash_fields(hash, *value, rule);
    }
  } else {
    static_assert(HasFields<T>, "this type needs `static void fields(auto& self, auto&& field)`");
  }
}

/// The same member of another object of the same type.
template <class T, class Member>
Member& same_member(const T& one, const Member& member, T& other) {
  const auto offset = reinterpret_cast<const char*>(&member) - reinterpret_cast<const char*>(&one);
  return *reinterpret_cast<Member*>(reinterpret_cast<char*>(&other) + offset);
}

/// Copies only the state from `from` to `to`. Passive and derived fields of `to` are kept, also in
/// elements of vectors of equal length.
template <class T>
void copy_state(const T& from, T& to) {
  if constexpr (HasFields<T>) {
    T::fields(from, [&](const char*, const auto& part) {
      using Part = std::remove_cvref_t<decltype(part)>;
      if constexpr (!kIsMarked<Part>)
        unwrap(part, [&](Role, const auto& member) {
          copy_state(member, same_member(from, member, to));
        });
    });
  } else if constexpr (fields::kIsVector<T>) {
    to.resize(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) copy_state(from[i], to[i]);
  } else if constexpr (std::is_array_v<T>) {
    for (std::size_t i = 0; i < std::extent_v<T>; ++i) copy_state(from[i], to[i]);
  } else if constexpr (fields::kIsBox<T>) {
    to = from ? std::make_unique<typename T::element_type>(*from) : nullptr;
  } else {
    to = from;
  }
}

/// A fingerprint of the names and types of all saved fields, at any depth; a file of `T` must match
/// it.
template <class T>
void describe(Hash& hash) {
  using Plain = std::remove_cv_t<T>;
  if constexpr (std::is_enum_v<Plain>) {
    hash.add(std::string_view("enum")), hash.add(static_cast<std::uint64_t>(sizeof(Plain)));
    if constexpr (HasLast<Plain>) hash.add(static_cast<std::uint64_t>(last_of(Plain{})));
  } else if constexpr (std::is_arithmetic_v<Plain>) {
    hash.add(std::string_view(std::is_floating_point_v<Plain> ? "real" : "whole"));
    hash.add(static_cast<std::uint64_t>(sizeof(Plain)));
  } else if constexpr (fields::kIsArray<Plain>) {
    hash.add(static_cast<std::uint64_t>(sizeof(Plain)));
    describe<std::remove_cvref_t<decltype(std::declval<Plain&>()[0])>>(hash);
  } else if constexpr (fields::kIsSpace<Plain> || std::same_as<Plain, std::string>) {
    hash.add(std::string_view("built in")), hash.add(static_cast<std::uint64_t>(sizeof(Plain)));
  } else if constexpr (HasFields<Plain>) {
    const Plain sample{};
    Plain::fields(sample, [&](const char* name, const auto& part) {
      unwrap(part, [&](Role role, const auto& member) {
        if (role == Role::derived) return;
        hash.add(std::string_view(name));
        if constexpr (!kIsDerived<std::remove_cvref_t<decltype(part)>>)
          describe<std::remove_cvref_t<decltype(member)>>(hash);
      });
    });
    hash.add(std::string_view("end"));
  } else if constexpr (fields::kIsVariant<Plain>) {
    [&]<class... Kinds>(const std::variant<Kinds...>*) {
      (describe<Kinds>(hash), ...);
    }(static_cast<const Plain*>(nullptr));
    hash.add(std::string_view("end"));
  } else if constexpr (fields::kIsVector<Plain> || fields::kIsOptional<Plain>) {
    hash.add(std::string_view("some")), describe<typename Plain::value_type>(hash);
  } else if constexpr (fields::kIsBox<Plain> || fields::kIsShared<Plain>) {
    using Held = std::remove_cv_t<typename Plain::element_type>;
    hash.add(std::string_view("box"));
    if constexpr (HasFields<Held>) describe<Held>(hash);
  }
}

template <class T>
std::uint64_t fields_fingerprint() {
  Hash hash;
  describe<T>(hash);
  return hash.value();
}

}  // namespace pantin::detail
