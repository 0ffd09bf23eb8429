#pragma once
/// A World in a file, from which it goes on with the same bits.
#include <pantin/world.hpp>

#include "engine/runtime/save.hpp"
