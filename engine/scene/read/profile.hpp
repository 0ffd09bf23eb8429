#pragma once
/// Outlines of machine parts in files.
#include <optional>

#include "engine/nurbs/spline.hpp"
#include "engine/scene/read/reader.hpp"
#include "engine/scene/read/surface_words.hpp"

namespace pantin::detail {

/// A curve of one of the types from `gear` on; nothing after an error, which has been reported.
std::optional<nurbs::Curve> read_profile(CurveType type, const Reader& from);

}  // namespace pantin::detail
