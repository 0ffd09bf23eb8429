#pragma once
/// The part of a World that is compiled: all of it, or the islands that a change concerns.
#include <cstdint>
#include <vector>

#include "engine/world/entity.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail {

/// Slots in the stores of a World, each list ascending. With a body, what ties it or collides for
/// it is in the scope, and all dynamic bodies that it is tied to.
struct Scope {
  std::vector<std::uint32_t> bodies, links, cables, pins, collisions;

  static Scope all(const World& world);
};

}  // namespace pantin::detail
