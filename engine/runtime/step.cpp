// The order of one step.
#include <algorithm>
#include <chrono>

#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/runtime/coupling.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail {
namespace {

/// Moves kinematic bodies to the poses of their paths at the end of the step. Those whose path
/// leads nowhere stay, at rest; the first is told.
void move_kinematic_bodies(World& world, Real h, StepReport& report) {
  const Real until = world.time + h;
  for (std::size_t i = 0; i < world.paths.size(); ++i) {
    Body* b = world.bodies.find(world.paths.owners()[i]);
    if (!b || b->motion != Motion::driven) continue;
    const Pose to = pose_at(world.paths.values()[i], until);
    const Vec3 velocity = (to.position - b->pose.position) / h;
    const Vec3 angular_velocity = angular_velocity_between(b->pose.rotation, to.rotation, h);
    if (is_finite(to) && is_finite(velocity) && is_finite(angular_velocity)) {
      b->pose = to, b->velocity = velocity, b->angular_velocity = angular_velocity;
      continue;
    }
    b->velocity = b->angular_velocity = Vec3(0);
    if (report.status != Status::diverged)
      report.status = Status::diverged, report.body = world.paths.owners()[i];
  }
}

/// Driven bodies without a path are where they were put by hand, which may be nowhere.
void look_at_hands(const World& world, StepReport& report) {
  for (std::uint32_t slot : partition_of(world).kinematic) {
    const Body& b = world.bodies.values()[slot];
    if (report.status == Status::diverged) return;
    if (is_finite(b.pose) && is_finite(b.velocity) && is_finite(b.angular_velocity)) continue;
    report.status = Status::diverged, report.body = world.bodies.owners()[slot];
  }
}

/// Measures the time of a stage.
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

void run_systems(const Systems& systems, Stage stage, World& world, Real h, StepReport& report) {
  for (const StagedSystem& system : systems.at(stage)) {
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

/// Contacts of the step, handed to the islands of their bodies. False where nothing can have
/// changed.
bool detect_contacts(World& world, Real h) {
  std::vector<Contact>& contacts = contacts_of(world);
  const auto asleep = [&](const SolverRow* solver) { return solver->asleep(world); };
  const auto comes = [&](std::uint32_t slot) {
    const Body& b = world.bodies.values()[slot];
    return contact::moves(b) || b.restart || b.teleport;
  };
  const std::vector<std::uint32_t>& kinematic = partition_of(world).kinematic;
  contact::DetectScratch& scratch = world.memory.of<contact::Memory>().scratch;
  // Where everything is asleep and nothing comes, the contacts stay as they are.
  if (!contacts.empty() && !scratch.stale &&
      std::all_of(kSolvers.begin(), kSolvers.end(), asleep) &&
      std::none_of(kinematic.begin(), kinematic.end(), comes))
    return false;
  scratch.stale = false;
  if (!world.collisions.empty()) {
    std::vector<Real>& reach = scratch.reach;
    reach.assign(world.bodies.size(), 0);
    for (const SolverRow* solver : kSolvers) solver->find_reaches(world, h, reach);
    contact::detect(world, h);
  } else {
    contacts.clear();
    scratch.search.sensors = 0;
  }
  for (const SolverRow* solver : kSolvers) solver->take_contacts(world, h);
  return true;
}

void note_pressures(World& world) {
  std::vector<contact::Pressure>& pressures = world.memory.of<contact::Memory>().pressures;
  pressures.clear();
  if (contacts_of(world).empty()) return;
  for (const SolverRow* solver : kSolvers) solver->press(world, pressures);
}

/// What was asked of kinematic bodies for this step is done with.
void clear_requests(World& world) {
  for (const std::uint32_t slot : partition_of(world).kinematic) {
    Body& b = world.bodies.values()[slot];
    b.restart = b.teleport = false;
  }
}

/// Forces while a step is taken in parts. A copy of the World has them too, since a system may put
/// one in its place within a step.
struct ForceScratch {
  static constexpr std::string_view name = "forces";  // in saved Worlds
  std::vector<std::pair<Entity, Force>> whole;        // pushed for the whole step, from outside
  std::vector<std::pair<Entity, Force>> felt;         // what the update stage of this part took up

  static void fields(auto& self, auto&& field) {
    field("whole", derived(self.whole));
    field("felt", derived(self.felt));
  }
};

/// What was pushed before the step acts in all its parts, what systems push in the part that runs.
void begin_forces(World& world) {
  ForceScratch& scratch = world.memory.of<ForceScratch>();
  scratch.whole.clear();
  for (std::size_t i = 0; i < world.forces.size(); ++i)
    scratch.whole.push_back({world.forces.owners()[i], world.forces.values()[i]});
}

/// After the update stage: what comes later acts in the next part.
void note_felt(World& world) {
  ForceScratch& scratch = world.memory.of<ForceScratch>();
  scratch.felt.clear();
  for (std::size_t i = 0; i < world.forces.size(); ++i)
    scratch.felt.push_back({world.forces.owners()[i], world.forces.values()[i]});
}

/// What came too late acts in the next part; after the last one in all parts of the next step, by
/// as much less. `left` is how many parts are to come.
void end_forces(World& world, int left, int parts) {
  ForceScratch& scratch = world.memory.of<ForceScratch>();
  const auto each = [&](const auto& list, Real sign) {
    for (const auto& [owner, force] : list)
      if (Force* f = world.forces.find(owner))
        f->force += sign * force.force, f->torque += sign * force.torque;
  };
  const auto acted = [](const auto& p) {
    return p.second.force != Vec3(0) || p.second.torque != Vec3(0);
  };
  const bool any = std::any_of(scratch.felt.begin(), scratch.felt.end(), acted) ||
                   std::any_of(scratch.whole.begin(), scratch.whole.end(), acted);
  if (any) each(scratch.felt, -1);
  // Not even a number that is none outlives its part.
  for (const auto& [owner, force] : scratch.felt)
    if (Force* f = world.forces.find(owner);
        f && !(is_finite(force.force) && is_finite(force.torque)))
      *f = Force{};
  if (left > 0) return each(scratch.whole, 1);
  if (parts > 1)
    for (Force& f : world.forces.values())
      f.force /= static_cast<Real>(parts), f.torque /= static_cast<Real>(parts);
}

void report_step(const World& world, StepReport& report) {
  for (const SolverRow* solver : kSolvers) solver->report(world, report);
  const std::vector<StructureFault>& faults = partition_of(world).faults;
  report.faults = static_cast<int>(faults.size());
  if (report.faults > 0) report.fault = faults.front().link;
  for (const Contact& c : contacts_of(world)) {
    report.contacts += c.active;
    report.worst_depth = std::max(report.worst_depth, c.depth);
  }
}

/// One step of a world: what all its parts share.
struct Step {
  World& world;
  const StepSettings& settings;
  const Systems& systems;
  StageTimes& clock;
  bool timed;
  std::span<Pose> drawn_from;
  StepTask task;
  StepReport report;
  bool moved = false;  // contacts were looked for: something may have moved

  void run(Stage stage) { run_systems(systems, stage, world, settings.h, report); }
};

/// Drive and update stage.
void predict(Step& s) {
  World& world = s.world;
  Stopwatch watch(s.timed);
  move_kinematic_bodies(world, s.task.h, s.report);
  compile_if_changed(world);
  watch.lap(s.clock.drive);

  s.run(Stage::before_update);
  compile_if_changed(world);
  look_at_hands(world, s.report);
  note_teleports(world, s.drawn_from);
  save_coupled(world);
  for (const SolverRow* solver : kSolvers) solver->predict(world, s.task);
  note_felt(world);
  watch.lap(s.clock.update);
}

/// Structural changes between the update and the adjust stage.
void take_up_changes(World& world, const StepTask& task) {
  compile_if_changed(world);
  for (const SolverRow* solver : kSolvers) solver->catch_up(world, task);
  recouple(world);
}

/// Touch and adjust stage.
void close(Step& s) {
  World& world = s.world;
  Stopwatch watch(s.timed);
  s.run(Stage::before_contacts);
  if (!s.systems.at(Stage::before_contacts).empty()) take_up_changes(world, s.task);
  s.moved = detect_contacts(world, s.task.h) || s.moved;
  watch.lap(s.clock.contacts);

  s.run(Stage::before_adjust);
  if (!s.systems.at(Stage::before_adjust).empty()) {
    take_up_changes(world, s.task);
    if (world.memory.of<contact::Memory>().scratch.stale)
      s.moved = detect_contacts(world, s.task.h) || s.moved;
  }
  for (const SolverRow* solver : kSolvers) solver->adjust(world, s.task);
  step_coupled(world, s.task.h);
  for (const SolverRow* solver : kSolvers) solver->adjust_touching(world, s.task);
  couple_touching(world, s.task.h);
  note_pressures(world);
  watch.lap(s.clock.adjust);
}

}  // namespace

StepReport step_world(World& world, const StepSettings& settings, const Systems& systems,
                      StageTimes* times, std::span<Pose> drawn_from) noexcept {
  StageTimes ignored;
  const int substeps = std::max(1, settings.substeps);
  Step s{world,
         settings,
         systems,
         times ? *times : ignored,
         times != nullptr,
         drawn_from,
         {settings.h / substeps, settings.threads},
         {}};
  StepReport& report = s.report;
  report.tick = world.tick, report.time = world.time;
  if (!(settings.h > 0) || !std::isfinite(settings.h)) return report;
  if (!(s.task.h >= kShortestStep && s.task.h <= kLongestStep)) {
    report.status = Status::bad_clock;
    return report;
  }
  compile_if_changed(world);
  begin_forces(world);
  bool sound = true;
  for (int part = 0; part < substeps && sound; ++part) {
    s.run(Stage::before_drive);
    sound = std::isfinite(world.time);
    if (!sound) break;
    predict(s);
    close(s);
    for (const SolverRow* solver : kSolvers) solver->note_failure(world, report);
    end_forces(world, substeps - part - 1, substeps);
    world.time += s.task.h;
  }
  if (!sound) {
    compile_if_changed(world);
    report.status = Status::bad_clock;
    return report;
  }
  ++world.tick;
  clear_requests(world);
  if (s.moved) contact::sense(world);
  report_step(world, report);

  Stopwatch watch(times != nullptr);
  s.run(Stage::before_measure);
  compile_if_changed(world);
  if (settings.measure) report.measures = measure(world), report.measured = true;
  watch.lap(s.clock.measure);
  report.tick = world.tick, report.time = world.time;
  s.run(Stage::after_step);
  return report;
}

}  // namespace pantin::detail
