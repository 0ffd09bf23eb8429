#include "engine/base/utf8.hpp"

#include <array>
#include <cstdio>

namespace pantin::detail {
namespace {

/// Length of the character that starts at `i`, or 0.
std::size_t character_length(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[i + k]); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || i + length > text.size()) return 0;
  for (std::size_t k = 1; k < length; ++k)
    if (!is_utf8_tail(text[i + k])) return 0;
  const unsigned second = byte(1);
  const bool overlong = (lead == 0xE0 && second < 0xA0) || (lead == 0xF0 && second < 0x90);
  const bool surrogate = lead == 0xED && second >= 0xA0;
  const bool beyond = lead == 0xF4 && second >= 0x90;
  return overlong || surrogate || beyond ? 0 : length;
}

/// The code point of one valid character.
std::uint32_t decoded(std::string_view character) {
  const auto lead = static_cast<unsigned char>(character[0]);
  if (lead < 0x80) return lead;
  std::uint32_t c = lead & (0x7Fu >> character.size());
  for (char tail : character.substr(1)) c = (c << 6) | (static_cast<unsigned char>(tail) & 0x3F);
  return c;
}

/// Control characters [ECMA-48], line separators, and marks that change the direction of writing.
bool is_acted_upon(std::uint32_t c) {
  return c < 0x20 || (c >= 0x7F && c < 0xA0) || c == 0x061C || c == 0x200E || c == 0x200F ||
         (c >= 0x2028 && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069);
}

void add_escape(std::string& text, const char* format, std::uint32_t c) {
  std::array<char, 12> escape{};
  std::snprintf(escape.data(), escape.size(), format, static_cast<unsigned>(c));
  text += escape.data();
}

}  // namespace

std::size_t first_bad_utf8(std::string_view text) {
  std::size_t i = 0;
  while (i < text.size()) {
    const std::size_t length = character_length(text, i);
    if (length == 0) return i;
    i += length;
  }
  return text.size();
}

void add_utf8(std::string& text, std::uint32_t c) {
  const auto add = [&](std::uint32_t byte) { text += static_cast<char>(byte); };
  if (c < 0x80) {
    add(c);
  } else if (c < 0x800) {
    add(0xC0 | (c >> 6)), add(0x80 | (c & 0x3F));
  } else if (c < 0x10000) {
    add(0xE0 | (c >> 12)), add(0x80 | ((c >> 6) & 0x3F)), add(0x80 | (c & 0x3F));
  } else {
    add(0xF0 | (c >> 18)), add(0x80 | ((c >> 12) & 0x3F));
    add(0x80 | ((c >> 6) & 0x3F)), add(0x80 | (c & 0x3F));
  }
}

std::string printable(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_length(text, i);
    if (length == 0) {
      add_escape(result, "\\x%02x", static_cast<unsigned char>(text[i++]));
      continue;
    }
    const std::uint32_t c = decoded(text.substr(i, length));
    if (is_acted_upon(c))
      add_escape(result, "\\u%04x", c);
    else
      result += text.substr(i, length);
    i += length;
  }
  return result;
}

std::string clipped(std::string_view text) {
  constexpr std::size_t kMost = 40;
  if (text.size() <= kMost) return printable(text);
  std::size_t end = kMost;
  while (end > 0 && is_utf8_tail(text[end])) --end;
  return printable(text.substr(0, end)) + "...";
}

}  // namespace pantin::detail
