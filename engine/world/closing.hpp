#pragma once
/// Joints that close loops. Tree solvers enforce only the shared point of such a joint; the
/// spanning tree is chosen so that as few constraints as possible are lost.
#include <cstdint>
#include <span>
#include <vector>

#include "engine/world/world.hpp"

namespace pantin::detail {

/// Rank of what a joint has besides its shared point: 0 for a free ball joint, more for a hinge,
/// more for other kinds, and most for one with a drive, a spring, friction, a motor or limits.
int more_than_a_point(const World& world, std::uint32_t link);

/// Slots of World::links by descending rank: the order in which joints are added to the trees.
std::vector<std::uint32_t> growing_order(const World& world, std::span<const std::uint32_t> links);

/// Those of the given joints, of whole islands, that close a loop of dynamic bodies, or anchor a
/// tree a second time, and would lose more than their point. A loop of parallel hinges, and one of
/// fixed joints, loses nothing.
std::vector<std::uint32_t> list_closing(const World& world, std::span<const std::uint32_t> links);

}  // namespace pantin::detail
