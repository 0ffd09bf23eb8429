#pragma once
/// The position of joints in a scene file, for errors found after it was read.
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"

namespace pantin::detail {

/// An error of a joint, by its name in the World: file, position and JSON pointer of the element
/// that it was built from, then the message. Reads the file again; without a position if the file
/// has changed.
Error error_of_joint(const std::string& path, std::string_view joint, const std::string& message);

}  // namespace pantin::detail
