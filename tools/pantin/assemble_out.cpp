#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/scene/json/json.hpp"
#include "engine/scene/read/units.hpp"
#include "tools/pantin/assemble.hpp"

namespace pantin::program {
namespace {

/// The end of a comment that begins at `at`, or `at` if there is none.
std::size_t end_of_comment(std::string_view text, std::size_t at) {
  if (text.substr(at, 2) == "//") return std::min(text.find('\n', at), text.size());
  if (text.substr(at, 2) == "/*") return std::min(text.find("*/", at + 2), text.size() - 2) + 2;
  return at;
}

/// The end of a string in quotes that begins at `at`.
std::size_t end_of_string(std::string_view text, std::size_t at) {
  const char quote = text[at++];
  for (; at < text.size() && text[at] != quote; ++at)
    if (text[at] == '\\') ++at;
  return at + 1;
}

/// The end of an array or object that begins at `at`, in a text that is JSON or JSON5.
std::size_t end_of_value(std::string_view text, std::size_t at) {
  int depth = 0;
  while (at < text.size()) {
    const char c = text[at];
    if (const std::size_t end = end_of_comment(text, at); end != at) {
      at = end;
    } else if (c == '"' || c == '\'') {
      at = end_of_string(text, at);
    } else {
      depth += (c == '[' || c == '{') - (c == ']' || c == '}');
      ++at;
      if (depth == 0) break;
    }
  }
  return at;
}

/// Names of the bodies in the "poses" of a scene.
std::vector<std::string> listed_bodies(const JsonDocument& json, NodeId poses) {
  std::vector<std::string> names;
  if (poses == kNoNode) return names;
  for (NodeId item = json[poses].first_child; item != kNoNode; item = json[item].next)
    if (const NodeId body = json.member(item, "body"); body != kNoNode)
      names.emplace_back(json[body].text);
  return names;
}

}  // namespace

std::size_t end_of_member(const JsonDocument& json, NodeId value) {
  const JsonNode& node = json[value];
  if (node.kind == JsonKind::array || node.kind == JsonKind::object)
    return end_of_value(json.text, node.offset);
  if (node.kind == JsonKind::string) return end_of_string(json.text, node.offset);
  return json.text.find_first_of(", \t\r\n}]/", node.offset);
}

Result<std::string> with_poses(std::string_view text, const World& start, const World& world) {
  JsonLimits limits;
  limits.style = JsonStyle::json5;
  const JsonDocument json = parse_json(text, limits);
  if (json.nodes.empty() || json[0].kind != JsonKind::object || json[0].count == 0)
    return Error{"found no scene in the file, expected an object"};
  const Real unit = length_unit_of(json);
  const NodeId poses = json.member(0, "poses");
  const std::vector<std::string> listed = listed_bodies(json, poses);
  std::string list;
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const Entity e = world.bodies.owners()[i];
    const std::string name = world.name_of(e);
    const Body* was = start.bodies.find(e);
    if (!was || start.paths.find(e)) continue;  // added since; posed by its path
    const Pose &now = world.bodies.values()[i].pose, &before = was->pose;
    const bool stays = now.position == before.position && now.rotation == before.rotation;
    if (stays && std::find(listed.begin(), listed.end(), name) == listed.end()) continue;
    const Pose own = world.origin_pose(e);
    const auto [x, q] = std::pair(own.position / unit, own.rotation);
    list += fmt::format(
        "{}\n    {{\"body\": {}, \"position\": [{}, {}, {}], \"rotation\": [{}, {}, {}, {}]}}",
        list.empty() ? "" : ",", nlohmann::json(name).dump(), x.x, x.y, x.z, q.x, q.y, q.z, q.w);
  }
  list = "[" + list + (list.empty() ? "]" : "\n  ]");
  std::string written(text);
  if (poses != kNoNode) {
    const std::size_t from = json[poses].offset;
    written.replace(from, end_of_value(text, from) - from, list);
  } else {
    // Before the closing brace, which the end of the object is behind; a comma may end the last
    // member already.
    const std::size_t close = end_of_value(text, json[0].offset) - 1;
    NodeId last = json[0].first_child;
    while (json[last].next != kNoNode) last = json[last].next;
    const std::size_t end = end_of_member(json, last);
    std::size_t at = end;
    while (at < close && text[at] != ',') {
      const std::size_t comment = end_of_comment(text, at);
      at = comment != at ? comment : at + 1;
    }
    if (at < close)
      written.insert(at + 1, "\n  \"poses\": " + list + ",");
    else
      written.insert(end, ",\n  \"poses\": " + list);
  }
  return written;
}

}  // namespace pantin::program
