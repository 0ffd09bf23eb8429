#pragma once
/// Cables over guides, as they run at the start.
#include <string>
#include <vector>

#include "engine/joints/cable_path.hpp"
#include "engine/scene/build/build.hpp"

namespace pantin::detail {

/// The places from a to b, in the scene.
std::vector<PathPoint> route_of(const BuiltScene& built, const BuiltCable& cable);

/// What is wrong with a route, in words; empty if nothing is. Pulleys next to one another must lie
/// in one plane, and places next to a pulley outside of it.
std::string fault_in(const std::vector<PathPoint>& route);

}  // namespace pantin::detail
