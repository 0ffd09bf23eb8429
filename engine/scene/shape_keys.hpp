#pragma once
/// What scene files may say of shapes, from the table of kinds.
#include <string>

#include "engine/geometry/shape.hpp"
#include "engine/scene/keys.hpp"

namespace pantin::detail {

/// The keys of a shape of this kind.
const KeySet& keys_of(ShapeKind kind);

/// The definition of the kind in the JSON Schema, as JSON.
std::string schema_of(ShapeKind kind);

}  // namespace pantin::detail
