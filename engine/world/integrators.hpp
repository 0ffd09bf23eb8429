#pragma once
/// THE list of the integrators of the Lagrangian solver. A new one is a row here and a file
/// engine/solvers/lagrangian/WORD.cpp, which defines `lagrangian::integrators::WORD`.
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>

#define PANTIN_INTEGRATORS(ROW)                                                             \
  /* semi-implicit, in momenta: one solve, never blows up */                                \
  ROW(euler, .order = 1, .baumgarte_is_part = true)                                         \
  /* symplectic and reversible: energy bounded in long runs */                              \
  ROW(rattle, .order = 2)                                                                   \
  /* Runge-Kutta with projection; of its family the 5(4) pair where a tolerance is asked */ \
  ROW(rk4, .order = 4, .takes_tolerance = true)                                             \
  /* generalised alpha: stiff springs do not limit the step */                              \
  ROW(implicit, .order = 2)                                                                 \
  /* Radau IIA, of its family the method of three stages: as stiff, high order */           \
  ROW(radau, .order = 5, .takes_tolerance = true)

namespace pantin {

#define PANTIN_WORD(word, ...) word,
enum class Integrator : std::uint8_t { PANTIN_INTEGRATORS(PANTIN_WORD) };
#undef PANTIN_WORD

namespace detail {

struct IntegratorInfo {
  std::string_view name;
  int order;
  bool takes_tolerance = false;    // SolverSettings::step_tolerance
  bool baumgarte_is_part = false;  // SolverSettings::baumgarte is a fraction of the gap, not a rate
};

#define PANTIN_INFO(word, ...) {.name = #word, __VA_ARGS__},
inline constexpr IntegratorInfo kIntegrators[] = {PANTIN_INTEGRATORS(PANTIN_INFO)};
#undef PANTIN_INFO

#define PANTIN_NAME(word, ...) #word,
inline constexpr std::string_view kIntegratorNames[] = {PANTIN_INTEGRATORS(PANTIN_NAME)};
#undef PANTIN_NAME

constexpr const IntegratorInfo& info_of(Integrator integrator) {
  return kIntegrators[static_cast<int>(integrator)];
}

/// "rk4 or radau": the integrators with a step tolerance.
inline std::string names_that_take_tolerance() {
  std::string names;
  for (const IntegratorInfo& info : kIntegrators)
    if (info.takes_tolerance) names.append(names.empty() ? "" : " or ").append(info.name);
  return names;
}

}  // namespace detail

constexpr Integrator last_of(Integrator) {
  return static_cast<Integrator>(std::size(detail::kIntegrators) - 1);
}

/// "euler", "rattle", "rk4", "implicit", "radau".
constexpr const char* name_of(Integrator integrator) {
  return detail::info_of(integrator).name.data();
}

/// False for any other word; `integrator` is then unchanged.
constexpr bool integrator_from_name(std::string_view name, Integrator& integrator) {
  for (const detail::IntegratorInfo& info : detail::kIntegrators) {
    if (info.name != name) continue;
    integrator = static_cast<Integrator>(&info - detail::kIntegrators);
    return true;
  }
  return false;
}

}  // namespace pantin
