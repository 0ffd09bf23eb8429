#pragma once
/// Collects what is wrong with a scene file, each with its place, so that all of it is told at
/// once.
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/json.hpp"

namespace pantin {

class Complaints {
 public:
  /// `file` stands at the head of every line.
  Complaints(const JsonDocument& json, std::string file) : json_(json), file_(std::move(file)) {}

  /// Something that keeps the scene from being read, at a value.
  void refuse(NodeId at, std::string message) {
    errors_.push_back({offset(at), at, std::move(message)});
  }
  /// The same, at a value's key.
  void refuse_key(NodeId at, std::string message) {
    errors_.push_back({json_[at].key_offset, at, std::move(message)});
  }
  /// Refuses what is there for the sake of what should be: "found <value>, expected <what>".
  void refuse_value(NodeId at, std::string_view expected);

  /// Something the scene runs with all the same. Warnings of one `kind` about one place are told
  /// once, with their number: a prefab's fault is not told for every copy.
  void warn(NodeId at, std::string_view kind, std::string message);

  bool any_errors() const { return !errors_.empty() || !json_.faults.empty(); }
  /// How many refusals there were so far.
  std::size_t refused() const { return errors_.size(); }
  /// In the order of the text, at most some hundred.
  std::vector<Error> errors() const;
  std::vector<std::string> warnings() const;

 private:
  struct Line {
    std::uint32_t offset;
    NodeId node;
    std::string message;
    std::size_t copies = 1;
  };
  std::uint32_t offset(NodeId at) const { return json_[at].offset; }
  std::string line(const Line& complaint) const;

  const JsonDocument& json_;
  std::string file_;
  std::vector<Line> errors_, warnings_;
  std::map<std::pair<NodeId, std::string>, std::size_t, std::less<>> told_;  // into warnings_
};

/// A value as complaints name it: "shim" in quotes, a number as written, "an array of 3".
std::string described(const JsonDocument& json, NodeId id);

/// The candidate nearest to `word` by edit distance, or "" if none is near. The first of equals.
std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates);

/// "; nearest is "shin"", or "" if no candidate is near.
std::string hint(std::string_view word, std::span<const std::string_view> candidates);

/// A number for a message, six digits at most.
std::string written(double number);

/// "a, b or c".
std::string listed(std::span<const std::string_view> words);

}  // namespace pantin
