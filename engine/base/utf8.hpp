#pragma once
/// Text in UTF-8 [RFC 3629]: is it sound, where do characters end.
#include <cstdint>
#include <string>
#include <string_view>

namespace pantin::detail {

inline bool is_utf8_tail(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

/// The first byte that is not part of a character (overlong forms and surrogates are none), or the
/// text's size.
std::size_t first_bad_utf8(std::string_view text);

void add_utf8(std::string& text, std::uint32_t character);

/// The same text without anything that a terminal acts upon: control characters, marks that change
/// the direction of writing and bytes that are no UTF-8 become "\u001b", "\u009b", "\xff" and so
/// on. Whoever prints text of a file prints this. Applied twice it changes nothing more.
std::string printable(std::string_view text);

/// At most some forty bytes of it, printable, for messages.
std::string clipped(std::string_view text);

}  // namespace pantin::detail
