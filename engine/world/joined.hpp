#pragma once
/// Which bodies are joined, or ignore each other: their shapes do not touch one another, and
/// sensors do not see them.
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace pantin {

struct World;

namespace detail {

/// Two slots of World::bodies as one number, whatever their order.
constexpr std::uint64_t body_pair(std::uint32_t a, std::uint32_t b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
}

/// The pairs that are joined, sorted:
///
///   - bodies of a link, whatever its kind, and of an exact pin;
///   - partners in a joint of surfaces or curves, until it has let go: these touch by it;
///   - wheels of a gear: a body that moves in one of its joints, and one that does in the other.
///
/// Cables, belts and spring pins pull from afar: what they tie may touch.
void list_joined(const World& world, std::vector<std::uint64_t>& pairs);
/// The pairs that ignore each other for a time, sorted.
void list_ignored(const World& world, std::vector<std::uint64_t>& pairs);
/// Changes whenever the list of those that are joined may.
std::uint64_t joined_version(const World& world);

inline bool are_joined(std::span<const std::uint64_t> pairs, std::uint32_t a, std::uint32_t b) {
  return std::binary_search(pairs.begin(), pairs.end(), body_pair(a, b));
}

}  // namespace detail
}  // namespace pantin
