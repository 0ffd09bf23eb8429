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
#include <nlohmann/json.hpp>

#include "engine/base/atomic_file.hpp"
#include "engine/base/utf8.hpp"
#include "engine/scene/build/joint_place.hpp"
#include "engine/scene/json/text_file.hpp"
#include "engine/solvers/articulated/island.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/timed_event.hpp"
#include "tools/pantin/repeated_wheels.hpp"
#include "tools/pantin/scene_number.hpp"

namespace pantin::program {

using namespace detail;

namespace {

// Global, because a signal handler can access nothing else.
volatile std::sig_atomic_t g_interrupted = 0, g_at_once = 0;

/// The solver settings given on the command line.
SolverChoices solver_choices(const SceneChoices& c) {
  SolverChoices choices;
  if (c.solver) solver_from_name(c.solver->c_str(), choices.solver.emplace());
  if (c.integrator) integrator_from_name(c.integrator->c_str(), choices.integrator.emplace());
  if (c.stabilisation)
    choices.stabilisation = *c.stabilisation == "projection"  ? Stabilisation::projection
                            : *c.stabilisation == "baumgarte" ? Stabilisation::baumgarte
                                                              : Stabilisation::none;
  if (c.jacobians) choices.jacobians = jacobians_named(*c.jacobians);
  choices.step_tolerance = c.tolerance;
  return choices;
}

/// Why an option has no effect, or an empty string.
std::string idle_option(const SceneChoices& c, const World& world) {
  const char* option = c.integrator      ? "--integrator"
                       : c.tolerance     ? "--tolerance"
                       : c.stabilisation ? "--stabilisation"
                       : c.jacobians     ? "--jacobians"
                                         : nullptr;
  if (!option) return {};
  const SolverSettings* odd = nullptr;  // supports no tolerance
  bool any = false;
  const auto look = [&](const SolverSettings& s) {
    if (s.solver != Solver::lagrangian) return;
    any = true;
    if (!info_of(s.integrator).takes_tolerance) odd = &s;
  };
  look(world.default_settings);
  for (const SolverSettings& s : world.settings.values()) look(s);
  if (!any)
    return fmt::format(
        "found {}, expected a scene solved by \"lagrangian\"; add --solver lagrangian", option);
  if (c.tolerance && odd)
    return fmt::format(
        "found --tolerance with the integrator \"{}\", expected it with {} only: no other "
        "subdivides steps",
        name_of(odd->integrator), names_that_take_tolerance());
  return c.jacobians ? idle_jacobians(world) : "";
}

double now() {
  using Clock = std::chrono::steady_clock;
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

/// Joints of an island that contradict one another, by name; one line per island, at the first of
/// them. Joints that are assembled in a mirrored configuration are a warning.
std::vector<Error> contradictions(const std::string& path, Scene& scene) {
  std::vector<Error> found;
  for (std::size_t i = 0; i < lagrangian::islands_of(scene.world).size(); ++i) {
    std::string names, first;
    int count = 0;
    double lack = 0;
    for (const lagrangian::Fault& f : lagrangian::inspect(scene.world, i)) {
      const Entity joint =
          lagrangian::joint_of(scene.world, lagrangian::islands_of(scene.world)[i].blocks[f.block]);
      if (f.kind == lagrangian::Fault::wrong_branch)
        scene.warnings.push_back(
            fmt::format("{}: joint {} starts with its axes opposed, a wrong configuration that "
                        "satisfies its constraint",
                        path, scene.world.name_of(joint)));
      if (f.kind != lagrangian::Fault::inconsistent) continue;
      names += (names.empty() ? "" : ", ") + scene.world.name_of(joint);
      if (count++ == 0) first = scene.world.name_of(joint);
      lack = std::max(lack, f.residual);
    }
    if (names.empty()) continue;
    found.push_back(
        error_of_joint(path, first,
                       fmt::format("found inconsistent joints: {} {} open by up to {:.3g} (m or "
                                   "rad), expected joints that can all be closed",
                                   names, count == 1 ? "stays" : "stay", lack)));
  }
  return found;
}

}  // namespace

Jacobians jacobians_named(const std::string& word) {
  const auto* at = std::find(std::begin(kJacobianNames), std::end(kJacobianNames), word);
  return static_cast<Jacobians>(at - std::begin(kJacobianNames));
}

std::string idle_jacobians(const World& world) {
  return world.surface_contacts.size() > 0
             ? ""
             : "found --jacobians, expected it with a scene that has surface joints";
}

std::string words_of_lost_contact(const World& world, const StepReport& report) {
  const std::string_view fault = report.contact_fault;
  return fmt::format(
      "{} at the surface joint {} of body {}{}", fault, world.name_of(report.contact),
      world.name_of(report.body),
      fault == "ContactDegenerate"
          ? ": its surfaces conform there; use shapes with these surfaces, which collide"
          : "");
}

std::string words_of_inconsistency(const World& world, const StepReport& report) {
  const std::string name = world.name_of(report.worst_residual_at);
  if (report.body)
    return fmt::format(
        "the surface joint {} holds its body {:.3g} m within {}: joint and contact contradict each "
        "other; move one of them, or let the two bodies not collide",
        name, report.worst_residual, world.name_of(report.body));
  if (world.cables.find(report.worst_residual_at))
    return fmt::format(
        "the cable {} is longer than possible, or its end has reached a pulley: by "
        "{:.3g} m",
        name, report.worst_residual);
  return fmt::format(
      "joints are inconsistent, largest residual at {} ({:.3g}): they contradict one another, or a "
      "drive a limit; `pantin assemble` names those of a pose",
      name, report.worst_residual);
}

namespace {

/// The scene of a file with the values of --set.
Result<Scene> load_with(const std::string& path, const SceneChoices& choices) {
  if (choices.set.empty()) return load_scene(path, {}, solver_choices(choices));
  Result<std::string> text = read_text(path, SceneLimits{}.bytes, "a scene file");
  if (!text) return text.errors();
  for (const std::string& setting : choices.set) {
    Result<std::string> changed = with_setting(*text, setting);
    if (!changed) return Error{path + ": " + changed.errors().front().message};
    text = std::move(changed);
  }
  return parse_scene(*text, path, {}, solver_choices(choices));
}

}  // namespace

/// Gives the gusts of wind consecutive seeds; returns whether there are any.
static bool reseed(World& world, std::uint64_t seed) {
  bool any = false;
  for (TimedEvent& event : events_of(world).values())
    if (auto* wind = std::get_if<WindEvent>(&event.kind); wind && wind->gusts != Vec3(0))
      wind->seed = seed++, any = true;
  return any;
}

Result<Scene> read_scene(const std::string& path, const SceneChoices& choices) {
  Result<Scene> loaded = load_with(path, choices);
  if (!loaded) return loaded;
  Scene& scene = *loaded;
  if (choices.step) scene.step = *choices.step;
  if (choices.substeps) scene.substeps = *choices.substeps;
  if (choices.budget_ms) scene.budget_ms = *choices.budget_ms;
  if (choices.duration) scene.duration = *choices.duration;
  if (scene.duration / scene.step > kMostSteps)
    return Error{fmt::format("{}: found {:.6g} steps of {:.6g} s, expected at most {:g}", path,
                             scene.duration / scene.step, scene.step, kMostSteps)};
  if (const std::string why = idle_option(choices, scene.world); !why.empty())
    return Error{path + ": " + why};
  if (choices.seed && !reseed(scene.world, static_cast<std::uint64_t>(*choices.seed)))
    return Error{path +
                 ": --seed: found nothing random in the scene, expected wind with \"gusts\""};
  if (auto open = settle(path, scene); !open.empty()) return open;
  return loaded;
}

std::vector<Error> settle(const std::string& path, Scene& scene) {
  compile_if_changed(scene.world);
  for (const StructureFault& f : partition_of(scene.world).faults)
    if (!f.is_minor)  // the reader has warned of those
      scene.warnings.push_back(
          fmt::format("{}: {} {}{}", path, scene.world.name_of(f.link), f.reason,
                      f.kind == StructureFault::left_out ? "; it is left out" : ""));
  for (const std::string& words : words_of_repeated_wheels(scene.world))
    scene.warnings.push_back(path + ": " + words);
  return contradictions(path, scene);
}

std::optional<Scene> open_scene(const std::string& path, const SceneChoices& choices) {
  const EndsAtOnce while_nothing_is_written;
  Result<Scene> read = read_scene(path == "-" ? "/dev/stdin" : path, choices);
  if (read) return std::move(*read);
  for (const Error& e : read.errors()) print_error(e.message);
  return std::nullopt;
}

void print_warnings(const Scene& scene) {
  const EndsAtOnce while_nothing_is_written;
  for (const std::string& line : scene.warnings) print_error("warning: " + line);
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

void print_error(const std::string& line) { std::fprintf(stderr, "%s\n", printable(line).c_str()); }

int write_or_complain(const std::string& path, std::string_view text) {
  const auto written = write_file(path, text);
  if (written) return kOk;
  for (const Error& e : written.errors()) print_error(e.message);
  return kUnwritable;
}

void complain(const std::string& line) { print_error("pantin: " + line); }

void print_json(const Json& json) {
  // In ASCII: JSON does not escape all characters that terminals interpret.
  fmt::print("{}\n", json.dump(2, ' ', true, Json::error_handler_t::replace));
}

void catch_interrupts() {
  struct sigaction action = {};
  action.sa_handler = [](int) {
    if (g_interrupted || g_at_once > 0) _exit(kInterrupted);  // second request: exit at once
    g_interrupted = 1;
  };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGHUP, &action, nullptr);
  // Writes then fail, which is reported.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

bool interrupted() { return g_interrupted != 0; }

EndsAtOnce::EndsAtOnce() {
  g_at_once = g_at_once + 1;
  if (g_interrupted) _exit(kInterrupted);
}

EndsAtOnce::~EndsAtOnce() { g_at_once = g_at_once - 1; }

Progress::Progress(std::string what) : what_(printable(what)), on_(isatty(STDERR_FILENO) == 1) {}

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
  const std::string safe = printable(text);
  return kPlain ? safe : "\033[1m" + safe + "\033[0m";
}

namespace {

bool is_solved_by(SolverIndex solver, const World& world, std::uint32_t slot) {
  const Owner owner = owner_of(partition_of(world), slot);
  return owner && owner.solver == solver;
}

}  // namespace

bool is_planar(const World& world, std::uint32_t slot) {
  return is_solved_by(kPlanar, world, slot) || is_solved_by(kQuasistatic, world, slot);
}

std::vector<std::pair<Solver, std::size_t>> solvers_in_use(const World& world) {
  std::vector<std::pair<Solver, std::size_t>> used;
  const auto add = [&](Solver solver, std::size_t bodies) {
    for (auto& [known, count] : used)
      if (known == solver) return void(count += bodies);
    used.emplace_back(solver, bodies);
  };
  for (const articulated::Island& a : articulated::islands_of(world))
    add(a.settings.solver, a.count());
  for (const lagrangian::Island& m : lagrangian::islands_of(world))
    add(m.settings.solver, m.count());
  for (const SolverInfo& s : kSolverInfos)
    for (std::uint32_t slot = 0; slot < world.bodies.size(); ++slot)
      if (s.row != kArticulated && s.row != kLagrangian && is_solved_by(s.row, world, slot))
        add(s.solver, 1);
  if (used.empty()) add(world.default_settings.solver, 0);
  return used;
}

std::string solver_in_use(const World& world) {
  const auto used = solvers_in_use(world);
  return used.size() == 1 ? pantin::name_of(used.front().first) : "mixed";
}

std::string describe_solvers(const World& world) {
  const auto used = solvers_in_use(world);
  if (used.size() == 1) return pantin::name_of(used.front().first);
  std::string text;
  for (const auto& [solver, bodies] : used)
    text +=
        fmt::format("{}{} ({} bodies)", text.empty() ? "" : " + ", pantin::name_of(solver), bodies);
  return text;
}

Json solvers_json(const World& world) {
  Json j = Json::object();
  for (const auto& [solver, bodies] : solvers_in_use(world)) j[pantin::name_of(solver)] = bodies;
  return j;
}

std::string hex(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

std::vector<Unreached> unreached(const World& world) {
  std::vector<Unreached> found;
  for (const articulated::Island& a : articulated::islands_of(world)) {
    const Real bound = a.settings.tolerance * a.size;
    for (const articulated::PackedPin& h : a.pins) {
      if (h.compliance > 0 || !(h.residual > bound)) continue;
      const Entity who = h.held_pin != UINT32_MAX ? world.pins.owners()[h.held_pin]
                                                  : world.links.owners()[h.held_link];
      found.push_back({world.name_of(who), h.held_pin != UINT32_MAX ? "pin" : "joint", h.residual,
                       h.reachable});
    }
    for (const articulated::PackedCable& c : a.cables) {
      const Cable& s = world.cables.values()[c.cable];
      const Real far = stretch(s.joint, world.bodies[s.a].pose, world.bodies[s.b].pose);
      if (s.joint.compliance == 0 && far > bound)
        found.push_back({world.name_of(world.cables.owners()[c.cable]), "cable", far, true});
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
