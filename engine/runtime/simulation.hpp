#pragma once
/// The schedule of one step, and the fixed-rate loop around it.
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

struct StepSettings {
  Real h = 1.0 / 60;     // s
  int substeps = 1;      // equal parts each step is taken in
  int threads = 1;       // islands are distributed over threads; the result does not depend on it
  bool measure = false;  // fill StepReport::measures after each step
  bool watch = false;    // list what makes the result doubtful: see Simulation::findings()
  /// Threads of a program's own, instead of `threads`: called with the islands of each stage. The
  /// result does not depend on how they are distributed, nor on how many there are.
  RunJobs run_jobs = {};
  /// Whether two bodies collide: asked once when they come near each other, so near that they may
  /// touch within the step, and again when they have parted; not of bodies that groups, joints or
  /// ignore() keep apart, of sensors, or of laminas and fingers. Bodies are asked about in the
  /// order of World::bodies, under Solver::planar in the order in which they touch, on the thread
  /// that steps. Answers are kept and saved with the World. It must depend on nothing that a saved
  /// World has not, if what is loaded is to go on alike; it changes nothing. What it throws ends
  /// the step (Status::aborted).
  ///
  /// Costs one search among the pairs that are near for each of them; what it refuses costs its
  /// narrow phase while it is near.
  ContactFilter filter = {};
};

/// The shortest and the longest substep that is taken, s.
inline constexpr Real kShortestStep = 1e-12, kLongestStep = 1e6;

namespace detail {

class Monitor;
/// Holds one; copies are deep.
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

/// Poses of bodies before a step. Kept by entity: slots change when bodies come and go.
class StartPoses {
 public:
  void take(const World& world);
  /// Null for a body that was not there.
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

/// What is recorded of a step besides its report, where there is room for it.
struct StepRecord {
  StageTimes* times = nullptr;
  /// Poses at the start; a body that a system teleports before the update gets the place where it
  /// lands.
  StartPoses* start = nullptr;
  Monitor* monitor = nullptr;
};

/// One whole step: drive, update, contacts, adjust, measure. Never throws, never prints; allocates
/// nothing once the structure is known. A step of zero or non-finite length does nothing; one whose
/// substeps are out of bounds does nothing either, and says so (Status::bad_clock).
///
/// Systems may create and destroy anything at any stage. Unchanged islands keep their state;
/// changed ones start afresh from the present motion of their bodies. After before_drive and
/// before_update the whole substep knows the change. After before_contacts and before_adjust
/// islands of the articulated solver are predicted anew; islands that were changed there go on with
/// the next substep.
StepReport step_world(World& world, const StepSettings& settings, const Systems& systems,
                      const StepRecord& record = {}) noexcept;

}  // namespace detail

/// Whether a body rests and costs nothing until something wakes it; false for one that is not
/// dynamic.
bool is_asleep(const World& world, Entity body);

/// Whether a step can use more than one thread in this build.
bool has_threads();

/// Measures of the present state.
Measures measure(const World& world);

/// Where to draw a body: the frame that it was placed by (World::origins), world.
struct DrawnPose {
  Entity body;
  float position[3] = {0, 0, 0};     // m
  float rotation[4] = {0, 0, 0, 1};  // quaternion x, y, z, w
};

/// Result of advance().
struct Advance {
  int steps = 0;      // whole steps taken
  Real fraction = 0;  // of the next step that has passed, in [0, 1): for interpolation
  Real dropped = 0;   // s of wall time given up by the cap on catching up
  StepReport report;  // of the last step; status of the first that failed
};

/// A World that is stepped at a fixed rate. It takes a World over:
///
///   Simulation simulation(std::move(world), {1.0 / 120});
///   simulation.world.destroy(crate);
///
/// What is added, changed and asked from then on is `simulation.world`.
class Simulation {
 public:
  explicit Simulation(World&& start = {}, StepSettings how = {})
      : world(std::move(start)), settings(std::move(how)) {}
  [[deprecated("copies: say Simulation::copy_of(world), or std::move(world)")]]  //
  explicit Simulation(const World& start, StepSettings how = {})
      : Simulation(World(start), std::move(how)) {}
  /// Steps a copy; the World stays as it is.
  static Simulation copy_of(const World& start, StepSettings how = {}) {
    return Simulation(World(start), std::move(how));
  }

  World world;
  StepSettings settings;
  int most_steps = 4;  // cap on catching up in one advance()

  /// Adds a user system at a stage of the step. Systems are inserted and removed between steps;
  /// within one that is refused.
  Result<Done> insert(Stage stage, System system);
  /// Adds one that has a name, and an order among its neighbours.
  Result<Done> insert(Stage stage, SystemOrder order, System system);
  /// Removes the system of that name; refuses where there is none.
  Result<Done> remove(std::string_view name);

  /// One whole step.
  StepReport step();

  /// Takes as many whole steps as fit into `wall_seconds` plus the remainder of earlier calls.
  Advance advance(Real wall_seconds);

  /// Interpolated pose of a body between the last two steps of advance(); a body that was
  /// teleported or added since is where it is.
  Pose interpolated(Entity body, Real fraction) const;

  /// All bodies as `interpolated` has them, by their own frames, in the order of World::bodies.
  /// Good until the next call.
  std::span<const DrawnPose> drawn_poses(Real fraction);

  /// The dynamic bodies that do not sleep, in the order of World::bodies. Good until the next call.
  std::span<const Entity> awake_bodies();

  /// What made results doubtful in the steps that StepSettings::watch was set for, by kind and
  /// place; kinds are in engine/world/findings.hpp.
  std::span<const Finding> findings() const;
  /// Whether the energy of a body can be balanced; not where several bodies hold a mechanism and
  /// one of them is moved.
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
