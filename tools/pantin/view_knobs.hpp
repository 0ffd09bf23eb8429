#pragma once
// Adjustable values of a running scene: step, gravity, motors, muscles, settings.
#include <string>
#include <vector>

#include "engine/runtime/simulation.hpp"

namespace pantin::program {

using namespace detail;

/// The section of a knob in the panel.
enum class KnobGroup : std::uint8_t { world, motors, solver };

/// A named value. A motor's name is "motor " and the name of its joint.
struct Knob {
  std::string name, unit;
  KnobGroup group = KnobGroup::world;
  double value = 0, low = 0, high = 1;
  bool is_whole = false, is_logarithmic = false;
};

/// The objects that a knob changes.
struct Knobbed {
  World& world;
  StepSettings& how;
  const World& start;  // the scene as read: the reference of "muscles" and "motors"
};

/// The knobs of a World for the panel; of many motors the first few.
std::vector<Knob> knobs_of(const World& world, const StepSettings& how, const World& start);

/// Sets a knob to the nearest valid value. Returns false if there is no such knob.
bool turn_knob(const Knobbed& of, const std::string& name, double value);

}  // namespace pantin::program
