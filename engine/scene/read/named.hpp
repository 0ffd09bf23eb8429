#pragma once
/// Lists of named objects: curves, surfaces.
#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "engine/scene/read/read.hpp"

namespace pantin::detail {

/// Objects by name in the text.
template <class T>
using ByName = std::unordered_map<std::string_view, T>;

/// The name of an object of such a list; nothing if it has none, or after an error. `known` records
/// which objects already have a name.
std::optional<std::string_view> read_new_name(const Reading& reading, NodeId node,
                                              ByName<NodeId>& known);

/// Reads the objects of a list. If a name is repeated, the first object counts.
template <class T>
void read_named(const Reading& reading, const std::vector<NodeId>& nodes, ByName<T>& into,
                T (*read_one)(const Reading&, NodeId)) {
  ByName<NodeId> known;
  for (const NodeId node : nodes) {
    T made = read_one(reading, node);
    if (const auto name = read_new_name(reading, node, known))
      into.try_emplace(*name, std::move(made));
  }
}

/// Reports a value that is not one of the names in `known`, and suggests the nearest.
template <class T>
void refuse_unknown(const Reading& reading, NodeId value, const ByName<T>& known,
                    const std::string& expected) {
  Hints& hints = reading.diagnostics.hints;
  std::vector<std::string_view> names;
  for (auto it = known.begin(); it != known.end() && hints.any_left(); ++it)
    names.push_back(it->first);
  std::ranges::sort(names);
  const JsonNode& found = reading.json[value];
  const std::string_view word = found.kind == JsonKind::string ? found.text : "";
  reading.diagnostics.error_value(value, expected + hints.of(word, names));
}

}  // namespace pantin::detail
