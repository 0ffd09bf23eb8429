// Options of the commands that run scenes.
#include <fmt/format.h>
#include <fmt/ranges.h>  // join, since fmt 11

#include "engine/world/solver_list.hpp"
#include "tools/pantin/command_line.hpp"
#include "tools/pantin/program.hpp"

namespace pantin::program {
namespace {

/// The current name of a solver on the command line; warns of a former one.
std::string solver_of_today(const std::string& word) {
  for (const SolverInfo& s : kSolverInfos)
    if (!s.once.empty() && word == s.once) {
      print_error(fmt::format("warning: --solver: \"{}\" is now called \"{}\"", word, s.name));
      return std::string(s.name);
    }
  return word;
}

}  // namespace

std::vector<std::string> solver_words() {
  std::vector<std::string> words;
  for (const SolverInfo& s : kSolverInfos)
    if (s.scope != SolverScope::laminas) words.emplace_back(s.name);
  return words;
}

std::vector<std::string> jacobian_words() {
  return {std::begin(detail::kJacobianNames), std::end(detail::kJacobianNames)};
}

void add_scene_choices(const Subcommand& command, SceneChoices& choices) {
  command
      .option("--solver", choices.solver,
              fmt::format("{}; for the whole scene", fmt::join(solver_words(), ", ")))
      .one_of(solver_words())
      .read_as(solver_of_today);
  const std::vector<std::string> integrators(std::begin(kIntegratorNames),
                                             std::end(kIntegratorNames));
  command
      .option("--integrator", choices.integrator,
              fmt::format("of lagrangian: {}", fmt::join(integrators, ", ")))
      .one_of(integrators);
  command
      .option("--tolerance", choices.tolerance,
              "of lagrangian with rk4 or radau: error tolerance of a step")
      .between(1e-15, 1.0);
  command
      .option("--stabilisation", choices.stabilisation,
              "of lagrangian: projection, baumgarte or none")
      .one_of({"projection", "baumgarte", "none"});
  command
      .option("--jacobians", choices.jacobians,
              fmt::format("of lagrangian, for surface joints: {}; for comparison",
                          fmt::join(jacobian_words(), ", ")))
      .one_of(jacobian_words());
  command.option("--step", choices.step, "step length in seconds, up to 1").between(1e-6, 1.0);
  command
      .option("--substeps", choices.substeps,
              "number of equal parts that each step is divided into")
      .within(1, 1000);
  command
      .option("--budget", choices.budget_ms,
              "milliseconds in which a step should be computed: beyond it what neither collides "
              "nor hangs on cables waits for up to three steps, and contacts take fewer substeps; "
              "the result depends "
              "on the machine")
      .between(0.0, 1e6);
  command.option("--duration", choices.duration, "simulated seconds").between(1e-6, 1e6);
  command
      .option(
          "--seed", choices.seed,
          "of all that is random in the scene: gusts of wind; each has one of its own from here "
          "on")
      .within(0, 2147483647);
  command.option("--set", choices.set,
                 "POINTER=VALUE: a value of the file, as in --set bodies/ball/mass=2; may be given "
                 "several times");
}

void add_threads(const Subcommand& command, int& threads) {
  command.option("--threads", threads, "threads for independent islands; same result")
      .within(1, 256);
}

}  // namespace pantin::program
