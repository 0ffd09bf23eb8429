#include "tools/pantin/measure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/island.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/solver_list.hpp"

namespace pantin::program {
namespace {

constexpr std::string_view kOfScene = "scene";

/// Adds the counts of a substep.
void add_counts(const World& world, Counts& counts) {
  for (const lagrangian::Island& m : lagrangian::islands_of(world)) {
    counts.factorisations += static_cast<std::uint64_t>(m.solves);
    counts.iterations += static_cast<std::uint64_t>(m.iterations);
    counts.substeps += static_cast<std::uint64_t>(m.substeps);
  }
  for (const articulated::Island& a : articulated::islands_of(world))
    counts.sweeps += static_cast<std::uint64_t>(a.sweeps_used);
}

/// The scene's World with the tolerance of a trial.
World world_of(const Trial& trial) {
  World world = trial.scene->world;
  if (trial.tolerance > 0) {
    SolverChoices choice;
    choice.step_tolerance = trial.tolerance;
    choice.apply(world.default_settings);
    for (SolverSettings& s : world.settings.values()) choice.apply(s);
    world.mark_dirty();
  }
  return world;
}

std::string reason_of(const World& world, const StepReport& report) {
  switch (report.status) {
    case Status::contact_lost:
      return words_of_lost_contact(world, report);
    case Status::inconsistent:
      return words_of_inconsistency(world, report);
    default:
      return report.body ? "at body " + world.name_of(report.body) : std::string();
  }
}

void note_step(const StepReport& report, Outcome& outcome) {
  const Measures& m = report.measures;
  outcome.gap = std::max({outcome.gap, m.worst_gap, report.worst_residual});
  outcome.gap_rel = std::max(outcome.gap_rel, m.worst_gap_rel);
  outcome.depth = std::max(outcome.depth, report.worst_depth);
  outcome.unsolved += report.unsolved > 0, outcome.rescued += report.rescued > 0;
  outcome.unreached += report.unreached > 0;
  ++outcome.counts.steps;
}

}  // namespace

std::uint64_t steps_in(double seconds, double step) {
  return static_cast<std::uint64_t>(std::max(1.0, std::round(seconds / step)));
}

double wall_seconds() {
  using Clock = std::chrono::steady_clock;
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

std::string_view run_status(Status status) {
  switch (status) {
    case Status::ok:
      return "ok";
    case Status::diverged:
      return "diverged";
    case Status::inconsistent:
      return "inconsistent";
    case Status::contact_lost:
      return "contact_lost";
    case Status::energy_grew:
      return "energy_grew";
    default:
      return "failed";
  }
}

std::vector<Method> all_methods() {
  std::vector<Method> all;
  for (const SolverInfo& s : kSolverInfos) {
    if (s.scope == SolverScope::laminas) continue;
    SolverChoices choices;
    choices.solver = s.solver;
    if (s.solver != Solver::lagrangian) {
      all.push_back({std::string(s.name), choices});
      continue;
    }
    for (const IntegratorInfo& i : kIntegrators) {
      choices.integrator = static_cast<Integrator>(&i - kIntegrators);
      choices.step_tolerance = 0;
      const std::string name = fmt::format("{}/{}", s.name, i.name);
      all.push_back({name, choices});
      if (i.takes_tolerance) all.push_back({name + "/tolerance", choices, true});
    }
  }
  all.push_back({std::string(kOfScene), {}});
  return all;
}

std::optional<Method> method_named(std::string_view name) {
  for (Method& m : all_methods())
    if (m.name == name) return m;
  return std::nullopt;
}

Loaded load(const std::string& path, std::string_view text, const Method& method) {
  Loaded loaded{method, std::nullopt, {}};
  Result<Scene> read = parse_scene(text, path, {}, method.choices);
  if (!read) {
    loaded.refusal = read.errors().front().message;
    return loaded;
  }
  if (const auto open = settle(path, *read); !open.empty()) {
    loaded.refusal = open.front().message;
    return loaded;
  }
  for (const StructureFault& f : partition_of(read->world).faults)
    if (!f.is_minor && method.name != kOfScene) {
      loaded.refusal = fmt::format("{}: {} {}", path, read->world.name_of(f.link), f.reason);
      return loaded;
    }
  loaded.scene = std::move(*read);
  return loaded;
}

Outcome run_motion(const Trial& trial) {
  Outcome outcome;
  Simulation sim(world_of(trial), {trial.step, trial.scene->substeps, 1, true, trial.watch});
  Sampler sampler(trial, sim.world, outcome.track);
  bool begun = false;
  sim.insert(Stage::before_drive,
             [&](World& world, Real) {
               if (begun) add_counts(world, outcome.counts);
               begun = true;
             })
      .value();
  sampler.take(sim.world, measure(sim.world).energy());
  const std::uint64_t steps = static_cast<std::uint64_t>(trial.sampling.count) *
                              steps_in(trial.sampling.interval, trial.step);
  double last = cpu_seconds();
  for (std::uint64_t i = 0; i < steps && outcome.is_ok(); ++i) {
    const StepReport report = sim.step();
    const double took = cpu_seconds() - last;
    outcome.slowest = std::max(outcome.slowest, took);
    outcome.seconds += took;
    note_step(report, outcome);
    if (trial.look) trial.look(sim.world, report);
    if (report.status != Status::ok)
      outcome.status = run_status(report.status), outcome.reason = reason_of(sim.world, report);
    else if (interrupted() || (trial.stop && trial.stop(outcome.seconds)))
      outcome.status = "stopped";
    if (outcome.is_ok()) sampler.take(sim.world, report.measures.energy());
    last = cpu_seconds();
  }
  add_counts(sim.world, outcome.counts);
  outcome.ended_at = sim.world.time;
  outcome.findings.assign(sim.findings().begin(), sim.findings().end());
  return outcome;
}

double time_run(const Trial& trial) {
  constexpr double kLeast = 0.02;  // s
  const std::uint64_t steps = steps_in(trial.sampling.duration(), trial.step);
  const World start = world_of(trial);
  double total = 0;
  int runs = 0;
  for (; total < kLeast && !interrupted(); ++runs) {
    Simulation sim = Simulation::copy_of(start, {trial.step, trial.scene->substeps, 1, false});
    bool good = sim.step().status == Status::ok;
    const double from = cpu_seconds();
    for (std::uint64_t i = 0; i < steps && good; ++i)
      good = sim.step().status == Status::ok && !interrupted();
    if (!good) return std::numeric_limits<double>::quiet_NaN();
    total += cpu_seconds() - from;
  }
  return runs > 0 ? total / runs : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace pantin::program
