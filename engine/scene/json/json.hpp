#pragma once
/// JSON text as a tree that records the position of every value [RFC 8259, RFC 6901].
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/poll.hpp"

namespace pantin::detail {

enum class JsonKind : std::uint8_t { null, boolean, number, string, array, object };

/// An index into JsonDocument::nodes.
using NodeId = std::uint32_t;
inline constexpr NodeId kNoNode = UINT32_MAX;

struct JsonNode {
  JsonKind kind = JsonKind::null;
  bool boolean = false;
  double number = 0;         // NaN if it is invalid
  std::string_view text;     // of a string: unescaped; of anything else: as written
  std::string_view key;      // of a member of an object: unescaped
  std::uint32_t offset = 0;  // bytes before the value
  std::uint32_t key_offset = 0;
  NodeId parent = kNoNode;
  std::uint32_t place = 0;  // index among the parent's children
  NodeId first_child = kNoNode, next = kNoNode;
  std::uint32_t count = 0;  // number of children
};

/// A fault of the text. Without a node the text is not JSON at all.
struct JsonFault {
  std::uint32_t offset = 0;
  NodeId node = kNoNode;
  std::string message;  // "found ..., expected ..."
};

/// Strict JSON, or JSON5: comments, trailing commas, keys without quotes, single quotes, more ways
/// to write numbers [json5.org, version 1.0.0].
enum class JsonStyle : std::uint8_t { strict, json5 };

struct JsonLimits {
  std::size_t values = 8'000'000;
  std::size_t depth = 64;
  Poll poll{};
  JsonStyle style = JsonStyle::strict;
};

/// Owns the nodes; `text` must outlive it. Node 0 is the root.
struct JsonDocument {
  std::string_view text;
  std::vector<JsonNode> nodes;
  std::vector<JsonFault> faults;
  std::size_t more_faults = 0;  // beyond some thousands they are only counted
  std::deque<std::string> unescaped;

  const JsonNode& operator[](NodeId id) const { return nodes[id]; }
  /// The member of an object, or kNoNode.
  NodeId member(NodeId object, std::string_view key) const;
  /// The JSON pointer of a node, as in /bodies/3/name; "" for the root.
  std::string pointer(NodeId id) const;
};

/// Line and column of a byte, both from 1; columns count characters.
struct LineColumn {
  std::size_t line = 1, column = 1;
};
LineColumn place_of(std::string_view text, std::size_t offset);

/// The same for many bytes in ascending order, in one pass over the text.
class TextCursor {
 public:
  explicit TextCursor(std::string_view text);
  LineColumn place_of(std::size_t offset);

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  LineColumn place_;
};

/// Reads JSON in UTF-8, with or without a byte order mark. Faults after which the rest can be read
/// (repeated keys, non-finite numbers) are collected; others end the reading. Throws Cancelled if
/// the poll says so.
JsonDocument parse_json(std::string_view text, const JsonLimits& limits = {});

}  // namespace pantin::detail
