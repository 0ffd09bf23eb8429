#pragma once
// Poses of a scene written into its file.
#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

/// The text of a scene file with the poses of a World as its "poses": of bodies that are not where
/// `start` has them, or whose pose the file gives there already. Comments and all other keys stay.
Result<std::string> with_poses(std::string_view text, const World& start, const World& world);

}  // namespace pantin::program
