#pragma once
// Adjustable values of a running scene: step, gravity, motors, muscles, settings.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/joints/kind.hpp"
#include "engine/runtime/simulation.hpp"

namespace pantin::program {

using namespace detail;

/// The section of a knob in the panel.
enum class KnobGroup : std::uint8_t { world, motors, solver };

/// A named value. Those of joints are "motor NAME" (its target), "stiffness NAME" and "damping
/// NAME" (of its spring), "least NAME" and "most NAME" (of its limits). Of a joint that rotates and
/// translates freely, NAME is followed by the coordinate: "motor NAME.angle", "motor NAME.travel".
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

/// What a knob of a joint stands for.
enum class JointValue : std::uint8_t { motor, stiffness, damping, least, most };
struct JointKnob {
  JointValue value = JointValue::motor;
  std::string joint;                     // its name
  Entity entity;                         // in the World that was asked
  Coordinate along = Coordinate::angle;  // or travel
  bool is_named = false;                 // the knob's name has the coordinate
};
/// The joint and the value that a knob's name refers to; none if there is no such joint.
std::optional<JointKnob> joint_knob(const World& world, std::string_view name);
/// Sets it to the nearest valid value. Returns false if the joint has no such law.
bool turn_joint_knob(World& world, const JointKnob& knob, double value);
/// The knobs of motors, springs and limits, of the first joints that have some.
void add_joint_knobs(const World& world, const World& start, std::vector<Knob>& to);

/// The knobs of a World for the panel; of many motors the first few.
std::vector<Knob> knobs_of(const World& world, const StepSettings& how, const World& start);

/// Sets a knob to the nearest valid value. Returns false if there is no such knob.
bool turn_knob(const Knobbed& of, const std::string& name, double value);

}  // namespace pantin::program
