#include "engine/world/settings.hpp"

#include <string_view>

#include "engine/world/solver_list.hpp"

namespace pantin {

using namespace detail;

namespace {

// The bounds of the scene keys. Larger counts would hardly be distinguishable from infinite ones.
constexpr int kMostSweeps = 10'000;

}  // namespace

const char* name_of(Solver solver) { return info_of(solver).name.data(); }

bool solver_from_name(const char* name, Solver& solver) {
  if (!name) return false;
  for (const SolverInfo& known : kSolverInfos)
    if (known.name == name) {
      solver = known.solver;
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
