#pragma once
/// The schedule of one step, and the fixed-rate loop around it.
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/job.hpp"
#include "engine/contact/contact.hpp"
#include "engine/runtime/systems.hpp"
#include "engine/world/faults.hpp"
#include "engine/world/findings.hpp"
#include "engine/world/report.hpp"
#include "engine/world/world.hpp"

namespace pantin {

/// The weight of a group in the division of StepSettings::budget, given one of its bodies: 1 as a
/// rule, less for what is far, small or hidden.
using Importance = std::function<Real(Entity body)>;

struct StepSettings {
  Real h = 1.0 / 60;     // s
  int substeps = 1;      // equal parts into which each step is divided
  int threads = 1;       // for islands, contact search, large groups; the result is the same
  bool measure = false;  // fill StepReport::measures after each step
  bool watch = false;    // list what makes the result doubtful: see Simulation::findings()
  /// The program's own thread pool, instead of `threads`: called with the islands of each stage,
  /// and some dozen times a step with at most 32 parts of a large group in contact. The result
  /// does not depend on their distribution, nor on the number of threads.
  RunJobs run_jobs = {};
  /// Decides whether two bodies collide. It is called once when two bodies come so near that they
  /// may touch within the step, and again after they have separated. It is not called for pairs
  /// that groups, joints or ignore() exclude, for sensors, or for laminas and fingers.
  ///
  /// Calls come in the order of World::bodies, under Solver::planar in the order of contact, on the
  /// thread that steps. Results are kept and saved with the World. For a loaded World to continue
  /// alike, the filter must depend only on data saved with it; it must change nothing. An exception
  /// ends the step (Status::aborted).
  ///
  /// Cost: one look-up for each near pair; a refused pair costs its narrow phase while it is near.
  ContactFilter filter = {};
  /// s: time in which a step should be computed; 0: as long as it takes.
  ///
  /// What is jointed and does not collide gives way in two stages. First, once the time is just
  /// enough for the rest, strings that become taut and limits that are hit are no longer followed
  /// within the step, but act at its end (StepReport::hurried). Then by its update rate: bodies
  /// joined to one another stay where they are for up to three steps and then take one for all the
  /// time, those with the smallest product of importance and waiting time first. So they never move
  /// by more than four steps' way at once. StepReport::left_out tells how many wait. Those that a
  /// force pushes, that were changed, or that hang on cables do not wait.
  ///
  /// Bodies in contact give way, each group by its share of the time that is left: it takes fewer
  /// and longer substeps, with fewer sweeps. Joints stay closed, and no energy is added; contacts
  /// are softer. Groups whose joints close loops take all their substeps. StepReport::shortened and
  /// group_costs() tell what was given up. Both give way in proportion to their cost. Everything
  /// else takes its time. The result then depends on the clock, and is not repeatable.
  Real budget = 0;
  /// Divides the budget, as by distance from the camera, with 0 for what is hidden; without it all
  /// groups have the same weight for their size.
  Importance importance = {};
};

/// Costs of the groups of bodies in contact in the last step with a budget, in its last substep.
std::span<const GroupCost> group_costs(const World& world);

/// The shortest and the longest substep, s.
inline constexpr Real kShortestStep = 1e-12, kLongestStep = 1e6;

namespace detail {

class Monitor;
/// Owns a monitor; copies are deep.
class MonitorBox {
 public:
  MonitorBox();
  MonitorBox(const MonitorBox&);
  MonitorBox(MonitorBox&&) noexcept;
  MonitorBox& operator=(MonitorBox) noexcept;
  ~MonitorBox();
  const Monitor& operator*() const { return *held_; }
  Monitor* get() { return held_.get(); }

 private:
  std::unique_ptr<Monitor> held_;
};

/// Seconds spent in each stage since the last reset, for benchmarks.
struct StageTimes {
  Real drive = 0, update = 0, contacts = 0, adjust = 0, measure = 0;
};

/// Poses of bodies before a step, stored by entity: slots change when bodies are added or removed.
class StartPoses {
 public:
  void take(const World& world);
  /// Null for a body that did not exist.
  const Pose* find(Entity body) const { return has(body) ? &kept_[body.index].pose : nullptr; }
  void replace(Entity body, const Pose& by) {
    if (has(body)) kept_[body.index].pose = by;
  }

 private:
  bool has(Entity body) const {
    return body.index < kept_.size() && kept_[body.index].owner == body;
  }

