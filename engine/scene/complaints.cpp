#include "engine/scene/complaints.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <numeric>

#include "engine/scene/utf8.hpp"

namespace pantin {
namespace {

constexpr std::size_t kMostErrors = 100;

/// Edits (insert, delete, replace, swap neighbours) from `a` to `b` [Damerau 1964, restricted].
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> two(b.size() + 1), one(b.size() + 1), now(b.size() + 1);
  std::iota(one.begin(), one.end(), std::size_t(0));
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({one[j] + 1, now[j - 1] + 1, one[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        now[j] = std::min(now[j], two[j - 2] + 1);
    }
    std::swap(two, one), std::swap(one, now);
  }
  return one[b.size()];
}

}  // namespace

void Complaints::refuse_value(NodeId at, std::string_view expected) {
  refuse(at, "found " + described(json_, at) + ", expected " + std::string(expected));
}

void Complaints::warn(NodeId at, std::string_view kind, std::string message) {
  const auto [place, is_new] = told_.try_emplace({at, std::string(kind)}, warnings_.size());
  if (is_new)
    warnings_.push_back({offset(at), at, std::move(message)});
  else
    ++warnings_[place->second].copies;
}

std::string Complaints::line(const Complaints::Line& complaint) const {
  const LineColumn place = place_of(json_.text, complaint.offset);
  std::string whole = file_ + ":" + std::to_string(place.line) + ":" + std::to_string(place.column);
  if (complaint.node != kNoNode && json_[complaint.node].parent != kNoNode)
    whole += ": " + json_.pointer(complaint.node);
  whole += ": " + complaint.message;
  if (complaint.copies > 1)
    whole += " (and " + std::to_string(complaint.copies - 1) + " more like it)";
  return whole;
}

std::vector<Error> Complaints::errors() const {
  std::vector<Line> all = errors_;
  for (const JsonFault& fault : json_.faults)
    all.push_back({fault.offset, fault.node, fault.message});
  std::stable_sort(all.begin(), all.end(),
                   [](const Line& a, const Line& b) { return a.offset < b.offset; });
  std::vector<Error> lines;
  for (const Line& complaint : all) {
    if (lines.size() == kMostErrors) {
      lines.push_back({file_ + ": " + std::to_string(all.size() - kMostErrors) +
                       " more complaints are not shown"});
      break;
    }
    lines.push_back({line(complaint)});
  }
  return lines;
}

std::vector<std::string> Complaints::warnings() const {
  std::vector<Line> all = warnings_;
  std::stable_sort(all.begin(), all.end(),
                   [](const Line& a, const Line& b) { return a.offset < b.offset; });
  std::vector<std::string> lines;
  for (const Line& complaint : all) lines.push_back(line(complaint));
  return lines;
}

std::string described(const JsonDocument& json, NodeId id) {
  const JsonNode& node = json[id];
  switch (node.kind) {
    case JsonKind::string:
      return "\"" + clipped(node.text) + "\"";
    case JsonKind::array:
      return node.count == 0 ? "an empty array" : "an array of " + std::to_string(node.count);
    case JsonKind::object:
      return node.count == 0 ? "an empty object" : "an object";
    default:
      return clipped(node.text);
  }
}

std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates) {
  std::string_view best;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (std::string_view candidate : candidates) {
    const std::size_t more = std::max(word.size(), candidate.size());
    const std::size_t difference = more - std::min(word.size(), candidate.size());
    if (difference >= least || more > 256) continue;
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < least && distance < more) least = distance, best = candidate;
  }
  return best;
}

std::string hint(std::string_view word, std::span<const std::string_view> candidates) {
  const std::string_view best = nearest(word, candidates);
  return best.empty() ? "" : "; nearest is \"" + clipped(best) + "\"";
}

std::string written(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", number);
  return text.data();
}

std::string listed(std::span<const std::string_view> words) {
  std::string whole;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) whole += i + 1 == words.size() ? " or " : ", ";
    whole += words[i];
  }
  return whole;
}

}  // namespace pantin
