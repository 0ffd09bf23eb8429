#include "engine/base/check.hpp"
#include "engine/scene/read/json_recipe.hpp"

namespace pantin::detail {

void JsonPlaces::open_group(std::uint32_t group, SceneFile& file) {
  if (group >= groups_.size()) groups_.resize(group + 1);
  groups_[group].file = &file;
}

void JsonPlaces::add(std::uint32_t group, ElementKind kind, NodeId node) {
  PANTIN_ASSERT(group < groups_.size() && groups_[group].file);
  groups_[group].nodes[static_cast<std::size_t>(kind)].push_back(node);
}

NodeId JsonPlaces::node(const ElementId& at) const {
  PANTIN_ASSERT(at.group < groups_.size());
  const std::vector<NodeId>& nodes = groups_[at.group].nodes[static_cast<std::size_t>(at.kind)];
  PANTIN_ASSERT(at.index < nodes.size());
  return nodes[at.index];
}

void JsonPlaces::error(const ElementId& at, std::string_view member, std::string message) {
  NodeId place = node(at);
  SceneFile& file = *groups_[at.group].file;
  while (!member.empty()) {
    const std::size_t end = std::min(member.find('/'), member.size());
    const NodeId part = file.json.member(place, member.substr(0, end));
    if (part == kNoNode) break;  // a default: use the nearest enclosing value
    place = part;
    member.remove_prefix(std::min(end + 1, member.size()));
  }
  file.diagnostics.error(place, std::move(message));
}

void JsonPlaces::warn(const ElementId& at, std::string_view kind, std::string message) {
  groups_[at.group].file->diagnostics.warn(node(at), kind, std::move(message));
}

}  // namespace pantin::detail
