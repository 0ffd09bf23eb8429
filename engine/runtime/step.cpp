// The schedule of one step.
#include <algorithm>
#include <chrono>

#include "engine/base/invariants.hpp"
#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/resting.hpp"
#include "engine/runtime/events.hpp"
#include "engine/runtime/monitor.hpp"
#include "engine/runtime/requests.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/solvers/check.hpp"
#include "engine/solvers/drive_starts.hpp"
#include "engine/solvers/motor_gains.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/solvers/takeover.hpp"
#include "engine/world/lamina.hpp"

namespace pantin::detail {
namespace {

/// Moves kinematic bodies to the poses of their paths at the end of the step. If the path is not
/// finite there, the body stays at rest; the first such body is reported.
void move_kinematic_bodies(World& world, Real h, StepReport& report) {
  const Real until = world.time + h;
  for (std::size_t i = 0; i < world.paths.size(); ++i) {
    Body* b = world.bodies.find(world.paths.owners()[i]);
    if (!b || b->motion != Motion::kinematic) continue;
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

/// Reports the first dynamic body with impossible numbers. If they changed without mark_dirty(),
/// the World is compiled again, which freezes the island of that body.
void check_dynamic_bodies(World& world, StepReport& report) {
  const Partition& partition = partition_of(world);
  bool is_stale = false;
  for (std::uint32_t slot = 0; slot < partition.island.size(); ++slot) {
    const std::uint32_t island = partition.island[slot];
    if (island == Owner::kNone || !fault_of(world.bodies.values()[slot])) continue;
    is_stale = is_stale || !partition.islands[island].unfit;
    if (report.status == Status::diverged) continue;
    report.status = Status::diverged, report.body = world.bodies.owners()[slot];
  }
  if (is_stale) world.mark_dirty(), compile_if_changed(world);
}

/// Reports the first kinematic body with an invalid pose or velocity set by the caller.
void check_kinematic_bodies(const World& world, StepReport& report) {
  for (std::uint32_t slot : partition_of(world).kinematic) {
    const Body& b = world.bodies.values()[slot];
    if (report.status == Status::diverged) return;
    if (is_finite(b.pose) && is_unit(b.pose) && is_finite(b.velocity) &&
        is_finite(b.angular_velocity))
      continue;
    report.status = Status::diverged, report.body = world.bodies.owners()[slot];
  }
}

void note_teleports(const World& world, StartPoses& start) {
  for (std::size_t i = 0; i < world.bodies.size(); ++i)
    if (const Body& b = world.bodies.values()[i]; b.teleport)
      start.replace(world.bodies.owners()[i], b.pose);
}

/// Whether any solver or sensor needs contacts.
bool anybody_feels(const World& world) {
  const auto& islands = partition_of(world).islands;
  const auto collisions = world.collisions.values();
  return std::any_of(islands.begin(), islands.end(),
                     [](const Partition::Place& p) { return p.feels_contacts; }) ||
         std::any_of(collisions.begin(), collisions.end(),
                     [](const Collision& c) { return c.sensor; });
}

/// Wakes bodies whose support no longer collides with them: it became a sensor, or left their
/// groups.
void wake_unsupported(World& world) {
  if (!contact::note_collisions(world)) return;
  const auto on = [&](std::uint32_t slot) {
    const Collision* c = world.collisions.find(world.bodies.owners()[slot]);
    return c && !c->sensor ? c : nullptr;
  };
  each_contact(world, [&](const Contact& c) {
    if (c.lambda == Vec3(0)) return;
    const Collision *a = on(c.slot_a), *b = on(c.slot_b);
    if (a && b && do_groups_agree(*a, *b)) return;
    for (const std::uint32_t slot : {c.slot_a, c.slot_b})
      if (owner_of(partition_of(world), slot)) world.bodies.values()[slot].restart = true;
  });
}

/// Detects the contacts of the step and passes them to the islands of their bodies. Returns false
/// if nothing can have changed.
bool detect_contacts(World& world, const StepTask& task) {
  std::vector<Contact>& contacts = contacts_of(world);
  const auto asleep = [&](const SolverRow* solver) { return solver->asleep(world); };
  const auto comes = [&](std::uint32_t slot) {
    const Body& b = world.bodies.values()[slot];
    return contact::moves(b) || b.restart || b.teleport;
  };
  const std::vector<std::uint32_t>& kinematic = partition_of(world).kinematic;
  contact::DetectScratch& scratch = world.memory.of<contact::Memory>().scratch;
  const auto runs = [](const Collision& c) { return c.surface_velocity != Vec3(0); };
  const auto collisions = world.collisions.values();
  // While all islands sleep and neither a kinematic body nor a conveyor moves, the contacts are
  // unchanged.
  const bool is_parted =
      scratch.rest_version == partition_of(world).rest_version &&
      world.memory.of<contact::Memory>().kept_for == contact::replacements(world);
  if (!(contacts.empty() && resting_contacts_of(world).empty()) && !scratch.stale && is_parted &&
      std::all_of(kSolvers.begin(), kSolvers.end(), asleep) &&
      std::none_of(kinematic.begin(), kinematic.end(), comes) &&
      std::none_of(collisions.begin(), collisions.end(), runs))
    return false;
  if (!world.collisions.empty() && anybody_feels(world)) {
    std::vector<Real>& reach = scratch.reach;
    reach.assign(world.bodies.size(), 0);
    scratch.displacement.assign(world.bodies.size(), {});
    scratch.starts.clear();
    for (const SolverRow* solver : kSolvers)
      solver->find_reaches(world, task.h, {reach, scratch.displacement}),
          solver->find_starts(world, scratch.starts);
    contact::detect(world, {task.h, task.filter, task.threads});
  } else {
    contacts.clear(), world.memory.of<contact::Memory>().resting.clear();
    scratch.search.sensors = 0;
  }
  scratch.stale = false;
  for (const SolverRow* solver : kSolvers) solver->take_contacts(world, task.h);
  return true;
}

/// Restarts kinematic bodies whose pose the caller changed without giving them a velocity. Wakes
/// what rests on these, and on fixed ones that were teleported.
void restart_moved(World& world) {
  for (const contact::Placed& before : world.memory.of<contact::Memory>().scratch.placed) {
    Body* const b = world.bodies.find(before.body);
    if (!b || b->motion != Motion::kinematic || contact::moves(*b)) continue;
    const Pose& to = b->pose;
    if (to.position != before.pose.position || to.rotation != before.pose.rotation)
      b->restart = true;
  }
  const auto jumps = [&](std::uint32_t slot) {
    const Body& b = world.bodies.values()[slot];
    return b.motion != Motion::dynamic && (b.restart || b.teleport);
  };
  const std::vector<std::uint32_t>& slots = partition_of(world).kinematic;
  if (std::none_of(slots.begin(), slots.end(), jumps)) return;
  each_contact(world, [&](const Contact& c) {
    for (const auto& [slot, other] : {std::pair(c.slot_a, c.slot_b), std::pair(c.slot_b, c.slot_a)})
      if (jumps(other) && owner_of(partition_of(world), slot))
        world.bodies.values()[slot].restart = true;
  });
}

/// Clears the restart and teleport flags of kinematic bodies once the step has used them.
void clear_requests(World& world) {
  auto& placed = world.memory.of<contact::Memory>().scratch.placed;
  placed.clear();
  for (const std::uint32_t slot : partition_of(world).kinematic) {
    Body& b = world.bodies.values()[slot];
    b.restart = b.teleport = false;
    if (b.motion == Motion::kinematic) placed.push_back({world.bodies.owners()[slot], b.pose});
  }
}

/// Forces of the substeps of a step. Copied with the World, since a system may replace the World by
/// a copy within a step.
struct ForceScratch {
  static constexpr std::string_view name = "forces";  // in saved Worlds
  std::vector<std::pair<Entity, Force>> whole;        // applied before the step, to all of it
  std::vector<std::pair<Entity, Force>> used;         // consumed by the update stage of this
                                                      // substep

  static void fields(auto& self, auto&& field) {
    field("whole", derived(self.whole));
    field("used", derived(self.used));
  }
};

/// Forces applied before the step act in all its substeps; those of systems in the current one.
void begin_forces(World& world) {
  ForceScratch& scratch = world.memory.of<ForceScratch>();
  scratch.whole.clear();
  for (std::size_t i = 0; i < world.forces.size(); ++i)
    scratch.whole.push_back({world.forces.owners()[i], world.forces.values()[i]});
}

/// After the update stage: forces that are added later act in the next substep.
void note_used_forces(World& world) {
  ForceScratch& scratch = world.memory.of<ForceScratch>();
  scratch.used.clear();
  for (std::size_t i = 0; i < world.forces.size(); ++i)
    scratch.used.push_back({world.forces.owners()[i], world.forces.values()[i]});
}

/// Forces added after the update stage act in the next substep; after the last one in all substeps
/// of the next step, divided by their number. `left` substeps follow.
void end_forces(World& world, int left, int substeps) {
  ForceScratch& scratch = world.memory.of<ForceScratch>();
  const auto each = [&](const auto& list, Real sign) {
    for (const auto& [owner, force] : list)
      if (Force* f = world.forces.find(owner))
        f->force += sign * force.force, f->torque += sign * force.torque;
  };
  const auto acted = [](const auto& p) {
    return p.second.force != Vec3(0) || p.second.torque != Vec3(0);
  };
  const bool any = std::any_of(scratch.used.begin(), scratch.used.end(), acted) ||
                   std::any_of(scratch.whole.begin(), scratch.whole.end(), acted);
  if (any) each(scratch.used, -1);
  // A non-finite force lasts only for its substep.
  for (const auto& [owner, force] : scratch.used)
    if (Force* f = world.forces.find(owner);
        f && !(is_finite(force.force) && is_finite(force.torque)))
      *f = Force{};
  if (left > 0) return each(scratch.whole, 1);
  if (substeps > 1)
    for (Force& f : world.forces.values())
      f.force /= static_cast<Real>(substeps), f.torque /= static_cast<Real>(substeps);
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
  const contact::DetectScratch& scratch = world.memory.of<contact::Memory>().scratch;
  report.contacts += scratch.resting_active;
  report.worst_depth = std::max(report.worst_depth, scratch.resting_depth);
}

/// Marks the World that is stepped. A copy loses the mark, so a replaced World is detected.
struct Stepped {
  static constexpr std::string_view name = "stepped";  // in saved Worlds
  enum State : std::uint8_t { never, within, between };
  struct Mark {
    State state = never;
  };
  Scratch<Mark> mark;

  static void fields(auto& self, auto&& field) { field("mark", derived(self.mark)); }
};
Stepped::State& stepped(World& world) { return world.memory.of<Stepped>().mark.state; }

/// State that the stages of one step share.
struct Step {
  World& world;
  const StepSettings& settings;
  const Systems& systems;
  const StepRecord& record;
  int substeps;
  StepTask task;  // of one substep
  Clock::time_point from;
  StepReport report;
  Budget budget;
  bool moved = false;  // contacts were detected: bodies may have moved

  void run(Stage stage) {
    for (const StagedSystem& system : systems.at(stage)) {
      try {
        system.run(world, settings.h);
      } catch (...) {
        report.status = Status::system_failed;
      }
    }
  }
};

/// Adds the duration of a stage, from construction to destruction.
class Timed {
 public:
  Timed(const Step& s, Real StageTimes::*stage)
      : total_(s.record.times ? &(s.record.times->*stage) : nullptr) {
    if (total_) from_ = Clock::now();
  }
  ~Timed() {
    if (total_) *total_ += std::chrono::duration<Real>(Clock::now() - from_).count();
  }
  Timed(const Timed&) = delete;
  Timed& operator=(const Timed&) = delete;

 private:
  Real* total_;
  Clock::time_point from_;
};

/// Whether a system has replaced the World; what was recorded of the former World is dropped.
bool is_replaced(Step& s) {
  if (stepped(s.world) == Stepped::within) return false;
  stepped(s.world) = Stepped::within;
  if (s.record.monitor) s.record.monitor->start_again();
  begin_forces(s.world);
  return true;
}

/// Compiles what changed, after motors that need gains were given them.
void build(Step& s) {
  choose_motor_gains(s.world, s.task.h);
  compile_if_changed(s.world);
}

/// Moves kinematic bodies.
void drive(Step& s) {
  const Timed timed(s, &StageTimes::drive);
  if (s.record.monitor) s.record.monitor->begin_substep(s.world);
  start_drives(s.world);  // where their joints stand now
  move_kinematic_bodies(s.world, s.task.h, s.report);
  move_fingers(s.world, s.world.time + s.task.h, s.task.h);
  build(s);
}

/// Predicts the free motion of all bodies.
void predict(Step& s) {
  World& world = s.world;
  const bool all_sound = normalise_rotations(world);
  build(s);
  if (!all_sound) check_dynamic_bodies(world, s.report);
  wake_unsupported(world);
  take_over(world, s.task.h);
  check_kinematic_bodies(world, s.report);
  restart_moved(world);
  for (const SolverRow* solver : kSolvers)
    if (solver->wake_changed) solver->wake_changed(world, s.task);
  list_awake(world);
  if (s.record.monitor) s.record.monitor->note_start(world, s.task.h);
  if (s.record.start) note_teleports(world, *s.record.start);
  for (const SolverRow* solver : kSolvers) solver->predict(world, s.task);
  note_used_forces(world);
}

/// The update stage. [Lee 2000, sec. 3.1]
void update(Step& s) {
  const Timed timed(s, &StageTimes::update);
  s.run(Stage::before_update);
  if (is_replaced(s)) drive(s);
  predict(s);
}

/// Applies structural changes by systems between the update and the adjust stage. A replaced World
/// repeats the substep from its beginning, without the systems that have already run.
void take_changes(Step& s, Stage stage) {
  s.run(stage);
  if (s.systems.at(stage).empty()) return;
  if (is_replaced(s)) {
    drive(s), predict(s);
    s.world.memory.of<contact::Memory>().scratch.stale = true;
    return;
  }
  compile_if_changed(s.world);
  for (const SolverRow* solver : kSolvers) solver->catch_up(s.world, s.task);
  list_awake(s.world);
}

/// Detects contacts between the poses before the step and the predicted ones.
void find_contacts(Step& s) {
  const Timed timed(s, &StageTimes::contacts);
  take_changes(s, Stage::before_contacts);
  s.moved = detect_contacts(s.world, s.task) || s.moved;
}

/// The adjust stage: joints are closed, contacts resolved, velocities updated. [Lee 2000, sec. 3.2]
void adjust(Step& s) {
  const Timed timed(s, &StageTimes::adjust);
  World& world = s.world;
  take_changes(s, Stage::before_adjust);
  if (world.memory.of<contact::Memory>().scratch.stale)
    s.moved = detect_contacts(world, s.task) || s.moved;
  for (const SolverRow* solver : kSolvers) solver->adjust(world, s.task);
  for (const SolverRow* solver : kSolvers)
    if (solver->list_contacts) solver->list_contacts(world, contacts_of(world));
}

/// Ends a substep; `left` more follow.
void advance_clock(Step& s, int left) {
  for (const SolverRow* solver : kSolvers) solver->note_failure(s.world, s.report);
  if (s.record.monitor) s.record.monitor->end_substep(s.world, s.task.h);
  end_forces(s.world, left, s.substeps);
  s.world.time += s.task.h;
}

/// Completes the report of the step, with the requested measures.
void finish(Step& s) {
  World& world = s.world;
  ++world.tick;
  stepped(world) = Stepped::between;
  clear_requests(world);
  if (s.moved) contact::sense(world);
  report_step(world, s.report);
  if (s.record.monitor) s.record.monitor->end_step(world, s.settings.h, s.report);
  {
    const Timed timed(s, &StageTimes::measure);
    s.run(Stage::before_measure);
    compile_if_changed(world);
    if (s.settings.measure) s.report.measures = measure(world), s.report.measured = true;
  }
  s.report.tick = world.tick, s.report.time = world.time;
  s.run(Stage::after_step);
}

}  // namespace

namespace {

/// Fraction of the budget within which bodies have to be stepped; the rest is for reports.
constexpr Real kSteppedBy = 0.9;

/// Sets the end of a substep; `left` more follow.
void set_budget(Step& s, int left) {
  if (!(s.settings.budget > 0)) return;
  const Real time = kSteppedBy * std::min(s.settings.budget, kLongestStep);
  const std::chrono::duration<Real> until(time * (s.substeps - left) / s.substeps);
  s.budget = {s.from + std::chrono::duration_cast<Clock::duration>(until), &s.settings.importance};
  s.task.budget = &s.budget;
}

void take_step(Step& s) {
  World& world = s.world;
  build(s);
  begin_forces(world);
  if (stepped(world) == Stepped::never && s.record.monitor) s.record.monitor->start_again();
  stepped(world) = Stepped::within;
  for (int left = s.substeps; left-- > 0;) {
    set_budget(s, left);
    apply_requests(world, s.task.h), apply_events(world, s.task.h);
    s.run(Stage::before_drive);
    if (!std::isfinite(world.time)) {
      compile_if_changed(world);
      s.report.status = Status::bad_clock;
      return;
    }
    is_replaced(s);
    drive(s);
    update(s);
    find_contacts(s);
    adjust(s);
    advance_clock(s, left);
  }
  finish(s);
}

/// Memory ran out, or a request exceeded all memory. The state of solvers may be inconsistent, so
/// the next step rebuilds it from the components.
void abort_step(Step& s) {
  forget_state(s.world);
  s.report = {};
  s.report.status = Status::aborted;
  s.report.tick = s.world.tick, s.report.time = s.world.time;
}

}  // namespace

StepReport step_world(World& world, const StepSettings& settings, const Systems& systems,
                      const StepRecord& record) noexcept {
  const int substeps = std::max(1, settings.substeps);
  const StepTask task{settings.h / substeps,
                      {settings.threads, settings.run_jobs ? &settings.run_jobs : nullptr},
                      settings.filter ? &settings.filter : nullptr};
  const bool is_timed = settings.budget > 0;
  Step s{world,
         settings,
         systems,
         record,
         substeps,
         task,
         is_timed ? Clock::now() : Clock::time_point{},
         {},
         {}};
  s.report.tick = world.tick, s.report.time = world.time;
  if (!(settings.h > 0) || !std::isfinite(settings.h)) return s.report;
  if (!(task.h >= kShortestStep && task.h <= kLongestStep)) {
    s.report.status = Status::bad_clock;
    return s.report;
  }
  try {
    take_step(s);
  } catch (...) {
    abort_step(s);
  }
  return s.report;
}

}  // namespace pantin::detail
