#pragma once
/// Which bodies are joined, or ignore each other: their shapes do not collide, and sensors do not
/// see them.
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace pantin {

struct World;

namespace detail {

/// An unordered pair of slots of World::bodies as one number.
constexpr std::uint64_t body_pair(std::uint32_t a, std::uint32_t b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
}

/// Lists the joined pairs, sorted:
///
///   - bodies of a link, whatever its kind, and of an exact pin;
///   - bodies of a joint of surfaces or curves until it releases: the joint is their contact;
///   - wheels of a gear: a body of one of its joints, and one of the other.
///
/// Cables, belts and spring pins act at a distance: bodies that they connect may touch.
void list_joined(const World& world, std::vector<std::uint64_t>& pairs);
/// Lists the pairs that ignore each other for a time, sorted.
void list_ignored(const World& world, std::vector<std::uint64_t>& pairs);
/// Changes whenever the list of joined pairs may have changed.
std::uint64_t joined_version(const World& world);

inline bool are_joined(std::span<const std::uint64_t> pairs, std::uint32_t a, std::uint32_t b) {
  return std::binary_search(pairs.begin(), pairs.end(), body_pair(a, b));
}

}  // namespace detail
}  // namespace pantin
