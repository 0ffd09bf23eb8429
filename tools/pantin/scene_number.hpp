#pragma once
// Numbers of a scene file that are varied from outside, by their place in the file.
#include <cstdint>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"

namespace pantin::program {

/// The text of a scene with a number at a JSON pointer [RFC 6901]. An element of a list may also be
/// given by its name: /bodies/ball/mass. Keys that the file leaves out are added. An error says
/// which part of the pointer does not exist; a list that the file leaves out is not made.
Result<std::string> with_number(std::string_view text, std::string_view pointer, double number);

/// What a new value may take the place of.
enum class Replaced : std::uint8_t { any_value, numbers_only };
/// As with_number(), with any value, given as JSON.
Result<std::string> with_value(std::string_view text, std::string_view pointer,
                               std::string_view words, Replaced what = Replaced::any_value);

/// The same with "POINTER=VALUE": any JSON value; a bare word is a string. The pointer needs no
/// leading slash.
Result<std::string> with_setting(std::string_view text, std::string_view setting);

}  // namespace pantin::program
