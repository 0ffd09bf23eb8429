// The order of one step.
#include <algorithm>
#include <chrono>

#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/runtime/coupling.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin {
namespace {

/// The scene's hands: bodies that follow a path are moved to where it is at the end of the step.
void drive(World& world, Real h) {
  const Real until = world.time + h;
  for (std::size_t i = 0; i < world.drives.size(); ++i) {
    Body* b = world.bodies.find(world.drives.owners()[i]);
    if (!b || b->motion != Motion::driven) continue;
    const Pose to = pose_at(world.drives.values()[i], until);
    b->velocity = (to.position - b->pose.position) / h;
    b->spin = spin_between(b->pose.rotation, to.rotation, h);
    b->pose = to;
  }
}

/// Adds the seconds of a stage to its clock, if there is one.
class Stopwatch {
 public:
  explicit Stopwatch(bool on) : on_(on), last_(on ? Clock::now() : Clock::time_point()) {}
  void lap(Real& total) {
    if (!on_) return;
    const Clock::time_point now = Clock::now();
    total += std::chrono::duration<Real>(now - last_).count();
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  bool on_;
  Clock::time_point last_;
};

void run_systems(const Systems& systems, Place place, World& world, Real h, StepReport& report) {
  for (const PlacedSystem& system : systems.at(place)) {
    try {
      system.run(world, h);
    } catch (...) {
      report.status = Status::system_failed;
    }
  }
}

void note_teleports(const World& world, std::span<Pose> drawn_from) {
  const std::size_t count = std::min(drawn_from.size(), world.bodies.size());
  for (std::size_t i = 0; i < count; ++i)
    if (world.bodies.values()[i].teleport) drawn_from[i] = world.bodies.values()[i].pose;
}

/// Contacts of the step, handed to the islands of their bodies.
void detect_contacts(World& world, Real h) {
  std::vector<Contact>& contacts = contacts_of(world);
  const auto asleep = [&](const SolverRow* solver) { return solver->asleep(world); };
  const auto comes = [&](std::uint32_t slot) {
    const Body& b = world.bodies.values()[slot];
    return contact::moves(b) || b.restart || b.teleport;
  };
  const std::vector<std::uint32_t>& kinematic = partition_of(world).kinematic;
  // Where everything is asleep and nothing comes, the contacts stay as they are.
  if (!contacts.empty() && std::all_of(kSolvers.begin(), kSolvers.end(), asleep) &&
      std::none_of(kinematic.begin(), kinematic.end(), comes))
    return;
  if (!world.collisions.empty()) {
    std::vector<Real>& reach = world.memory.of<contact::Memory>().scratch.reach;
    reach.assign(world.bodies.size(), 0);
    for (const SolverRow* solver : kSolvers) solver->find_reaches(world, h, reach);
    contact::detect(world, h);
  } else {
    contacts.clear();
  }
  for (const SolverRow* solver : kSolvers) solver->take_contacts(world, h);
}

void note_pressures(World& world) {
  std::vector<contact::Pressure>& pressures = world.memory.of<contact::Memory>().pressures;
  pressures.clear();
  if (contacts_of(world).empty()) return;
  for (const SolverRow* solver : kSolvers) solver->press(world, pressures);
}

/// What was asked of the bodies for this step is done with.
void clear_requests(World& world) {
  for (Force& f : world.forces.values()) f = Force{};
  for (const std::uint32_t slot : partition_of(world).kinematic) {
    Body& b = world.bodies.values()[slot];
    b.restart = b.teleport = false;
  }
}

void report_step(const World& world, StepReport& report) {
  for (const SolverRow* solver : kSolvers) solver->report(world, report);
  for (const Contact& c : contacts_of(world)) {
    report.contacts += c.active;
    report.worst_depth = std::max(report.worst_depth, c.depth);
  }
}

}  // namespace

StepReport step_world(World& world, const StepSettings& settings, const Systems& systems,
                      StageTimes* times, std::span<Pose> drawn_from) noexcept {
  StepReport report;
  report.tick = world.tick, report.time = world.time;
  const int substeps = std::max(1, settings.substeps);
  const StepTask task{settings.h / substeps, settings.threads};
  if (!(task.h > 0) || !std::isfinite(task.h)) return report;
  compile_if_changed(world);
  StageTimes ignored;
  StageTimes& clock = times ? *times : ignored;
  Stopwatch watch(times != nullptr);
  const auto run = [&](Place place) { run_systems(systems, place, world, settings.h, report); };

  for (int part = 0; part < substeps; ++part) {
    run(Place::before_drive);
    drive(world, task.h);
    compile_if_changed(world);
    watch.lap(clock.drive);

    run(Place::before_update);
    note_teleports(world, drawn_from);
    save_coupled(world);
    for (const SolverRow* solver : kSolvers) solver->predict(world, task);
    watch.lap(clock.update);

    run(Place::before_touch);
    detect_contacts(world, task.h);
    watch.lap(clock.touch);

    run(Place::before_adjust);
    for (const SolverRow* solver : kSolvers) solver->adjust(world, task);
    step_coupled(world, task.h);
    for (const SolverRow* solver : kSolvers) solver->adjust_touching(world, task);
    settle_touching(world, task.h);
    note_pressures(world);
    watch.lap(clock.adjust);
    world.time += task.h;
  }
  ++world.tick;
  clear_requests(world);

  run(Place::before_measure);
  report_step(world, report);
  if (settings.measure) report.measures = measure(world), report.measured = true;
  watch.lap(clock.measure);
  report.tick = world.tick, report.time = world.time;
  run(Place::after_step);
  return report;
}

}  // namespace pantin
