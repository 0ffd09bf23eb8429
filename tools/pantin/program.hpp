#pragma once
// What the subcommands of the program share.
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
void add_bench(CommandLine& program);
void add_doctor(CommandLine& program);
void add_view(CommandLine& program);
void add_modes(CommandLine& program);
void add_schema(CommandLine& program);
void add_surface(CommandLine& program);
void add_new(CommandLine& program);
void add_completion(CommandLine& program);
/// The last: it knows all the others.
void add_help(CommandLine& program);

/// The JSON Schema of scene files, laid out to be read.
std::string schema_text();

/// How a scene is to be run, where the command line says so.
struct SceneChoices {
  std::optional<std::string> solver, integrator, stabilisation;
  std::optional<double> step, duration;  // s
  std::optional<double> tolerance;       // of a step
  std::optional<int> substeps;
};
/// --solver, --integrator, --tolerance, --stabilisation, --step, --substeps, --duration, with their
/// bounds.
/// The words of the solvers that a whole scene may be given.
std::vector<std::string> solver_words();
void add_scene_choices(const Subcommand& command, SceneChoices& choices);
/// --threads.
void add_threads(const Subcommand& command, int& threads);

/// Of a step whose status is contact_lost: what happened, at which joint of which body, and, where
/// surfaces fit one another, what to use instead.
std::string words_of_lost_contact(const World& world, const StepReport& report);

/// Reads a scene and applies the choices to it. More steps than kMostSteps are refused too, and
/// joints that contradict one another.
inline constexpr double kMostSteps = 1e7;
Result<Scene> read_scene(const std::string& path, const SceneChoices& choices);
/// The same; complaints go to stderr, a line each.
std::optional<Scene> open_scene(const std::string& path, const SceneChoices& choices);
/// The scene's warnings on stderr, a line each.
void print_warnings(const Scene& scene);

/// "1280x720" to its numbers; false if it is no such thing or beyond 16..8192.
bool parse_size(const std::string& text, int& width, int& height);

/// Whole steps of a duration, at least one.
std::uint64_t steps_of(const Scene& scene);

/// A line on stderr: "pantin: ...".
void complain(const std::string& line);
/// A line on stderr as it is. Both print only what is printable.
void print_error(const std::string& line);
/// Writes a whole file; the exit code, after complaints on stderr.
int write_or_complain(const std::string& path, std::string_view text);
/// JSON on stdout. Nothing in it acts upon a terminal.
void print_json(const Json& json);

/// SIGINT, SIGTERM and SIGHUP set a flag; loops look at it between steps.
void catch_interrupts();
bool interrupted();

/// While one of these lives the program ends at once when it is interrupted: nothing has been
/// written that would have to be finished.
class EndsAtOnce {
 public:
  EndsAtOnce();
  ~EndsAtOnce();
  EndsAtOnce(const EndsAtOnce&) = delete;
  EndsAtOnce& operator=(const EndsAtOnce&) = delete;
};

/// A line that is written over and over on a terminal, and not at all elsewhere.
class Progress {
 public:
  explicit Progress(std::string what);
  ~Progress();
  /// At most ten times a second.
  void show(double part_done);

 private:
  std::string what_;
  bool on_;
  double last_ = -1;
};

/// Printable, and bold if stdout is a terminal and NO_COLOR is not set.
std::string bold(const std::string& text);

/// Whether the solver `planar` moves a body.
bool is_planar(const World& world, std::uint32_t slot);
/// The solvers that move the bodies of a world whose structure is built, and how many bodies each.
std::vector<std::pair<Solver, std::size_t>> solvers_in_use(const World& world);
/// The solver in use, or "mixed".
std::string solver_in_use(const World& world);
/// The same in full: "auto", or "auto (12 bodies) + lagrangian (4 bodies)".
std::string describe_solvers(const World& world);
/// The same as an object: {"auto": 12, "lagrangian": 4}.
Json solvers_json(const World& world);

/// A hash as 16 hexadecimal digits.
std::string hex(std::uint64_t hash);

/// A residual of a pin or string that is farther from its place than the tolerance.
struct Unreached {
  std::string name, kind;
  double residual = 0;  // m
  bool reachable = true;
};
std::vector<Unreached> unreached(const World& world);

/// CPU seconds of all threads of the program so far: what work takes, whatever else the machine
/// does.
double cpu_seconds();

/// Median and higher percentiles of numbers; sorts them.
double percentile(std::vector<double>& numbers, double part);

/// Calls of operator new so far, of the whole program, and the bytes that are in use.
std::uint64_t allocations();
std::uint64_t live_bytes();

}  // namespace pantin::program