  struct Kept {
    Entity owner;
    Pose pose;
  };
  std::vector<Kept> kept_;  // by index of the entity
};

/// Optional records of a step besides its report.
struct StepRecord {
  StageTimes* times = nullptr;
  /// Poses at the start of the step. A body that a system teleports before the update is recorded
  /// where it arrives.
  StartPoses* start = nullptr;
  Monitor* monitor = nullptr;
};

/// One whole step: drive, update, contacts, adjust, measure. Never throws or prints; allocates
/// nothing once the structure is known. A step of zero or non-finite length does nothing. One whose
/// substeps are out of bounds does nothing either and reports Status::bad_clock.
///
/// Systems may create and destroy anything at any stage. Unchanged islands keep their state;
/// changed ones restart from the present motion of their bodies. Changes made before_drive and
/// before_update apply to the whole substep. After before_contacts and before_adjust, islands of
/// the articulated solver are predicted again; islands that changed there continue with the next
/// substep.
StepReport step_world(World& world, const StepSettings& settings, const Systems& systems,
                      const StepRecord& record = {}) noexcept;

}  // namespace detail

/// Whether a body sleeps, at no cost until something wakes it; false for a body that is not
/// dynamic.
bool is_asleep(const World& world, Entity body);

/// Whether this build supports more than one thread.
bool has_threads();

/// Measures of the present state.
Measures measure(const World& world);

/// The pose to draw a body at: of its own frame (World::origins), in world axes.
struct DrawnPose {
  Entity body;
  float position[3] = {0, 0, 0};     // m
  float rotation[4] = {0, 0, 0, 1};  // quaternion x, y, z, w
};

/// Result of advance().
struct Advance {
  int steps = 0;      // whole steps taken
  Real fraction = 0;  // of the next step that has elapsed, in [0, 1): for interpolation
  Real dropped = 0;   // s of wall time dropped by the cap on catching up
  StepReport report;  // of the last step; with the status of the first that failed
};

/// A World that is stepped at a fixed rate. It takes ownership of the World:
///
///   Simulation simulation(std::move(world), {1.0 / 120});
///   simulation.world.destroy(crate);
///
/// From then on `simulation.world` is the one to change and to read.
class Simulation {
 public:
  explicit Simulation(World&& start = {}, StepSettings how = {})
      : world(std::move(start)), settings(std::move(how)) {}
  [[deprecated("copies: use Simulation::copy_of(world), or std::move(world)")]]  //
  explicit Simulation(const World& start, StepSettings how = {})
      : Simulation(World(start), std::move(how)) {}
  /// Steps a copy; the original World is unchanged.
  static Simulation copy_of(const World& start, StepSettings how = {}) {
    return Simulation(World(start), std::move(how));
  }

  World world;
  StepSettings settings;
  int most_steps = 4;  // cap on catching up in one advance()

  /// Adds a user system at a stage of the step. Systems are inserted and removed between steps;
  /// within one it is an error.
  Result<Done> insert(Stage stage, System system);
  /// Adds a system with a name and an order relative to others.
  Result<Done> insert(Stage stage, SystemOrder order, System system);
  /// Removes the system of that name; an error if there is none.
  Result<Done> remove(std::string_view name);

  /// One whole step.
  StepReport step();

  /// Takes as many whole steps as fit into `wall_seconds` plus the remainder of earlier calls.
  Advance advance(Real wall_seconds);

  /// Interpolated pose of a body between the last two steps of advance(). A body that was
  /// teleported or added since has its present pose.
  Pose interpolated(Entity body, Real fraction) const;

  /// The interpolated poses of all bodies, in their own frames, in the order of World::bodies.
  /// Valid until the next call.
  std::span<const DrawnPose> drawn_poses(Real fraction);

  /// The dynamic bodies that are awake, in the order of World::bodies. Valid until the next call.
  std::span<const Entity> awake_bodies();

  /// The findings of the steps with StepSettings::watch, by kind and place; kinds are in
  /// engine/world/findings.hpp.
  std::span<const Finding> findings() const;
  /// Whether the energy of a body can be balanced. It cannot if several bodies hold a mechanism and
  /// one of them moves.
  bool is_energy_checked(Entity body) const;

  detail::StageTimes times;  // filled when `timing` is set
  bool timing = false;

 private:
  StepReport take_step(detail::StartPoses* start);

  detail::Systems systems_;
  detail::MonitorBox monitor_;
  bool stepping_ = false;
  Real left_over_ = 0;
  detail::StartPoses before_;  // of the last step of advance()
  std::vector<DrawnPose> drawn_;
  std::vector<Entity> awake_;
};

}  // namespace pantin
