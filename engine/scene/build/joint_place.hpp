#pragma once
/// Where the joints of a scene file are written, for what is found out after it was read.
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"

namespace pantin::detail {

/// The line that tells of an error of a joint, by its name in the World: file, place and JSON
/// pointer of what it is made from, then the message. Reads the file again. Without a place if the
/// file is another by now.
Error error_of_joint(const std::string& path, std::string_view joint, const std::string& message);

}  // namespace pantin::detail
