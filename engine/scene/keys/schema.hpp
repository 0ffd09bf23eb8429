#pragma once
/// The JSON Schema (draft 2020-12) of scene files, generated from the tables of the reader.
#include <string>
#include <string_view>

#include "engine/scene/keys/key.hpp"

namespace pantin::detail {

/// The whole schema, as JSON without line breaks.
std::string scene_schema();

/// A short example of a kind of object, as JSON; empty if there is none.
std::string_view example_of(std::string_view what);

/// The schema of one kind of object.
std::string schema_of(const KeySet& set);

}  // namespace pantin::detail
