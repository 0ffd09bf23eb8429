#include "tools/pantin/view_knobs.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace pantin::program {

using namespace detail;

namespace {

/// An entry of SolverSettings.
struct SettingRow {
  const char *name, *unit;
  double low, high;
  Real SolverSettings::*real;
  int SolverSettings::*whole;
};
constexpr SettingRow kSettings[]{
    {"sweeps", "", 1, 64, nullptr, &SolverSettings::sweeps},
    {"rotation_stiffness", "", 0, 10, &SolverSettings::rotation_stiffness, nullptr},
    {"sleep_speed", "m/s", 0, 0.1, &SolverSettings::sleep_speed, nullptr},
    {"damping_ratio", "", 0, 1, &SolverSettings::damping_ratio, nullptr},
};

Real strength(Vec3 gravity) { return glm::length(gravity); }

/// The direction of gravity for positive values of the knob.
Vec3 way_down(const World& start) {
  const Real g = strength(start.gravity);
  return g > 0 ? start.gravity / g : Vec3(0, -1, 0);
}

/// The present strength of the drives relative to the initial one.
double muscles_now(const World& world, const World& start) {
  for (std::size_t i = 0; i < start.joint_drives.size(); ++i) {
    const JointDrive& was = start.joint_drives.values()[i];
    const JointDrive* is = world.joint_drives.find(start.joint_drives.owners()[i]);
    if (is && was.stiffness > 0) return is->stiffness / was.stiffness;
  }
  return 1;
}

void scale_muscles(const Knobbed& of, double by) {
  for (std::size_t i = 0; i < of.start.joint_drives.size(); ++i) {
    const JointDrive& was = of.start.joint_drives.values()[i];
    JointDrive* is = of.world.joint_drives.find(of.start.joint_drives.owners()[i]);
    if (!is || is->exact) continue;
    is->stiffness = by * was.stiffness, is->damping = by * was.damping;
    is->max_torque = was.max_torque < 1e100 ? by * was.max_torque : was.max_torque;
  }
}

bool turn_setting(const Knobbed& of, const std::string& name, double value) {
  for (const SettingRow& row : kSettings) {
    if (name != row.name) continue;
    const double at = std::clamp(value, row.low, row.high);
    const auto set = [&](SolverSettings& s) {
      if (row.real)
        s.*row.real = at;
      else
        s.*row.whole = static_cast<int>(std::lround(at));
    };
    set(of.world.default_settings);
    for (SolverSettings& s : of.world.settings.values()) set(s);
    return true;
  }
  return false;
}

bool turn_clock(StepSettings& how, const std::string& name, double value) {
  if (name == "step") {
    how.h = 1e-3 * std::clamp(value, 0.1, 100.0);
    return true;
  }
  if (name != "substeps") return false;
  how.substeps = static_cast<int>(std::lround(std::clamp(value, 1.0, 64.0)));
  return true;
}

bool turn_world(const Knobbed& of, const std::string& name, double value) {
  if (name == "gravity")
    of.world.gravity = std::clamp(value, -30.0, 30.0) * way_down(of.start);
  else if (name == "muscles")
    scale_muscles(of, std::clamp(value, 0.0, 10.0));
  else if (const auto knob = joint_knob(of.world, name))
    return turn_joint_knob(of.world, *knob, value);
  else
    return turn_setting(of, name, value);
  return true;
}

}  // namespace

std::vector<Knob> knobs_of(const World& world, const StepSettings& how, const World& start) {
  std::vector<Knob> knobs;
  knobs.push_back({"step", "ms", KnobGroup::world, 1e3 * how.h, 0.1, 100, false, true});
  knobs.push_back(
      {"substeps", "", KnobGroup::world, static_cast<double>(how.substeps), 1, 64, true});
  knobs.push_back(
      {"gravity", "m/s2", KnobGroup::world, glm::dot(world.gravity, way_down(start)), -30, 30});
  const auto is_spring = [](const JointDrive& drive) { return !drive.exact; };
  if (std::any_of(start.joint_drives.values().begin(), start.joint_drives.values().end(),
                  is_spring))
    knobs.push_back({"muscles", "x", KnobGroup::motors, muscles_now(world, start), 0, 10});
  add_joint_knobs(world, start, knobs);
  for (const SettingRow& row : kSettings) {
    const SolverSettings& s =
        world.settings.empty() ? world.default_settings : world.settings.values().front();
    const double value = row.real ? s.*row.real : s.*row.whole;
    knobs.push_back(
        {row.name, row.unit, KnobGroup::solver, value, row.low, row.high, row.whole != nullptr});
  }
  return knobs;
}

bool turn_knob(const Knobbed& of, const std::string& name, double value) {
  if (!std::isfinite(value)) return false;
  if (turn_clock(of.how, name, value)) return true;
  if (!turn_world(of, name, value)) return false;
  of.world.mark_dirty();  // wakes what sleeps
  return true;
}

}  // namespace pantin::program
