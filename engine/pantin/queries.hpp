#pragma once
/// Geometric queries of a World: ray casts, shape casts, overlaps, closest points, by collision
/// groups.
#include <pantin/world.hpp>

#include "engine/world/queries.hpp"
