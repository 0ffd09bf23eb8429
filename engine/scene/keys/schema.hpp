#pragma once
/// The JSON Schema (draft 2020-12) of scene files, printed from the tables that the reader goes by.
#include <string>
#include <string_view>

#include "engine/scene/keys/key.hpp"

namespace pantin::detail {

/// The whole, as JSON without line breaks.
std::string scene_schema();

/// A short example of a kind of object, as JSON; empty if there is none.
std::string_view example_of(std::string_view what);

/// What it says of one kind of object.
std::string schema_of(const KeySet& set);

}  // namespace pantin::detail
