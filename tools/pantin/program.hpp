#pragma once
// Declarations shared by the subcommands of the program.
#include <atomic>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/runtime/simulation.hpp"
#include "engine/scene/scene.hpp"
#include "tools/pantin/exit.hpp"

namespace pantin::program {

class CommandLine;
class Subcommand;

using namespace detail;

using Json = nlohmann::ordered_json;

/// Each adds its subcommand to the program.
void add_run(CommandLine& program);
void add_check(CommandLine& program);
void add_assemble(CommandLine& program);
void add_bench(CommandLine& program);
void add_chart(CommandLine& program);
void add_stability(CommandLine& program);
void add_tune(CommandLine& program);
void add_doctor(CommandLine& program);
void add_view(CommandLine& program);
void add_modes(CommandLine& program);
void add_schema(CommandLine& program);
void add_surface(CommandLine& program);
void add_new(CommandLine& program);
void add_completion(CommandLine& program);
/// The last: it lists all the others.
void add_help(CommandLine& program);

/// The JSON Schema of scene files, formatted.
std::string schema_text();

/// Overrides of a scene's run settings by the command line.
struct SceneChoices {
  std::optional<std::string> solver, integrator, stabilisation, jacobians;
  std::optional<double> step, duration;  // s
  std::optional<double> tolerance;       // of a step
  std::optional<int> substeps;
  std::optional<double> budget_ms;
  std::optional<int> seed;       // of gusts of wind
  std::vector<std::string> set;  // POINTER=VALUE, applied to the file in this order
};
/// The words of the solvers that a whole scene may be given.
std::vector<std::string> solver_words();
/// Those of Jacobians, and the one that a word of them names.
std::vector<std::string> jacobian_words();
Jacobians jacobians_named(const std::string& word);
/// Why --jacobians has no effect, or an empty string.
std::string idle_jacobians(const World& world);
/// --solver, --integrator, --tolerance, --stabilisation, --jacobians, --step, --substeps,
/// --budget, --duration, --seed, --set, with their bounds.
void add_scene_choices(const Subcommand& command, SceneChoices& choices);
/// The settings of a scene's steps.
inline StepSettings settings_of(const Scene& scene, int threads) {
  StepSettings how{scene.step, scene.substeps, threads};
  how.budget = 1e-3 * scene.budget_ms;
  return how;
}
/// --threads.
void add_threads(const Subcommand& command, int& threads);

/// Describes a step with status contact_lost: the event, the joint and the body; for conforming
/// surfaces also the alternative.
std::string words_of_lost_contact(const World& world, const StepReport& report);

/// Describes a step with status inconsistent: the joint, and the contact that contradicts it.
std::string words_of_inconsistency(const World& world, const StepReport& report);

/// Reads a scene and applies the choices to it. Errors include more steps than kMostSteps, and
/// joints that contradict one another.
inline constexpr double kMostSteps = 1e7;
Result<Scene> read_scene(const std::string& path, const SceneChoices& choices);
/// Builds the structure of a scene that was just read: warns of what is left out. The errors are
/// joints that contradict one another.
std::vector<Error> settle(const std::string& path, Scene& scene);
/// As read_scene(); errors go to stderr, a line each.
std::optional<Scene> open_scene(const std::string& path, const SceneChoices& choices);
/// The scene's warnings on stderr, a line each.
void print_warnings(const Scene& scene);

/// Parses "1280x720"; returns false if it is invalid or outside 16..8192.
bool parse_size(const std::string& text, int& width, int& height);

/// The number of whole steps in a duration, at least one.
std::uint64_t steps_of(const Scene& scene);

/// Prints "pantin: ..." on stderr.
void complain(const std::string& line);
/// Prints a line on stderr unchanged. Both functions make their text printable.
void print_error(const std::string& line);
/// Writes a whole file; reports errors on stderr and returns the exit code.
int write_or_complain(const std::string& path, std::string_view text);
/// Prints JSON on stdout, without characters that a terminal interprets.
void print_json(const Json& json);

/// SIGINT, SIGTERM and SIGHUP set a flag, which loops check between steps.
void catch_interrupts();
bool interrupted();

/// While an instance exists, an interrupt ends the program at once, because no output needs to be
/// completed.
class EndsAtOnce {
 public:
  EndsAtOnce();
  ~EndsAtOnce();
  EndsAtOnce(const EndsAtOnce&) = delete;
  EndsAtOnce& operator=(const EndsAtOnce&) = delete;
};

/// A progress line, rewritten in place on a terminal; nothing elsewhere.
class Progress {
 public:
  explicit Progress(std::string what);
  ~Progress();
  /// Updates at most ten times a second.
  void show(double part_done);

 private:
  std::string what_;
  bool on_;
  double last_ = -1;
};

/// The text made printable, and bold if stdout is a terminal and NO_COLOR is not set.
std::string bold(const std::string& text);

/// Whether the solver `planar` owns a body.
bool is_planar(const World& world, std::uint32_t slot);
/// The solvers in a World whose structure is built, with the number of bodies of each.
std::vector<std::pair<Solver, std::size_t>> solvers_in_use(const World& world);
/// The solver in use, or "mixed".
std::string solver_in_use(const World& world);
/// The same in full: "auto", or "auto (12 bodies) + lagrangian (4 bodies)".
std::string describe_solvers(const World& world);
/// The same as an object: {"auto": 12, "lagrangian": 4}.
Json solvers_json(const World& world);

/// A hash as 16 hexadecimal digits.
std::string hex(std::uint64_t hash);

/// The residual of a pin or cable that exceeds the tolerance.
struct Unreached {
  std::string name, kind;
  double residual = 0;  // m
  bool reachable = true;
};
std::vector<Unreached> unreached(const World& world);

/// CPU time of all threads of the program so far, s: independent of other load on the machine.
double cpu_seconds();

/// A percentile of numbers, such as the median; sorts them.
double percentile(std::vector<double>& numbers, double part);

/// The build, the machine and its load, for the head of measurements.
Json build_and_machine();

/// Calls of operator new so far in the whole program, and the bytes in use.
std::uint64_t allocations();
std::uint64_t live_bytes();

}  // namespace pantin::program
