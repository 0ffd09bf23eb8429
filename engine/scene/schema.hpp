#pragma once
/// The JSON Schema (draft 2020-12) of scene files, printed from the tables that the reader goes by.
#include <string>

#include "engine/scene/key.hpp"

namespace pantin::detail {

/// The whole, as JSON without line breaks.
std::string scene_schema();

/// What it says of one kind of object.
std::string schema_of(const KeySet& set);

}  // namespace pantin::detail
