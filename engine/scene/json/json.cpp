#include "engine/scene/json/json.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "engine/base/utf8.hpp"

namespace pantin::detail {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

/// The decimal exponent of the first nonzero digit of a number that from_chars reports as out of
/// range; clamped to kFarPower either way.
constexpr std::int64_t kFarPower = std::int64_t(1) << 40;  // beyond the length of any text
std::int64_t leading_power(std::string_view digits) {
  const std::size_t e = std::min(digits.find_first_of("eE"), digits.size());
  const std::string_view mantissa = digits.substr(0, e);
  const std::size_t first = mantissa.find_first_of("123456789");
  if (first == std::string_view::npos) return -1;
  const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
  std::int64_t exponent = 0;
  if (e < digits.size()) {
    const std::string_view tail = digits.substr(e + (digits[e + 1] == '+' ? 2 : 1));
    // An exponent that overflows an integer is out of range as well.
    if (std::from_chars(tail.data(), tail.data() + tail.size(), exponent).ec != std::errc())
      return tail[0] == '-' ? -kFarPower : kFarPower;
    exponent = std::clamp(exponent, -kFarPower, kFarPower);
  }
  return static_cast<std::int64_t>(point) - static_cast<std::int64_t>(first) + exponent;
}

class Parser {
 public:
  Parser(JsonDocument& document, const JsonLimits& limits)
      : document_(document), text_(document.text), limits_(limits), poll_(limits.poll) {}

  void parse() {
    if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
    if (const std::size_t bad = first_bad_utf8(text_); bad < text_.size()) {
      at_ = bad;
      fail(hexadecimal(static_cast<unsigned char>(text_[bad])), "text in UTF-8");
      return;
    }
    skip_space();
    if (at_ == text_.size()) {
      fail("an empty file", "a JSON object");
      return;
    }
    if (value(kNoNode, 0) == kNoNode) return;
    skip_space();
    if (at_ < text_.size()) fail(here(), "nothing after the end of the JSON value");
  }

 private:
  static std::string hexadecimal(unsigned char byte) {
    std::array<char, 16> word{};
    std::snprintf(word.data(), word.size(), "byte 0x%02X", byte);
    return word.data();
  }

  /// The token at the current position, for messages.
  std::string here() const {
    if (at_ >= text_.size()) return "the end of the file";
    const char c = text_[at_];
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F)
      return c == '\n' || c == '\r' ? "the end of the line"
                                    : hexadecimal(static_cast<unsigned char>(c));
    std::size_t end = at_ + 1;
    if (is_letter(c) || is_digit(c)) {
      while (end < text_.size() && (is_letter(text_[end]) || is_digit(text_[end]))) ++end;
    } else {
      while (end < text_.size() && is_utf8_tail(text_[end])) ++end;
    }
    return "\"" + clipped(text_.substr(at_, end - at_)) + "\"";
  }

  NodeId fail(const std::string& found, std::string_view expected) {
    document_.faults.push_back({static_cast<std::uint32_t>(at_), kNoNode,
                                "found " + found + ", expected " + std::string(expected)});
    return kNoNode;
  }

  /// Reports a fault after which the rest can still be read.
  void note(std::size_t offset, NodeId id, std::string message) {
    constexpr std::size_t kMostKept = 10'000;
    if (document_.faults.size() < kMostKept)
      document_.faults.push_back({static_cast<std::uint32_t>(offset), id, std::move(message)});
    else
      ++document_.more_faults;
  }

  bool is_json5() const { return limits_.style == JsonStyle::json5; }

