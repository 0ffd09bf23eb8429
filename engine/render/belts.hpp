#pragma once
/// Belts as boxes along their way, with marks that run along.
#include <vector>

#include "engine/geometry/shape.hpp"
#include "engine/render/bounds.hpp"
#include "engine/world/belt.hpp"

namespace pantin::detail {

/// A piece of a belt where it stands; a mark has no material of its own.
struct BeltPiece {
  Shape box;
  Pose pose;
  bool is_mark = false;
};

/// Appends the pieces of a belt; nothing if a body of it is gone.
void add_belt(const PosedWorld& scene, const Belt& belt, std::vector<BeltPiece>& to);

}  // namespace pantin::detail
