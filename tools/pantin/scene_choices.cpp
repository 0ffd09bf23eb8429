// The options of commands that run scenes.
#include <fmt/format.h>
#include <fmt/ranges.h>  // join, since fmt 11

#include "tools/pantin/command_line.hpp"
#include "tools/pantin/program.hpp"

namespace pantin::program {
namespace {

/// The solver's name today for a word of the command line; warns of an old one.
std::string solver_of_today(const std::string& word) {
  if (word != "paper") return word;
  print_error("warning: --solver: \"paper\" is called \"procedural\" today");
  return "procedural";
}

}  // namespace

void add_scene_choices(const Subcommand& command, SceneChoices& choices) {
  command
      .option("--solver", choices.solver,
              "auto, sweep, shake2, procedural, lagrangian or planar; for the whole scene")
      .one_of({"auto", "sweep", "shake2", "procedural", "lagrangian", "planar"})
      .read_as(solver_of_today);
  const std::vector<std::string> integrators(std::begin(kIntegratorNames),
                                             std::end(kIntegratorNames));
  command
      .option("--integrator", choices.integrator,
              fmt::format("of lagrangian: {}", fmt::join(integrators, ", ")))
      .one_of(integrators);
  command
      .option("--tolerance", choices.tolerance,
              "of lagrangian with rk4 or radau: divide steps so that each errs by less")
      .between(1e-15, 1.0);
  command
      .option("--stabilisation", choices.stabilisation,
              "of lagrangian: projection, baumgarte or none")
      .one_of({"projection", "baumgarte", "none"});
  command.option("--step", choices.step, "step length in seconds, up to 1").between(1e-6, 1.0);
  command.option("--substeps", choices.substeps, "equal parts each step is taken in")
      .within(1, 1000);
  command.option("--duration", choices.duration, "simulated seconds").between(1e-6, 1e6);
}

void add_threads(const Subcommand& command, int& threads) {
  command.option("--threads", threads, "threads for independent islands; same result")
      .within(1, 256);
}

}  // namespace pantin::program
