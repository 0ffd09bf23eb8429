#pragma once
/// Simulation: a World stepped at a fixed rate, with your own systems within the step.
#include <pantin/world.hpp>

#include "engine/runtime/simulation.hpp"
#include "engine/world/faults.hpp"
#include "engine/world/report.hpp"
