#pragma once
// The numbers of a running scene that may be turned: step, gravity, motors, muscles, settings.
#include <string>
#include <vector>

#include "engine/runtime/simulation.hpp"

namespace pantin::program {

using namespace detail;

/// Where a knob stands in the panel.
enum class KnobGroup : std::uint8_t { world, motors, solver };

/// A number by its name. Motors are called "motor " and the name of their joint.
struct Knob {
  std::string name, unit;
  KnobGroup group = KnobGroup::world;
  double value = 0, low = 0, high = 1;
  bool is_whole = false, is_logarithmic = false;
};

/// What is set by a knob.
struct Knobbed {
  World& world;
  StepSettings& how;
  const World& start;  // the scene as it was read: "muscles" and "motors" are multiples of it
};

/// The knobs of a World, for the panel: of many motors the first few.
std::vector<Knob> knobs_of(const World& world, const StepSettings& how, const World& start);

/// Sets a knob to the nearest number that it takes. False if there is no such knob.
bool turn_knob(const Knobbed& of, const std::string& name, double value);

}  // namespace pantin::program
