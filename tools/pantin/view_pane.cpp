#include "tools/pantin/view_pane.hpp"

#ifdef PANTIN_HAS_VIEW
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "engine/solvers/solver.hpp"
#include "tools/pantin/program.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr double kSlack = 1e-6;  // fraction of a step: rounding must not suppress one

void set_solver(World& world, Solver solver) {
  world.default_settings.solver = solver;
  for (SolverSettings& s : world.settings.values()) s.solver = solver;
  world.mark_dirty();
}

double contact_forces(const World& world) {
  double sum = 0;
  each_contact(world, [&](const Contact& c) { sum += c.active ? glm::length(c.force) : 0; });
  return sum;
}

}  // namespace

void Pane::start(const World& from, const StepSettings& how) {
  hand.forget();
  begin(from, how);
}

void Pane::begin(const World& from, const StepSettings& how) {
  alarm.clear(), trace.clear(), trails = {}, listener = nullptr;
  sim = Simulation::copy_of(from, how);
  sim.insert(Stage::before_drive, [this](World& world, Real) {
    hand.before_part(world, sim.settings.h / sim.settings.substeps);
  });
  sim.insert(Stage::after_step, [this](World& world, Real h) { after_step(world, h); });
  if (chosen) set_solver(sim.world, *chosen);
  fraction = gap = step_cost = 0, is_behind = false;
  if (!focus.name().empty()) focus.start(sim.world, how.h);
  place();
}

std::optional<std::string> Pane::start_posing() {
  if (const std::string fault = pose_fault(sim.world); !fault.empty()) return fault;
  hand.let_go(sim.world);
  hand.start_posing(sim.world);
  place();
  return std::nullopt;
}

void Pane::stop_posing() {
  if (hand.stop_posing(sim.world)) begin(at_rest(sim.world), StepSettings(sim.settings));
}

void Pane::pose() {
  hand.pose(sim.world);
  gap = measure(sim.world).worst_gap;
  draw_poses();
}

void Pane::place() {
  hand.renew(sim.world);
  draw_poses();
}

void Pane::draw_poses() {
  poses.clear();
  for (const Body& b : sim.world.bodies.values()) poses.push_back(b.pose);
}

void Pane::after_step(const World& world, Real h) {
  hand.after_step(world);
  trails.record(world);
  const Measures m = measure(world);
  gap = m.worst_gap;
  worst_gap = std::max(worst_gap, m.worst_gap);
  worst_gap_rel = std::max(worst_gap_rel, m.worst_gap_rel);
  ++steps, simulated += h;
  trace.push({world.time, m.kinetic, m.potential, m.energy(), m.worst_gap, contact_forces(world),
              step_cost});
  focus.sample(world);
  if (listener) listener->after_step(world, m);
}

Advance Pane::advance(double seconds, int most) {
  using Clock = std::chrono::steady_clock;
  const StepSettings& how = sim.settings;
  const double due = std::floor(fraction + seconds / how.h + kSlack);
  sim.most_steps = most;
  hand.expect(static_cast<int>(std::clamp(due, 1.0, 1.0 * most)) * how.substeps);
  const Clock::time_point start = Clock::now();
  const Advance done = sim.advance(seconds);
  if (done.steps > 0)
    step_cost = std::chrono::duration<double>(Clock::now() - start).count() / done.steps;
  fraction = done.fraction, is_behind = done.dropped > 0;
  poses.resize(sim.world.bodies.size());
  for (std::size_t i = 0; i < poses.size(); ++i)
    poses[i] = sim.interpolated(sim.world.bodies.owners()[i], fraction);
  return done;
}

StepReport Pane::single_step() {
  hand.expect(sim.settings.substeps);
  const StepReport report = sim.advance(sim.settings.h).report;  // the fraction of a step is kept
  place();
  return report;
}

std::optional<std::string> Pane::why_not(Solver solver) const {
  World tried = sim.world;
  set_solver(tried, solver);
  const std::vector<StructureFault> before = check(sim.world);
  for (const StructureFault& f : check(tried)) {
    const bool known = std::any_of(before.begin(), before.end(),
                                   [&](const StructureFault& b) { return b.link == f.link; });
    if (!known && !f.is_minor)
      return fmt::format("not with the solver {}: {} {}", pantin::name_of(solver),
                         tried.name_of(f.link), f.reason);
  }
  return std::nullopt;
}

std::optional<std::string> Pane::choose(Solver solver) {
  if (auto why = why_not(solver)) return why;
  chosen = solver;
  set_solver(sim.world, solver);
  return std::nullopt;
}

std::optional<std::string> Pane::trouble(const StepReport& step) const {
  const std::string body = sim.world.name_of(step.body);
  if (step.status == Status::diverged)
    return fmt::format("diverged: body {} could not continue or left all bounds", body);
  if (step.status == Status::bad_clock) return std::string("diverged: invalid time or step");
  if (step.status == Status::contact_lost)
    return "contact lost: " + words_of_lost_contact(sim.world, step);
  if (step.status == Status::inconsistent && step.body)
    return "inconsistent: " + words_of_inconsistency(sim.world, step);
  if (step.status == Status::energy_grew)
    return fmt::format(
        "energy grew severalfold without work at body {}: the solver {} does not conserve it", body,
        solver());
  return std::nullopt;
}

std::string Pane::solver() const {
  return chosen ? pantin::name_of(*chosen) : describe_solvers(sim.world);
}

}  // namespace pantin::program
#endif