  void skip_space() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == ' ' || c == '\n' || c == '\t' || c == '\r')
        ++at_;
      else if (!is_json5() || !skip_more())
        return;
    }
  }
  /// Skips comments, and the further white space of JSON5. An unterminated comment extends to the
  /// end.
  bool skip_more() {
    const std::string_view rest = text_.substr(at_);
    for (const std::string_view space :
         {"\v", "\f", "\xC2\xA0", "\xE2\x80\xA8", "\xE2\x80\xA9", "\xEF\xBB\xBF"})
      if (rest.starts_with(space)) return at_ += space.size(), true;
    const bool line = rest.starts_with("//");
    if (!line && !rest.starts_with("/*")) return false;
    const std::size_t end = line ? rest.find_first_of("\n\r", 2) : rest.find("*/", 2);
    at_ += end == std::string_view::npos ? rest.size() : end + (line ? 0 : 2);
    return true;
  }
  bool take(char c) {
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }

  NodeId value(NodeId parent, std::size_t depth) {
    poll_();
    skip_space();
    if (depth > limits_.depth)
      return fail("a value nested " + std::to_string(depth) + " deep",
                  "at most " + std::to_string(limits_.depth));
    if (document_.nodes.size() >= limits_.values)
      return fail("more than " + std::to_string(limits_.values) + " values", "fewer");
    const auto id = static_cast<NodeId>(document_.nodes.size());
    JsonNode& node = document_.nodes.emplace_back();
    node.offset = static_cast<std::uint32_t>(at_);
    node.parent = parent;
    const char c = at_ < text_.size() ? text_[at_] : '\0';
    const std::size_t start = at_;
    bool good;
    if (c == '{' || c == '[') {
      node.kind = c == '{' ? JsonKind::object : JsonKind::array;
      good = children(id, depth);
    } else if (opens_string(c)) {
      node.kind = JsonKind::string;
      return string(node.text) ? id : kNoNode;
    } else {
      const bool begins = c == '-' || is_digit(c) || (is_json5() && (c == '+' || c == '.'));
      good = begins ? number(id) : word(id);
    }
    if (!good) return kNoNode;
    document_.nodes[id].text = text_.substr(start, at_ - start);
    return id;
  }

  /// Parses the values within the object or array `id`.
  bool children(NodeId id, std::size_t depth) {
    const bool is_object = document_.nodes[id].kind == JsonKind::object;
    const char close = is_object ? '}' : ']';
    ++at_;
    skip_space();
    if (take(close)) return true;
    NodeId last = kNoNode;
    while (true) {
      std::string_view key;
      skip_space();
      const auto key_offset = static_cast<std::uint32_t>(at_);
      if (is_object && !member_key(key)) return false;
      const NodeId child = value(id, depth + 1);
      if (child == kNoNode) return false;
      JsonNode& node = document_.nodes[child];
      node.key = key;
      node.key_offset = is_object ? key_offset : node.offset;
      node.place = document_.nodes[id].count++;
      (last == kNoNode ? document_.nodes[id].first_child : document_.nodes[last].next) = child;
      last = child;
      skip_space();
      if (take(close)) break;
      if (!take(',')) {
        fail(here(), is_object ? "\",\" or \"}\"" : "\",\" or \"]\"");
        return false;
      }
      skip_space();
      if (is_json5() && take(close)) break;
      if (at_ < text_.size() && text_[at_] == close) {
        fail(here(), is_object ? "another key after the comma" : "another value after the comma");
        return false;
      }
    }
    if (is_object) refuse_repeated_keys(id);
    return true;
  }

  bool opens_string(char c) const { return c == '"' || (is_json5() && c == '\''); }

  /// A key without quotes, as in JSON5; empty if there is none.
  std::string_view bare_key() {
    const auto is_name = [](char c) {
      return is_letter(c) || c == '$' || static_cast<unsigned char>(c) >= 0x80;
    };
    const std::size_t start = at_;
    if (!is_json5() || at_ >= text_.size() || !is_name(text_[at_])) return {};
    while (at_ < text_.size() && (is_name(text_[at_]) || is_digit(text_[at_]))) ++at_;
    return text_.substr(start, at_ - start);
  }

  bool member_key(std::string_view& key) {
    key = bare_key();
    if (key.empty()) {
      if (at_ >= text_.size() || !opens_string(text_[at_])) {
        fail(here(), is_json5() ? "a key" : "a key in double quotes");
        return false;
      }
      if (!string(key)) return false;
    }
    skip_space();
    if (take(':')) return true;
    fail(here(), "\":\" after the key");
    return false;
  }

  void refuse_repeated_keys(NodeId object) {
    std::vector<std::pair<std::string_view, NodeId>> keys;
    for (NodeId c = document_[object].first_child; c != kNoNode; c = document_[c].next)
      keys.emplace_back(document_[c].key, c);
    std::sort(keys.begin(), keys.end());
    for (std::size_t i = 1; i < keys.size(); ++i)
      if (keys[i].first == keys[i - 1].first)
        note(document_[keys[i].second].key_offset, keys[i].second,
             "found key \"" + clipped(keys[i].first) + "\" twice, expected each key once");
  }

  bool number(NodeId id) {
    const std::size_t start = at_;
    const bool plus = is_json5() && take('+');
    if (!plus) take('-');
    if (text_.substr(at_).starts_with("Infinity")) return not_finite(id, start, 8);
    if (is_json5() && text_.substr(at_).starts_with("NaN")) return not_finite(id, start, 3);
    const std::size_t whole = at_;
    if (is_json5() && (text_.substr(at_).starts_with("0x") || text_.substr(at_).starts_with("0X")))
      return hexadecimal_number(id, start);
    while (at_ < text_.size() && is_digit(text_[at_])) ++at_;
    const std::size_t digits = at_ - whole;
    bool good = is_json5() ? digits < 2 || text_[whole] != '0'
                           : digits > 0 && (text_[whole] != '0' || digits == 1);
    if (good && take('.')) {
      const std::size_t fraction = at_;
      while (at_ < text_.size() && is_digit(text_[at_])) ++at_;
      good = at_ > fraction || (is_json5() && digits > 0);
    } else {
      good = good && digits > 0;
    }
    if (good && (take('e') || take('E'))) {
      if (!take('+')) take('-');
      const std::size_t exponent = at_;
      while (at_ < text_.size() && is_digit(text_[at_])) ++at_;
      good = at_ > exponent;
    }
    if (!good || (at_ < text_.size() && (is_letter(text_[at_]) || text_[at_] == '.'))) {
      while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]) ||
                                    text_[at_] == '.' || text_[at_] == '+' || text_[at_] == '-'))
        ++at_;
      const std::string found = "\"" + clipped(text_.substr(start, at_ - start)) + "\"";
      at_ = start;
      fail(found, "a number as JSON writes it, like -1.5e3");
      return false;
    }
    convert(id, text_.substr(start + (plus ? 1 : 0), at_ - start - (plus ? 1 : 0)));
    return true;
  }

  bool hexadecimal_number(NodeId id, std::size_t start) {
    const char *first = text_.data() + at_ + 2, *last = text_.data() + text_.size();
    JsonNode& node = document_.nodes[id];
    node.kind = JsonKind::number;
    std::uint64_t read = 0;
    const auto answer = std::from_chars(first, last, read, 16);
    at_ = static_cast<std::size_t>(answer.ptr - text_.data());
    if (answer.ec != std::errc() || (at_ < text_.size() && is_letter(text_[at_]))) {
      at_ = start;
      fail(here(), "a number of at most 16 hexadecimal digits");
      return false;
    }
    node.number = text_[start] == '-' ? -static_cast<double>(read) : static_cast<double>(read);
    return true;
  }

  void convert(NodeId id, std::string_view digits) {
    JsonNode& node = document_.nodes[id];
    node.kind = JsonKind::number;
    const auto answer = std::from_chars(digits.data(), digits.data() + digits.size(), node.number);
    if (answer.ec == std::errc()) return;
    if (leading_power(digits) < 0) return;  // underflow: rounds to 0
    node.number = std::numeric_limits<double>::quiet_NaN();
    note(node.offset, id, "found " + clipped(digits) + ", expected a finite number");
  }

  /// NaN and the like: invalid JSON, but reading can continue after them.
  bool not_finite(NodeId id, std::size_t start, std::size_t letters) {
    at_ += letters;
    document_.nodes[id].kind = JsonKind::number;
    document_.nodes[id].number = std::numeric_limits<double>::quiet_NaN();
    note(start, id,
         "found " + std::string(text_.substr(start, at_ - start)) + ", expected a finite number");
    return true;
  }

  bool word(NodeId id) {
    const std::string_view rest = text_.substr(at_);
    JsonNode& node = document_.nodes[id];
    std::size_t length = 0;
    while (length < rest.size() && (is_letter(rest[length]) || is_digit(rest[length]))) ++length;
    const std::string_view found = rest.substr(0, length);
    if (found == "NaN" || found == "nan" || found == "Infinity" || found == "inf")
      return not_finite(id, at_, length);
    if (found == "true" || found == "false") {
      node.kind = JsonKind::boolean;
      node.boolean = found == "true";
    } else if (found != "null") {
      fail(here(), rest.starts_with("/") ? "a value; JSON has no comments, files named .json5 may"
                                         : "a value");
      return false;
    }
    at_ += length;
    return true;
  }

  /// Reads a quoted string; `result` points into the text unless an escape had to be decoded.
  bool string(std::string_view& result) {
    const char quote = text_[at_];
    const std::size_t start = ++at_;
    while (at_ < text_.size() && text_[at_] != quote && text_[at_] != '\\' &&
           static_cast<unsigned char>(text_[at_]) >= 0x20)
      ++at_;
    if (take(quote)) {
      result = text_.substr(start, at_ - start - 1);
      return true;
    }
    std::string& whole = document_.unescaped.emplace_back(text_.substr(start, at_ - start));
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (static_cast<unsigned char>(c) < 0x20) break;
      ++at_;
      if (c == quote) {
        result = whole;
        return true;
      }
      if (c != '\\')
        whole += c;
      else if (!escape(whole))
        return false;
    }
    fail(here(), "the closing quote of a string");
    return false;
  }

  bool escape(std::string& whole) {
    constexpr std::string_view kLetters = "\"\\/bfnrt", kMeanings = "\"\\/\b\f\n\r\t";
    const char c = at_ < text_.size() ? text_[at_] : '\0';
    if (const std::size_t i = kLetters.find(c); c != '\0' && i != std::string_view::npos) {
      ++at_;
      whole += kMeanings[i];
      return true;
    }
    if (is_json5() && escape_of_json5(whole)) return true;
    const std::size_t start = at_;
    std::uint32_t unit = 0;
    if (c == 'u' && ++at_ && four_digits(unit)) {
      const bool is_high = unit >= 0xD800 && unit < 0xDC00;
      std::uint32_t low = 0;
      if (is_high && text_.substr(at_).starts_with("\\u") && (at_ += 2) && four_digits(low) &&
          low >= 0xDC00 && low < 0xE000)
        unit = 0x10000 + ((unit - 0xD800) << 10) + (low - 0xDC00);
      if (unit < 0xD800 || unit >= 0xE000) {
        add_utf8(whole, unit);
        return true;
      }
    }
    at_ = start;
    fail("\\" + std::string(text_.substr(start, 1)),
         "an escape: one of \\\" \\\\ \\/ \\b \\f \\n \\r \\t or \\u and four digits");
    return false;
  }

  /// The further escapes of JSON5; an escaped line end is not part of the string.
  bool escape_of_json5(std::string& whole) {
    const std::string_view rest = text_.substr(at_);
    for (const std::string_view end : {"\r\n", "\n", "\r", "\xE2\x80\xA8", "\xE2\x80\xA9"})
      if (rest.starts_with(end)) return at_ += end.size(), true;
    const char c = rest.empty() ? '\0' : rest[0];
    if (c == 'x' && rest.size() >= 3) {
      std::uint32_t unit = 0;
      if (std::from_chars(&rest[1], &rest[3], unit, 16).ptr != &rest[3]) return false;
      at_ += 3;
      return add_utf8(whole, unit), true;
    }
    if (c == '0' && (rest.size() < 2 || !is_digit(rest[1])))
      whole += '\0';
    else if (c == 'v')
      whole += '\v';
    else if (c == 'u' || c == 'x' || is_digit(c) || static_cast<unsigned char>(c) < 0x20)
      return false;
    else
      whole += c;  // any other character stands for itself
    ++at_;
    return true;
  }

  bool four_digits(std::uint32_t& unit) {
    if (at_ + 4 > text_.size()) return false;
    const char *first = text_.data() + at_, *last = first + 4;
    if (std::from_chars(first, last, unit, 16).ptr != last) return false;
    at_ += 4;
    return true;
  }

  JsonDocument& document_;
  std::string_view text_;
  const JsonLimits& limits_;
  Poll poll_;
  std::size_t at_ = 0;
};

}  // namespace

