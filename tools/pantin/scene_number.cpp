#include "tools/pantin/scene_number.hpp"

#include <fmt/format.h>

#include <charconv>
#include <vector>

#include "engine/base/utf8.hpp"
#include "engine/scene/json/json.hpp"
#include "engine/scene/json/words.hpp"
#include "tools/pantin/assemble.hpp"

namespace pantin::program {
namespace {

/// The parts of a pointer, unescaped.
std::vector<std::string> parts_of(std::string_view pointer) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < pointer.size(); ++i) {
    if (pointer[i] == '/')
      parts.emplace_back();
    else if (pointer[i] == '~' && i + 1 < pointer.size() && pointer[i + 1] == '1')
      parts.back() += '/', ++i;
    else if (pointer[i] == '~' && i + 1 < pointer.size() && pointer[i + 1] == '0')
      parts.back() += '~', ++i;
    else
      parts.back() += pointer[i];
  }
  return parts;
}

/// The element of a list by its place or its name, or kNoNode.
NodeId element(const JsonDocument& json, NodeId list, const std::string& part) {
  std::size_t place = 0;
  const auto read = std::from_chars(part.data(), part.data() + part.size(), place);
  const bool is_place = read.ec == std::errc() && read.ptr == part.data() + part.size();
  for (NodeId at = json[list].first_child; at != kNoNode; at = json[at].next) {
    if (is_place && json[at].place == place) return at;
    if (json[at].kind != JsonKind::object) continue;
    const NodeId name = json.member(at, "name");
    if (name != kNoNode && json[name].text == part) return at;
  }
  return kNoNode;
}

std::string escaped(const std::string& text) {
  std::string all;
  for (const char c : text)
    all += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return all;
}

/// Whether a part of a pointer is the place of an element in a list.
bool is_place(const std::string& part) {
  return !part.empty() && part.find_first_not_of("0123456789") == std::string::npos;
}

/// The first parts of a pointer.
std::string words_of(const std::vector<std::string>& parts, std::size_t count) {
  std::string words;
  for (std::size_t k = 0; k < count; ++k) words += "/" + parts[k];
  return printable(words);
}

}  // namespace

Result<std::string> with_value(std::string_view text, std::string_view pointer,
                               std::string_view words, Replaced what) {
  if (pointer.empty() || pointer.front() != '/')
    return Error{fmt::format("found \"{}\", expected a JSON pointer such as /bodies/0/mass",
                             printable(pointer))};
  JsonLimits limits;
  limits.style = JsonStyle::json5;
  const JsonDocument json = parse_json(text, limits);
  if (json.nodes.empty() || json[0].kind != JsonKind::object)
    return Error{"found no object, expected a scene"};
  const std::vector<std::string> parts = parts_of(pointer);
  NodeId at = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const JsonKind kind = json[at].kind;
    NodeId next = kNoNode;
    if (kind == JsonKind::array) next = element(json, at, parts[i]);
    if (kind == JsonKind::object) next = json.member(at, parts[i]);
    if (next == kNoNode && kind == JsonKind::object) {
      for (std::size_t k = i + 1; k < parts.size(); ++k)
        if (is_place(parts[k]))
          return Error{fmt::format(
              "found no \"{}\" in {}, expected that list: a number of one that the file leaves out "
              "cannot be set",
              printable(parts[k - 1]), k - 1 == 0 ? "the scene" : words_of(parts, k - 1))};
      std::string value = fmt::format("\"{}\": {}", escaped(parts.back()), words);
      for (std::size_t k = parts.size() - 1; k-- > i;)
        value = fmt::format("\"{}\": {{{}}}", escaped(parts[k]), value);
      std::string whole(text);
      whole.insert(json[at].offset + 1, value + (json[at].count > 0 ? ", " : ""));
      return whole;
    }
    if (next == kNoNode)
      return Error{fmt::format(
          "found no \"{}\" in {}, expected {}", printable(parts[i]),
          at == 0 ? "the scene" : json.pointer(at),
          kind == JsonKind::array ? "a place or a name in that list" : "an object or a list")};
    at = next;
  }
  if (what == Replaced::numbers_only && json[at].kind != JsonKind::number)
    return Error{fmt::format("found no number at {}, expected one", printable(pointer))};
  std::string whole(text);
  whole.replace(json[at].offset, end_of_member(json, at) - json[at].offset, words);
  return whole;
}

Result<std::string> with_number(std::string_view text, std::string_view pointer, double number) {
  return with_value(text, pointer, number_text(number), Replaced::numbers_only);
}

Result<std::string> with_setting(std::string_view text, std::string_view setting) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string_view::npos || equals == 0)
    return Error{fmt::format("--set: found \"{}\", expected POINTER=VALUE, such as bodies/0/mass=2",
                             printable(setting))};
  std::string pointer(setting.substr(0, equals)), value(setting.substr(equals + 1));
  if (pointer.front() != '/') pointer.insert(0, "/");
  JsonLimits limits;
  limits.style = JsonStyle::json5;
  if (const JsonDocument json = parse_json(value, limits);
      json.nodes.empty() || !json.faults.empty())
    value = fmt::format("\"{}\"", escaped(value));  // a word
  Result<std::string> set = with_value(text, pointer, value);
  if (set) return set;
  return Error{"--set: " + set.errors().front().message};
}

}  // namespace pantin::program
