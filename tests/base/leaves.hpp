#pragma once
/// Every number, word and handle that fields come down to, one by one, and how to change each.
#include <cmath>
#include <limits>
#include <string>

#include "engine/base/fields.hpp"
#include "engine/world/entity.hpp"

namespace pantin::test {

using namespace detail;

/// Calls `leaf(path, role, value)`; what lies in a passive field is passive. Derived fields are
/// passed over, and what is shared.
template <class T, class F>
void each_leaf(T& value, Role role, const std::string& path, F&& leaf) {
  if constexpr (Leaf<T> || std::same_as<T, std::string> || std::same_as<T, Entity>) {
    leaf(path, role, value);
  } else if constexpr (FixedParts<T>) {
    for_each_part(value, [&](const char* name, auto&& part) {
      unwrap(part, [&](Role own, auto& member) {
        if constexpr (!kIsDerived<std::remove_cvref_t<decltype(part)>>)
          each_leaf(member, own == Role::state ? role : own, path + '.' + name, leaf);
      });
    });
  } else if constexpr (fields::kIsVector<T>) {
    for (std::size_t i = 0; i < value.size(); ++i)
      each_leaf(value[i], role, path + '[' + std::to_string(i) + ']', leaf);
  } else if constexpr (fields::kIsVariant<T>) {
    std::visit([&](auto& held) { each_leaf(held, role, path, leaf); }, value);
  } else if constexpr (fields::kIsBox<T> || fields::kIsOptional<T>) {
    if (value) each_leaf(*value, role, path, leaf);
  }
}

/// The least change: one step of a number, another word, another kind.
inline void change(Real& x) {
  x = std::nextafter(x, x < 1e300 ? std::numeric_limits<Real>::infinity() : 0.0);
}
inline void change(bool& x) { x = !x; }
inline void change(std::string& x) { x += 'x'; }
inline void change(Entity& e) { ++e.index; }
template <class T>
requires(std::is_integral_v<T> && !std::same_as<T, bool>) void change(T& x) { ++x; }
template <class T>
requires std::is_enum_v<T>
void change(T& x) {
  const int last = static_cast<int>(last_of(x)), now = static_cast<int>(x);
  x = static_cast<T>(now < last ? now + 1 : 0);
}

}  // namespace pantin::test
