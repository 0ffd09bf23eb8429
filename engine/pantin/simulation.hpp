#pragma once
/// Simulation: a World that is stepped at a fixed rate, and your own systems within the step.
#include <pantin/world.hpp>

#include "engine/runtime/simulation.hpp"
#include "engine/world/faults.hpp"
#include "engine/world/report.hpp"
