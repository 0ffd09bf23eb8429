#pragma once
/// Questions to a World: rays, sliding shapes, overlaps, nearest points, by collision groups.
#include <pantin/world.hpp>

#include "engine/world/queries.hpp"
