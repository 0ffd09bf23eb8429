#pragma once
/// Axis-aligned bounding boxes, and a bounding volume hierarchy for overlap and nearest queries.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/math.hpp"

namespace pantin::detail {

/// An axis-aligned bounding box, m. Empty by default.
struct Aabb {
  Vec3 low{1e300}, high{-1e300};

  void add(Vec3 p) { low = glm::min(low, p), high = glm::max(high, p); }
  void add(const Aabb& other) { low = glm::min(low, other.low), high = glm::max(high, other.high); }
  Aabb grown(Real by) const { return {low - by, high + by}; }
  /// Boxes that share a face overlap.
  bool overlaps(const Aabb& o) const {
    return low.x <= o.high.x && o.low.x <= high.x && low.y <= o.high.y && o.low.y <= high.y &&
           low.z <= o.high.z && o.low.z <= high.z;
  }
  friend bool operator==(const Aabb&, const Aabb&) = default;
};

/// Squared distance from a point to a box, m^2; 0 inside.
inline Real distance_squared(const Aabb& box, Vec3 p) {
  const Vec3 out = glm::max(glm::max(box.low - p, p - box.high), Vec3(0));
  return glm::dot(out, out);
}

/// The distances between which a ray is inside a box, in units of `way`; it misses where the first
/// is above the second.
inline std::array<Real, 2> ray_range(const Aabb& box, Vec3 from, Vec3 way) {
  Real enter = -1e300, leave = 1e300;
  for (int i = 0; i < 3; ++i) {
    if (way[i] == 0) {
      if (from[i] < box.low[i] || from[i] > box.high[i]) return {1, 0};
      continue;
    }
    const Real one = (box.low[i] - from[i]) / way[i], two = (box.high[i] - from[i]) / way[i];
    enter = std::max(enter, std::min(one, two)), leave = std::min(leave, std::max(one, two));
  }
  return {enter, leave};
}

/// A binary bounding volume hierarchy; boxes are identified by index.
///
/// Memory is reused: rebuilding or refitting with no more boxes than before does not allocate. The
/// result of a query does not depend on how the tree was built; the order of the results does.
class AabbTree {
 public:
  /// Builds a new tree; O(n log n).
  void build(std::span<const Aabb> boxes);
  /// Updates the boxes, as many as before; O(n). The topology is kept, so the tree degrades as
  /// boxes move: see `looseness`.
  void refit(std::span<const Aabb> boxes);
  /// Growth of the total branch area since the tree was built; 1 for none.
  Real looseness() const { return sorted_area_ > 0 ? area_ / sorted_area_ : 1; }
  std::size_t size() const { return items_.size(); }
  std::size_t node_count() const { return nodes_.size(); }
  const Aabb& box_of(std::uint32_t node) const { return nodes_[node].box; }
  /// The indices of the boxes below a node.
  std::span<const std::uint32_t> items_below(std::uint32_t node) const;

  /// Calls `found(index)` for every box that overlaps `box`.
  template <class Found>
  void query(const Aabb& box, Found&& found) const {
    if (nodes_.empty()) return;
    std::uint32_t stack[kDeepest], depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const Node& node = nodes_[stack[--depth]];
      if (!node.box.overlaps(box)) continue;
      if (node.count > 0) {
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
          if (boxes_[i].overlaps(box)) found(items_[i]);
        continue;
      }
      stack[depth++] = node.first + 1;
      stack[depth++] = node.first;
    }
  }

  /// Nearest query: `distance(index)` returns the squared distance of the content of a box; only
  /// boxes nearer than the best so far are visited. Returns the least, at most `best`.
  template <class Distance>
  Real nearest(Vec3 p, Real best, Distance&& distance) const {
    return nearest(p, best, distance, [](std::uint32_t) { return true; });
  }
  /// The same among the nodes for which `may(node)` holds: see `items_below`.
  template <class Distance, class May>
  Real nearest(Vec3 p, Real best, Distance&& distance, May&& may) const {
    if (nodes_.empty()) return best;
    std::uint32_t stack[kDeepest], depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const std::uint32_t at = stack[--depth];
      const Node& node = nodes_[at];
      if (distance_squared(node.box, p) > best || !may(at)) continue;
      if (node.count > 0) {
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
          if (distance_squared(boxes_[i], p) <= best) best = std::min(best, distance(items_[i]));
        continue;
      }
      const bool swap = distance_squared(nodes_[node.first].box, p) >
                        distance_squared(nodes_[node.first + 1].box, p);
      stack[depth++] = node.first + (swap ? 0 : 1);
      stack[depth++] = node.first + (swap ? 1 : 0);
    }
    return best;
  }

  /// Visits the boxes that a ray enters before `limit`, in units of `way`: `entry(index, limit)`
  /// returns the limit from then on.
  template <class Entry>
  void cast(Vec3 from, Vec3 way, Real limit, Entry&& entry) const {
    if (nodes_.empty()) return;
    const auto meets = [&](const Aabb& box) {
      const auto [enter, leave] = ray_range(box, from, way);
      return enter <= leave && leave >= 0 && enter <= limit;
    };
    std::uint32_t stack[kDeepest], depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const Node& node = nodes_[stack[--depth]];
      if (!meets(node.box)) continue;
      if (node.count > 0) {
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
          if (meets(boxes_[i])) limit = entry(items_[i], limit);
        continue;
      }
      const Aabb &one = nodes_[node.first].box, &two = nodes_[node.first + 1].box;
      const bool swap = ray_range(one, from, way)[0] > ray_range(two, from, way)[0];
      stack[depth++] = node.first + (swap ? 0 : 1);
      stack[depth++] = node.first + (swap ? 1 : 0);
    }
  }

 private:
  // Halving keeps the tree at most 32 deep; each level leaves one node behind on the stack.
  static constexpr std::uint32_t kDeepest = 64;
  static constexpr std::uint32_t kLeaf = 4;  // boxes in a leaf, at most

  struct Node {
    Aabb box;
    std::uint32_t first = 0;  // leaf: of its boxes; branch: of its two nodes, side by side
    std::uint32_t count = 0;  // leaf: of its boxes; branch: 0
  };

  void split(std::uint32_t node, std::uint32_t first, std::uint32_t count,
             std::span<const Aabb> boxes);
  void fit();

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> items_;  // indices of the boxes, leaf by leaf
  std::vector<Aabb> boxes_;           // in that order
  Real area_ = 0, sorted_area_ = 0;   // of all branches, m^2
};

}  // namespace pantin::detail
