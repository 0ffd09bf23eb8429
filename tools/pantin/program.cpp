#include "tools/pantin/program.hpp"

#include <fmt/format.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "engine/solvers/articulated/island.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::program {
namespace {

volatile std::sig_atomic_t g_interrupted = 0;  // a signal handler can reach nothing else

/// The solver settings that the command line asks for.
SolverChoices solver_choices(const SceneChoices& c) {
  SolverChoices choices;
  if (c.solver) solver_from_name(c.solver->c_str(), choices.solver.emplace());
  if (c.integrator) integrator_from_name(c.integrator->c_str(), choices.integrator.emplace());
  if (c.stabilisation)
    choices.stabilisation = *c.stabilisation == "projection"  ? Stabilisation::projection
                            : *c.stabilisation == "baumgarte" ? Stabilisation::baumgarte
                                                              : Stabilisation::none;
  choices.step_tolerance = c.tolerance;
  return choices;
}

/// Why an option cannot do what it is for, or nothing.
std::string idle_option(const SceneChoices& c, const World& world) {
  const char* option = c.integrator      ? "--integrator"
                       : c.tolerance     ? "--tolerance"
                       : c.stabilisation ? "--stabilisation"
                                         : nullptr;
  if (!option) return {};
  const SolverSettings* odd = nullptr;  // takes no tolerance
  bool any = false;
  const auto look = [&](const SolverSettings& s) {
    if (s.solver != Solver::lagrangian) return;
    any = true;
    if (!info_of(s.integrator).takes_tolerance) odd = &s;
  };
  look(world.default_settings);
  for (const SolverSettings& s : world.settings.values()) look(s);
  if (!any)
    return fmt::format("found {}, expected a scene that the solver \"lagrangian\" moves; add "
                       "--solver lagrangian",
                       option);
  if (c.tolerance && odd)
    return fmt::format("found --tolerance with the integrator \"{}\", expected it with \"{}\" "
                       "only: no other divides steps",
                       name_of(odd->integrator), name_of(kTakesTolerance));
  return {};
}

double now() {
  using Clock = std::chrono::steady_clock;
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

}  // namespace

CLI::Validator between(double least, double most) {
  return CLI::Validator(
      [least, most](std::string& text) {
        double x = 0;
        const char* end = text.data() + text.size();
        const auto read = std::from_chars(text.data(), end, x);
        // A comparison that holds, so that no NaN passes.
        if (read.ec == std::errc() && read.ptr == end && x >= least && x <= most)
          return std::string();
        return fmt::format("found \"{}\", expected a number from {} to {}", text, least, most);
      },
      fmt::format("in [{} - {}]", least, most));
}

void add_scene_choices(CLI::App& command, SceneChoices& choices) {
  command
      .add_option("--solver", choices.solver,
                  "auto, sweep, shake2, paper or lagrangian; for the whole scene")
      ->check(CLI::IsMember({"auto", "sweep", "shake2", "paper", "lagrangian"}));
  const std::vector<std::string> integrators(std::begin(kIntegratorNames),
                                             std::end(kIntegratorNames));
  command
      .add_option("--integrator", choices.integrator,
                  fmt::format("of lagrangian: {}", fmt::join(integrators, ", ")))
      ->check(CLI::IsMember(integrators));
  command
      .add_option("--tolerance", choices.tolerance,
                  "of lagrangian with rk4: divide steps so that each errs by less")
      ->check(between(1e-15, 1.0));
  command
      .add_option("--stabilisation", choices.stabilisation,
                  "of lagrangian: projection, baumgarte or none")
      ->check(CLI::IsMember({"projection", "baumgarte", "none"}));
  command.add_option("--step", choices.step, "step length in seconds, up to 1")
      ->check(between(1e-6, 1.0));
  command.add_option("--substeps", choices.substeps, "equal parts each step is taken in")
      ->check(CLI::Range(1, 1000));
  command.add_option("--duration", choices.duration, "simulated seconds")
      ->check(between(1e-6, 1e6));
}

void add_threads(CLI::App& command, int& threads) {
  command.add_option("--threads", threads, "threads for independent articulations; same result")
      ->check(CLI::Range(1, 256));
}

namespace {

/// Whether joints of a mechanism cannot be closed together; told by their names. Joints that stand at
/// a mirrored root are a warning.
bool refuse_contradictions(const std::string& path, Scene& scene) {
  bool any = false;
  for (std::size_t i = 0; i < lagrangian::islands_of(scene.world).size(); ++i) {
    std::string names;
    double lack = 0;
    for (const lagrangian::Fault& f : lagrangian::inspect(scene.world, i)) {
      const Entity joint = lagrangian::joint_of(scene.world, lagrangian::islands_of(scene.world)[i].blocks[f.block]);
      if (f.kind == lagrangian::Fault::wrong_branch)
        scene.warnings.push_back(fmt::format("{}: joint {} starts with its axes opposed, where it "
                                             "can stand but should not", path,
                                             scene.world.name_of(joint)));
      if (f.kind != lagrangian::Fault::inconsistent) continue;
      names += (names.empty() ? "" : ", ") + scene.world.name_of(joint);
      lack = std::max(lack, f.residual);
    }
    if (names.empty()) continue;
    std::fprintf(stderr, "%s: found joints that contradict one another: %s stay open by up to %.3g (m or "
                 "rad), expected joints that can all be closed\n", path.c_str(), names.c_str(), lack);
    any = true;
  }
  return any;
}

}  // namespace

std::optional<Scene> open_scene(const std::string& path, const SceneChoices& choices, bool quiet) {
  Result<Scene> loaded = load_scene(path, {}, solver_choices(choices));
  if (!loaded) {
    for (const Error& e : loaded.errors()) std::fprintf(stderr, "%s\n", e.message.c_str());
    return std::nullopt;
  }
  Scene& scene = *loaded;
  if (choices.step) scene.step = *choices.step;
  if (choices.substeps) scene.substeps = *choices.substeps;
  if (choices.duration) scene.duration = *choices.duration;
  if (scene.duration / scene.step > kMostSteps) {
    std::fprintf(stderr, "%s: found %.6g steps of %.6g s, expected at most %g\n", path.c_str(),
                 scene.duration / scene.step, scene.step, kMostSteps);
    return std::nullopt;
  }
  if (const std::string why = idle_option(choices, scene.world); !why.empty()) {
    std::fprintf(stderr, "%s: %s\n", path.c_str(), why.c_str());
    return std::nullopt;
  }
  compile_if_changed(scene.world);
  for (const StructureFault& f : partition_of(scene.world).faults)
    scene.warnings.push_back(
        fmt::format("{}: {} {}; it is left out", path, scene.world.name_of(f.link), f.reason));
  if (refuse_contradictions(path, scene)) return std::nullopt;
  if (!quiet)
    for (const std::string& line : scene.warnings)
      std::fprintf(stderr, "warning: %s\n", line.c_str());
  return std::move(*loaded);
}

bool parse_size(const std::string& text, int& width, int& height) {
  const char* end = text.data() + text.size();
  const auto w = std::from_chars(text.data(), end, width);
  if (w.ec != std::errc() || w.ptr == end || *w.ptr != 'x') return false;
  const auto h = std::from_chars(w.ptr + 1, end, height);
  if (h.ec != std::errc() || h.ptr != end) return false;
  return width >= 16 && height >= 16 && width <= 8192 && height <= 8192;
}

std::uint64_t steps_of(const Scene& scene) {
  return static_cast<std::uint64_t>(std::max(1.0, std::round(scene.duration / scene.step)));
}

void complain(const std::string& line) { std::fprintf(stderr, "pantin: %s\n", line.c_str()); }

void catch_interrupts() {
  struct sigaction action = {};
  action.sa_handler = [](int) {
    if (g_interrupted) _exit(kInterrupted);  // asked twice: at once
    g_interrupted = 1;
  };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGHUP, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

bool interrupted() { return g_interrupted != 0; }

Progress::Progress(std::string what) : what_(std::move(what)), on_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (on_ && last_ >= 0) std::fputs("\r\033[K", stderr);
}

void Progress::show(double part_done) {
  if (!on_ || (last_ >= 0 && now() - last_ < 0.1)) return;
  last_ = now();
  std::fprintf(stderr, "\r%s %3.0f %%\033[K", what_.c_str(), 100 * part_done);
  std::fflush(stderr);
}

std::string bold(const std::string& text) {
  static const bool kPlain = isatty(STDOUT_FILENO) != 1 || std::getenv("NO_COLOR");
  return kPlain ? text : "\033[1m" + text + "\033[0m";
}

std::string solver_in_use(const World& world) {
  if (articulated::islands_of(world).empty()) return pantin::name_of(world.default_settings.solver);
  const Solver first = articulated::islands_of(world).front().settings.solver;
  for (const articulated::Island& a : articulated::islands_of(world))
    if (a.settings.solver != first) return "mixed";
  return pantin::name_of(first);
}

std::string hex(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

std::vector<Unreached> unreached(const World& world) {
  std::vector<Unreached> found;
  for (const articulated::Island& a : articulated::islands_of(world)) {
    const Real bound = a.settings.tolerance * a.size;
    for (const articulated::Hold& h : a.holds) {
      if (h.compliance > 0 || !(h.residual > bound)) continue;
      const Entity who = h.held_pin != UINT32_MAX ? world.pins.owners()[h.held_pin]
                                                  : world.links.owners()[h.held_link];
      found.push_back({world.name_of(who), h.held_pin != UINT32_MAX ? "pin" : "joint", h.residual,
                       h.reachable});
    }
    for (const articulated::Cord& c : a.cords) {
      const String& s = world.strings.values()[c.string];
      const Real far = stretch(s.joint, world.bodies[s.a].pose, world.bodies[s.b].pose);
      if (s.joint.compliance == 0 && far > bound)
        found.push_back({world.name_of(world.strings.owners()[c.string]), "string", far, true});
    }
  }
  return found;
}

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double percentile(std::vector<double>& numbers, double part) {
  if (numbers.empty()) return 0;
  std::sort(numbers.begin(), numbers.end());
  const double at = part * static_cast<double>(numbers.size() - 1);
  return numbers[static_cast<std::size_t>(std::lround(at))];
}

}  // namespace pantin::program
