#pragma once
/// The initial routes of cables over guides.
#include <string>
#include <vector>

#include "engine/joints/cable_path.hpp"
#include "engine/scene/build/build.hpp"

namespace pantin::detail {

/// The points of a cable from a to b, in the scene.
std::vector<PathPoint> route_of(const BuiltScene& built, const BuiltCable& cable);

/// The fault of a route, in words; empty if there is none. Consecutive pulleys must be in one
/// plane, and neighbours of a pulley outside it.
std::string fault_in(const std::vector<PathPoint>& route);

}  // namespace pantin::detail
