#pragma once
/// Off-screen pictures, PNG files, video. Link pantin::render.
#include <pantin/world.hpp>

#include "engine/render/capture.hpp"
#include "engine/render/renderer.hpp"
#include "engine/render/strip.hpp"
