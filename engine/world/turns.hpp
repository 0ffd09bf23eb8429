#pragma once
/// Whole turns that solvers have counted, on the way from one build to the next: from solver to
/// solver, and past a step that was aborted.
#include <span>
#include <vector>

#include "engine/joints/rows.hpp"
#include "engine/world/entity.hpp"

namespace pantin::detail {

/// A coordinate of a joint that has counted its turns.
struct TurnCount {
  Entity joint;
  Coordinate coordinate = Coordinate::angle;
  Real value = 0;  // rad
};
using TurnCounts = std::vector<TurnCount>;

/// Sorts them for the next function; of several of one coordinate the first is kept.
void sort(TurnCounts& counts);
/// rad; null where nothing was counted.
const Real* find_count(std::span<const TurnCount> counts, Entity joint, Coordinate coordinate);

}  // namespace pantin::detail
