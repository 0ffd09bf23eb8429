#pragma once
/// How many members an aggregate has, counted by the compiler: a list of fields is held against it.
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include "engine/base/fields.hpp"

namespace pantin::test {

using namespace detail;

struct Anything {
  template <class T>
  operator T() const {
    std::abort();  // never called: only asked about
  }
};

template <class T, std::size_t... I>
constexpr bool takes(std::index_sequence<I...>) {
  return requires { T{(static_cast<void>(I), Anything{})...}; };
}
/// Initialisers that T takes, each element of an array apart.
template <class T, std::size_t N = 1>
constexpr std::size_t initialisers() {
  if constexpr (takes<T>(std::make_index_sequence<N>()))
    return initialisers<T, N + 1>();
  else
    return N - 1;
}

template <class T, std::size_t... I, std::size_t... J>
constexpr bool takes_braced(std::index_sequence<I...>, std::index_sequence<J...>) {
  return requires {
    T{(static_cast<void>(I), Anything{})..., {}, (static_cast<void>(J), Anything{})...};
  };
}
/// Initialisers that the member after `First` others leaves to those behind it.
template <class T, std::size_t First, std::size_t Left>
constexpr std::size_t left_behind() {
  if constexpr (Left == 0 || takes_braced<T>(std::make_index_sequence<First>(),
                                             std::make_index_sequence<Left>()))
    return Left;
  else
    return left_behind<T, First, Left - 1>();
}

template <class T, std::size_t Total = initialisers<T>(), std::size_t First = 0>
constexpr std::size_t arity() {
  if constexpr (First >= Total)
    return 0;
  else
    return 1 + arity<T, Total, Total - left_behind<T, First, Total - First - 1>()>();
}

/// Members that the list names, whatever their role.
template <class T>
std::size_t listed() {
  std::size_t count = 0;
  const T sample{};
  T::fields(sample, [&](const char*, const auto&) { ++count; });
  return count;
}

/// Fails where the list of fields of T leaves a member out.
template <class T>
void check_list(const char* name) {
  INFO(name);
  CHECK(listed<T>() == arity<T>());
}

}  // namespace pantin::test
