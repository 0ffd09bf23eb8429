#include "engine/base/check.hpp"
#include "engine/scene/json_recipe.hpp"

namespace pantin::detail {

void JsonPlaces::add(std::uint32_t group, ElementKind kind, NodeId node) {
  if (group >= groups_.size()) groups_.resize(group + 1);
  groups_[group][static_cast<std::size_t>(kind)].push_back(node);
}

NodeId JsonPlaces::node(const ElementId& at) const {
  PANTIN_ASSERT(at.group < groups_.size());
  const std::vector<NodeId>& nodes = groups_[at.group][static_cast<std::size_t>(at.kind)];
  PANTIN_ASSERT(at.index < nodes.size());
  return nodes[at.index];
}

void JsonPlaces::error(const ElementId& at, std::string_view member, std::string message) {
  NodeId place = node(at);
  while (!member.empty()) {
    const std::size_t end = std::min(member.find('/'), member.size());
    const NodeId part = json_.member(place, member.substr(0, end));
    if (part == kNoNode) break;  // a default: the nearest thing around it
    place = part;
    member.remove_prefix(std::min(end + 1, member.size()));
  }
  complaints_.error(place, std::move(message));
}

void JsonPlaces::warn(const ElementId& at, std::string_view kind, std::string message) {
  complaints_.warn(node(at), kind, std::move(message));
}

}  // namespace pantin::detail
