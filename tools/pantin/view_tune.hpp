#pragma once
// Values that were changed in the window, written back into the scene file.
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

/// A scene's text with changed knobs. Of joints of prefabs, chains and classes the source of the
/// value changes, so that others have it, too.
struct TunedText {
  std::string text;
  std::vector<std::string> shared;  // knobs with what else has their values now
  std::vector<std::string> left;    // knobs that have no place in the file, and why
};

/// `turned` holds names and values of knobs; `start` is the scene as read. Values are written in
/// the units and under the keys of the file.
TunedText with_knobs(std::string_view text,
                     const std::vector<std::pair<std::string, double>>& turned, const World& start);

}  // namespace pantin::program
