#pragma once
/// Collects the errors and warnings of a scene file with their positions, so that all are reported
/// at once.
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/json/json.hpp"
#include "engine/scene/json/words.hpp"

namespace pantin::detail {

class Diagnostics {
 public:
  /// `file` is the prefix of every line.
  Diagnostics(const JsonDocument& json, std::string file) : json_(json), file_(std::move(file)) {}

  /// An error at a value; the scene cannot be loaded. An error in a class that several objects
  /// inherit is reported once.
  void error(NodeId at, std::string message) { keep_error({offset(at), at, std::move(message)}); }
  /// The same at the value's key.
  void error_at_key(NodeId at, std::string message) {
    keep_error({json_[at].key_offset, at, std::move(message)});
  }
  /// An error of the form "found <value>, expected <what>".
  void error_value(NodeId at, std::string_view expected);

  /// A warning; the scene can be loaded. Warnings of one `kind` at one position are reported once,
  /// with their number, so that a fault of a prefab is not repeated for every copy.
  void warn(NodeId at, std::string_view kind, std::string message);

  bool any_errors() const { return error_count() > 0 || !json_.faults.empty(); }
  /// Number of errors so far.
  std::size_t error_count() const {
    return errors_.lines.size() + errors_.dropped + repeated_errors_;
  }
  /// In the order of the text, printable, at most about a hundred; a last line counts the rest.
  std::vector<Error> errors() const;
  std::vector<std::string> warnings() const;

  /// Name suggestions for the messages of this file.
  Hints hints;

 private:
  struct Line {
    std::uint32_t offset;
    NodeId node;
    std::string message;
    std::size_t copies = 1;
  };
  /// Lines in order of arrival. Beyond some thousands they are only counted.
  struct Kept {
    std::vector<Line> lines;
    std::size_t dropped = 0;
  };
  std::uint32_t offset(NodeId at) const { return json_[at].offset; }
  void keep_error(Line line);
  static void keep(Kept& kept, Line line);
  std::vector<std::string> told(Kept all, const std::string& what) const;
  std::string told(const Line& line, LineColumn place) const;

  const JsonDocument& json_;
  std::string file_;
  Kept errors_, warnings_;
  std::map<std::pair<NodeId, std::string>, std::size_t, std::less<>> told_;  // into warnings_
  std::set<std::pair<NodeId, std::string>> told_errors_;
  std::size_t repeated_errors_ = 0;
};

/// A value as errors describe it: "shim" in quotes, a number as written, "an array of 3".
std::string described(const JsonDocument& json, NodeId id);

}  // namespace pantin::detail
