#pragma once
/// Scene files. Link pantin::scene.
#include <pantin/world.hpp>

#include "engine/scene/scene.hpp"
