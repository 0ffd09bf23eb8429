#pragma once
/// For programs that simply end on an error.
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "engine/base/result.hpp"

namespace pantin {

/// The value of a Result. On failure, prints all its errors to stderr, a line each, and ends the
/// program with the exit status 2.
///
///   const Entity door = must(world.add(RigidBody{.shape = BoxShape{{0.4, 1, 0.02}}}));
template <class T>
T must(Result<T> result) {
  if (result) return std::move(*result);
  for (const Error& e : result.errors()) std::fprintf(stderr, "%s\n", e.message.c_str());
  std::exit(2);
}

}  // namespace pantin
