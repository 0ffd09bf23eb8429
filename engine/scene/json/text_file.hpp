#pragma once
/// Reads the whole text of a file.
#include <cstddef>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"

namespace pantin::detail {

/// Reads at most `most` bytes; on failure a one-line error that says that `what` was expected.
Result<std::string> read_text(const std::string& path, std::size_t most, std::string_view what);

/// "name: found more than 10 bytes, expected a scene file".
std::string too_long(std::string_view name, std::size_t most, std::string_view what);

}  // namespace pantin::detail
