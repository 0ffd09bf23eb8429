#pragma once
/// Saves a World to a file; a loaded World continues bit for bit.
#include <pantin/world.hpp>

#include "engine/runtime/save.hpp"
