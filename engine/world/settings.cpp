#include "engine/world/settings.hpp"

#include <array>
#include <string_view>
#include <utility>

namespace pantin {

using namespace detail;

namespace {

constexpr std::array<std::pair<Solver, const char*>, 7> kNames{
    {{Solver::articulated, "auto"},
     {Solver::sweep, "sweep"},
     {Solver::shake2, "shake2"},
     {Solver::procedural, "procedural"},
     {Solver::lagrangian, "lagrangian"},
     {Solver::planar, "planar"},
     {Solver::quasistatic, "quasistatic"}}};

// The bounds of the scene keys: a larger count is as good as endless.
constexpr int kMostSweeps = 10'000;

}  // namespace

const char* name_of(Solver solver) {
  for (const auto& [value, name] : kNames)
    if (value == solver) return name;
  return "?";
}

bool solver_from_name(const char* name, Solver& solver) {
  if (!name) return false;
  for (const auto& [value, known] : kNames)
    if (std::string_view(name) == known) {
      solver = value;
      return true;
    }
  return false;
}

const char* detail::settings_fault(const SolverSettings& s) {
  if (s.sweeps < 1 || s.sweeps > kMostSweeps)
    return "has solver settings whose sweeps are not from 1 to 10000";
  if (!(s.damping_ratio >= 0 && s.damping_ratio <= 1))
    return "has solver settings with a damping ratio that is not from 0 to 1";
  for (const Real v : {s.rotation_stiffness, s.sleep_speed, s.tolerance, s.stall_drop, s.baumgarte,
                       s.step_tolerance})
    if (!(v >= 0)) return "has solver settings with a number that is not at least 0";
  return nullptr;
}

}  // namespace pantin