NodeId JsonDocument::member(NodeId object, std::string_view key) const {
  for (NodeId c = nodes[object].first_child; c != kNoNode; c = nodes[c].next)
    if (nodes[c].key == key) return c;
  return kNoNode;
}

std::string JsonDocument::pointer(NodeId id) const {
  std::vector<NodeId> way;
  for (; nodes[id].parent != kNoNode; id = nodes[id].parent) way.push_back(id);
  std::string whole;
  for (std::size_t i = way.size(); i-- > 0;) {
    const JsonNode& node = nodes[way[i]];
    whole += '/';
    if (nodes[node.parent].kind == JsonKind::array) {
      whole += std::to_string(node.place);
      continue;
    }
    for (char c : node.key) {
      if (c == '~')
        whole += "~0";
      else if (c == '/')
        whole += "~1";
      else
        whole += c;
    }
  }
  return whole;
}

TextCursor::TextCursor(std::string_view text) : text_(text) {
  if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
}

LineColumn TextCursor::place_of(std::size_t offset) {
  for (; at_ < offset && at_ < text_.size(); ++at_) {
    if (text_[at_] == '\n')
      ++place_.line, place_.column = 1;
    else if (!is_utf8_tail(text_[at_]))
      ++place_.column;
  }
  return place_;
}

LineColumn place_of(std::string_view text, std::size_t offset) {
  return TextCursor(text).place_of(offset);
}

JsonDocument parse_json(std::string_view text, const JsonLimits& limits) {
  JsonDocument document;
  document.text = text;
  Parser(document, limits).parse();
  return document;
}

}  // namespace pantin::detail
