#pragma once
/// Collects what is wrong with a scene file, each with its place, so that all of it is told at
/// once.
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/json.hpp"
#include "engine/scene/words.hpp"

namespace pantin {

class Complaints {
 public:
  /// `file` stands at the head of every line.
  Complaints(const JsonDocument& json, std::string file) : json_(json), file_(std::move(file)) {}

  /// Something that keeps the scene from being read, at a value.
  void refuse(NodeId at, std::string message) {
    keep(errors_, {offset(at), at, std::move(message)});
  }
  /// The same, at a value's key.
  void refuse_key(NodeId at, std::string message) {
    keep(errors_, {json_[at].key_offset, at, std::move(message)});
  }
  /// Refuses what is there for the sake of what should be: "found <value>, expected <what>".
  void refuse_value(NodeId at, std::string_view expected);

  /// Something the scene runs with all the same. Warnings of one `kind` about one place are told
  /// once, with their number: a prefab's fault is not told for every copy.
  void warn(NodeId at, std::string_view kind, std::string message);

  bool any_errors() const { return refused() > 0 || !json_.faults.empty(); }
  /// How many refusals there were so far.
  std::size_t refused() const { return errors_.lines.size() + errors_.dropped; }
  /// In the order of the text, printable, at most some hundred; a last line tells of the rest.
  std::vector<Error> errors() const;
  std::vector<std::string> warnings() const;

  /// For the messages of this file.
  Hints hints;

 private:
  struct Line {
    std::uint32_t offset;
    NodeId node;
    std::string message;
    std::size_t copies = 1;
  };
  /// Lines as they came. Beyond some thousands they are counted only.
  struct Kept {
    std::vector<Line> lines;
    std::size_t dropped = 0;
  };
  std::uint32_t offset(NodeId at) const { return json_[at].offset; }
  static void keep(Kept& kept, Line line);
  std::vector<std::string> told(Kept all, const std::string& what) const;
  std::string told(const Line& line, LineColumn place) const;

  const JsonDocument& json_;
  std::string file_;
  Kept errors_, warnings_;
  std::map<std::pair<NodeId, std::string>, std::size_t, std::less<>> told_;  // into warnings_
};

/// A value as complaints name it: "shim" in quotes, a number as written, "an array of 3".
std::string described(const JsonDocument& json, NodeId id);

}  // namespace pantin
