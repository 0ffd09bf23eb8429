#include "engine/scene/read/named.hpp"

namespace pantin::detail {

std::optional<std::string_view> read_new_name(const Reading& reading, NodeId node,
                                              ByName<NodeId>& known) {
  if (reading.json[node].kind != JsonKind::object) return std::nullopt;
  const NodeId name = reading.json.member(node, "name");
  if (name == kNoNode) {
    reading.diagnostics.error(node, "found no \"name\", expected a name");
    return std::nullopt;
  }
  if (reading.json[name].kind != JsonKind::string) return std::nullopt;  // reported already
  const std::string_view text = reading.json[name].text;
  const auto [first, is_new] = known.try_emplace(text, node);
  if (is_new) return text;
  reading.diagnostics.error(name, "found the name \"" + std::string(text) +
                                      "\" again, expected one that " +
                                      reading.json.pointer(first->second) + " does not have");
  return std::nullopt;
}

}  // namespace pantin::detail
