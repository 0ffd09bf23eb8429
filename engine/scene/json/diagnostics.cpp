#include "engine/scene/json/diagnostics.hpp"

#include <algorithm>

#include "engine/base/utf8.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kMostKept = 10'000, kMostTold = 100;

}  // namespace

void Diagnostics::error_value(NodeId at, std::string_view expected) {
  error(at, "found " + described(json_, at) + ", expected " + std::string(expected));
}

void Diagnostics::warn(NodeId at, std::string_view kind, std::string message) {
  const auto known = told_.find(std::pair(at, std::string(kind)));
  if (known != told_.end()) {
    ++warnings_.lines[known->second].copies;
    return;
  }
  if (warnings_.lines.size() < kMostKept)
    told_.emplace(std::pair(at, std::string(kind)), warnings_.lines.size());
  keep(warnings_, {offset(at), at, std::move(message)});
}

void Diagnostics::keep_error(Line line) {
  if (errors_.lines.size() < kMostKept && !told_errors_.emplace(line.node, line.message).second)
    ++repeated_errors_;
  else
    keep(errors_, std::move(line));
}

void Diagnostics::keep(Kept& kept, Line line) {
  if (kept.lines.size() < kMostKept)
    kept.lines.push_back(std::move(line));
  else
    ++kept.dropped;
}

std::string Diagnostics::told(const Line& line, LineColumn place) const {
  std::string whole = file_ + ":" + std::to_string(place.line) + ":" + std::to_string(place.column);
  if (line.node != kNoNode && json_[line.node].parent != kNoNode)
    whole += ": " + json_.pointer(line.node);
  whole += ": " + line.message;
  if (line.copies > 1) whole += " (and " + std::to_string(line.copies - 1) + " more like it)";
  return printable(whole);
}

std::vector<std::string> Diagnostics::told(Kept all, const std::string& what) const {
  std::stable_sort(all.lines.begin(), all.lines.end(),
                   [](const Line& a, const Line& b) { return a.offset < b.offset; });
  std::vector<std::string> lines;
  TextCursor cursor(json_.text);
  for (const Line& line : all.lines) {
    if (lines.size() == kMostTold) break;
    lines.push_back(told(line, cursor.place_of(line.offset)));
  }
  const std::size_t rest = all.lines.size() - lines.size() + all.dropped;
  if (rest > 0)
    lines.push_back(printable(file_) + ": " + std::to_string(rest) + " more " + what +
                    " are not shown");
  return lines;
}

std::vector<Error> Diagnostics::errors() const {
  Kept all = errors_;
  for (const JsonFault& fault : json_.faults)
    all.lines.push_back({fault.offset, fault.node, fault.message});
  all.dropped += json_.more_faults;
  std::vector<Error> errors;
  for (std::string& line : told(std::move(all), "errors")) errors.push_back({std::move(line)});
  return errors;
}

std::vector<std::string> Diagnostics::warnings() const { return told(warnings_, "warnings"); }

std::string described(const JsonDocument& json, NodeId id) {
  const JsonNode& node = json[id];
  switch (node.kind) {
    case JsonKind::string:
      return quoted_name(node.text);
    case JsonKind::array:
      return node.count == 0 ? "an empty array" : "an array of " + std::to_string(node.count);
    case JsonKind::object:
      return node.count == 0 ? "an empty object" : "an object";
    default:  // numbers and words, as written
      return clipped(node.text);
  }
}

}  // namespace pantin::detail
