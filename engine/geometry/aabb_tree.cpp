#include "engine/geometry/aabb_tree.hpp"

#include <algorithm>

#include "engine/base/invariants.hpp"

namespace pantin::detail {
namespace {

Real half_area(const Aabb& b) {
  const Vec3 d = b.high - b.low;
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

}  // namespace

void AabbTree::build(std::span<const Aabb> boxes) {
  const auto count = static_cast<std::uint32_t>(boxes.size());
  items_.resize(count), boxes_.resize(count);
  nodes_.clear();
  for (std::uint32_t i = 0; i < count; ++i) items_[i] = i;
  if (count == 0) return;
  nodes_.reserve(2 * count);
  nodes_.emplace_back();
  split(0, 0, count, boxes);
  refit(boxes);
  sorted_area_ = area_;
}

void AabbTree::split(std::uint32_t node, std::uint32_t first, std::uint32_t count,
                     std::span<const Aabb> boxes) {
  if (count <= kLeaf) {
    nodes_[node].first = first, nodes_[node].count = count;
    return;
  }
  Aabb middles;
  for (std::uint32_t i = first; i < first + count; ++i)
    middles.add(boxes[items_[i]].low + boxes[items_[i]].high);
  const Vec3 wide = middles.high - middles.low;
  const int axis = wide.x >= wide.y && wide.x >= wide.z ? 0 : wide.y >= wide.z ? 1 : 2;
  const auto begin = items_.begin() + first;
  // Ties are broken by index, so that the tree does not depend on the library's selection
  // algorithm.
  std::nth_element(begin, begin + count / 2, begin + count, [&](std::uint32_t a, std::uint32_t b) {
    const Real ma = boxes[a].low[axis] + boxes[a].high[axis];
    const Real mb = boxes[b].low[axis] + boxes[b].high[axis];
    return ma < mb || (ma == mb && a < b);
  });
  const auto child = static_cast<std::uint32_t>(nodes_.size());
  nodes_[node].first = child, nodes_[node].count = 0;
  nodes_.emplace_back(), nodes_.emplace_back();
  split(child, first, count / 2, boxes);
  split(child + 1, first + count / 2, count - count / 2, boxes);
}

std::span<const std::uint32_t> AabbTree::items_below(std::uint32_t node) const {
  std::uint32_t low = node, high = node;
  while (nodes_[low].count == 0) low = nodes_[low].first;
  while (nodes_[high].count == 0) high = nodes_[high].first + 1;
  const std::uint32_t first = nodes_[low].first;
  return {items_.data() + first, nodes_[high].first + nodes_[high].count - first};
}

void AabbTree::refit(std::span<const Aabb> boxes) {
  PANTIN_ASSERT(boxes.size() == items_.size());
  for ([[maybe_unused]] const Aabb& box : boxes) PANTIN_ASSERT(is_range(box.low, box.high));
  for (std::size_t i = 0; i < items_.size(); ++i) boxes_[i] = boxes[items_[i]];
  fit();
}

void AabbTree::fit() {
  area_ = 0;
  for (std::size_t n = nodes_.size(); n-- > 0;) {  // children come after their parent
    Node& node = nodes_[n];
    node.box = Aabb{};
    if (node.count > 0)
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) node.box.add(boxes_[i]);
    else
      node.box.add(nodes_[node.first].box), node.box.add(nodes_[node.first + 1].box);
    area_ += half_area(node.box);
  }
}

}  // namespace pantin::detail
