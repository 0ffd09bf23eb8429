#pragma once
/// Joints that close loops. Solvers that grow trees of bodies hold of such a joint a point alone;
/// trees are grown so that as little as possible is lost by that.
#include <cstdint>
#include <vector>

#include "engine/world/world.hpp"

namespace pantin::detail {

/// How much a joint has besides its point: 0 of a free ball joint, more of a hinge, of other kinds,
/// and most where a drive, a spring, friction or a motor acts, or limits bound it.
int more_than_a_point(const World& world, std::uint32_t link);

/// Slots of World::links, those with more first: the order in which trees take joints up.
std::vector<std::uint32_t> growing_order(const World& world);

/// Joints of dynamic bodies that close a loop, or hold a tree a second time, and would lose more
/// than a free ball joint has. A loop of parallel hinges, and one of fixed joints, loses nothing.
std::vector<std::uint32_t> list_closing(const World& world);

}  // namespace pantin::detail
