// Keys of solver settings.
#include <algorithm>
#include <array>
#include <string_view>

#include "engine/scene/read/read.hpp"
#include "engine/world/solver_list.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using S = SolverSettings;

constexpr auto kOldSolvers = [] {
  std::array<std::string_view, kSolverInfos.size()> words{};
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = kSolverInfos[i].once;
  return words;
}();

/// "auto: dynamics, stable at any step. sweep: ..."
constexpr auto kAbouts = [] {
  constexpr std::size_t size = [] {
    std::size_t all = 0;
    for (const SolverInfo& s : kSolverInfos) all += s.name.size() + s.about.size() + 3;
    return all - 1;
  }();
  std::array<char, size> text{};
  auto at = text.begin();
  for (const SolverInfo& s : kSolverInfos)
    for (const std::string_view piece :
         {s.solver == Solver{} ? std::string_view{} : std::string_view{" "}, s.name,
          std::string_view{": "}, s.about})
      at = std::copy(piece.begin(), piece.end(), at);
  return text;
}();

constexpr std::string_view kStabilisations[] = {"projection", "baumgarte", "none"};
constexpr std::string_view kReluctances[] = {"inertia_over_mass", "literal_step"};

constexpr Key kSolver[] = {
    word<&S::solver>("type", kSolverNames, std::string_view(kAbouts.data(), kAbouts.size()))
        .once_words(kOldSolvers),
    number<&S::rotation_stiffness>("rotation_stiffness", "", kNotNegative,
                                   "Of sweep: 0 rotates, large values translate.")
        .once("turn_stiffness"),
    number<&S::sleep_speed>(
        "sleep_speed", "m/s", kNotNegative,
        "A body at rest on fixed bodies that moves no faster for half a second falls asleep; a "
        "heap of jointed bodies does once no body but a swaying arm has moved away for a second "
        "(by more than 2.5 s times this, an arm by 40 s times this; among four or more, "
        "those on one another may sway three times as far, and are slowed); 0: never.")
        .once("rest_speed"),
    whole<&S::sweeps>("sweeps", 1, 10'000,
                      "Maximum number of relaxation sweeps over several pinned points.")
        .once("rounds"),
    number<&S::tolerance>(
        "tolerance", "", kPositive,
        "Tolerance on the residual of a pinned point, as a fraction of the island's size."),
    number<&S::stall_drop>("stall_drop", "", kUnit,
                           "Minimum relative gain of a sweep; below it the sweeps end."),
    flag<&S::limiter>("limiter",
                      "Of auto, where it falls back on sweeps: prevents them from adding energy; "
                      "off only for demonstration."),
    word<&S::procedural_reluctance>("procedural_reluctance", kReluctances,
                                    "Of procedural: which length^2 h the rule takes.")
        .once("paper_reluctance"),
    word<&S::integrator>("integrator", kIntegratorNames,
                         "Of lagrangian. euler: order 1, most robust. rattle: symplectic, order 2, "
                         "energy bounded in long runs. rk4: Runge-Kutta, order 4. implicit: order "
                         "2, stiff springs do not limit the step. radau: order 5, likewise."),
    word<&S::stabilisation>("stabilisation", kStabilisations,
                            "Of lagrangian: correction of constraint drift. projection: back onto "
                            "the constraints after every step. The others are for comparison."),
    word<&S::jacobians>("jacobians", kJacobianNames,
                        "Of lagrangian and of assembly: derivatives of surface joints. analytic: "
                        "closed forms. The others are for comparison. differences: central "
                        "differences, extrapolated once. squared_distance: the same of the squared "
                        "distance, whose gradient vanishes where surfaces touch."),
    number<&S::baumgarte>(
        "baumgarte", "", kNotNegative,
        "Of lagrangian, with that stabilisation. euler: fraction of a gap closed in a step, at "
        "most 1; 0 stands for 0.2. Otherwise a rate, 1/s; 0 stands for 5."),
    number<&S::step_tolerance>(
        "step_tolerance", "", kPositive,
        "Of lagrangian with rk4 or radau: error tolerance of a step, in m, rad, m/s and rad/s; "
        "steps are subdivided to meet it. Default: not subdivided."),
    number<&S::damping_ratio>(
        "damping_ratio", "", kUnit,
        "Of lagrangian with implicit: fraction of the fastest vibrations left after a step."),
};

}  // namespace

constinit const KeySet keys::solver{
    .what = "solver",
    .about = "Solver settings.",
    .keys = kSolver,
    .retired = "calm_angle_deg reservoir_time active_set_iterations passes tension_stiffness"};

bool read_members(const Reading& reading, const Reader& from, SolverSettings& s) {
  read_rows(reading, from, s);
  const IntegratorInfo& integrator = info_of(s.integrator);
  const std::string name(integrator.name);
  if (from.has("baumgarte") && integrator.baumgarte_is_part && s.baumgarte > 1)
    from.error_value("baumgarte", "a number from 0 to 1: with \"" + name +
                                      "\" it is the fraction of a gap closed in a step");
  if (integrator.takes_tolerance) return true;
  if (from.has("step_tolerance"))
    from.error_at_key("step_tolerance", "found \"step_tolerance\" with the integrator \"" + name +
                                            "\", expected it with " + names_that_take_tolerance() +
                                            " only: no other subdivides steps");
  s.step_tolerance = 0;  // not inherited from the enclosing settings
  return true;
}

/// Missing values are those of the scene's settings.
bool read_value(const RowValue& row, std::optional<SolverSettings>& to) {
  if (!row.is_there()) return true;
  to = row.reading.solver;
  return read_value(row, *to);
}

}  // namespace pantin::detail
