#pragma once
/// Draws belts as boxes along their route, with marks that move along.
#include <vector>

#include "engine/geometry/shape.hpp"
#include "engine/render/bounds.hpp"
#include "engine/world/belt.hpp"

namespace pantin::detail {

/// A segment of a belt at its pose; a mark has no material of its own.
struct BeltPiece {
  Shape box;
  Pose pose;
  bool is_mark = false;
};

/// Appends the segments of a belt; nothing if one of its bodies is gone.
void add_belt(const PosedWorld& scene, const Belt& belt, std::vector<BeltPiece>& to);

}  // namespace pantin::detail
