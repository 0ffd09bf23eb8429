#pragma once
/// Text in UTF-8 [RFC 3629]: validation and boundaries of characters.
#include <cstdint>
#include <string>
#include <string_view>

namespace pantin::detail {

inline bool is_utf8_tail(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

/// The offset of the first byte that is not part of a valid character (overlong forms and
/// surrogates are invalid), or the text's size.
std::size_t first_bad_utf8(std::string_view text);

void add_utf8(std::string& text, std::uint32_t character);

/// The text without anything that a terminal interprets: control characters, marks that change the
/// direction of writing and invalid bytes become "\u001b", "\u009b", "\xff" and so on. Use it for
/// all text from files. It is idempotent.
std::string printable(std::string_view text);

/// About forty bytes of it at most, printable, for messages.
std::string clipped(std::string_view text);

}  // namespace pantin::detail
