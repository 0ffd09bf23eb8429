#include "engine/runtime/simulation.hpp"

#include <algorithm>

#include "engine/runtime/monitor.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin {

using namespace detail;

namespace {

Error within_step(const std::string& what) {
  return {"Simulation: found " + what + " within a step, expected it between steps"};
}

}  // namespace

namespace detail {

void StartPoses::take(const World& world) {
  kept_.assign(world.entities.capacity(), {});
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const Entity owner = world.bodies.owners()[i];
    kept_[owner.index] = {owner, world.bodies.values()[i].pose};
  }
}

MonitorBox::MonitorBox() : held_(std::make_unique<Monitor>()) {}
MonitorBox::MonitorBox(const MonitorBox& o) : held_(std::make_unique<Monitor>(*o.held_)) {}
MonitorBox::MonitorBox(MonitorBox&&) noexcept = default;
MonitorBox& MonitorBox::operator=(MonitorBox o) noexcept {
  held_ = std::move(o.held_);
  return *this;
}
MonitorBox::~MonitorBox() = default;

}  // namespace detail

bool is_asleep(const World& world, Entity body) {
  const std::uint32_t slot = world.bodies.slot(body);
  if (slot == kNoSlot) return false;
  // The partition uses the slots of its last build.
  const Owner owner = owner_of(partition_of(world), world.bodies.slot_then(slot));
  return owner && kSolvers[owner.solver]->sleeps(world, owner.island);
}

Result<Done> Simulation::insert(Stage stage, System system) {
  if (stepping_) return within_step("an insertion of a system");
  systems_.insert(stage, std::move(system));
  return Done{};
}

Result<Done> Simulation::insert(Stage stage, SystemOrder order, System system) {
  if (stepping_) return within_step("an insertion of system '" + order.name + "'");
  return systems_.insert(stage, std::move(order), std::move(system));
}

Result<Done> Simulation::remove(std::string_view name) {
  const std::string who = "system '" + std::string(name) + "'";
  if (stepping_) return within_step("a removal of " + who);
  if (systems_.remove(name)) return Done{};
  return Error{who + ": found no system of that name to remove"};
}

StepReport Simulation::take_step(StartPoses* start) {
  if (stepping_) {  // called by a system
    StepReport refused;
    refused.status = Status::system_failed;
    refused.tick = world.tick, refused.time = world.time;
    return refused;
  }
  stepping_ = true;
  if (!settings.watch) monitor_.get()->start_again();  // the monitor has not seen these steps
  const StepReport report =
      step_world(world, settings, systems_,
                 {timing ? &times : nullptr, start, settings.watch ? monitor_.get() : nullptr});
  stepping_ = false;
  return report;
}

std::span<const Finding> Simulation::findings() const { return (*monitor_).findings(); }

bool Simulation::is_energy_checked(Entity body) const {
  return (*monitor_).energy().is_asked(world.bodies.slot(body));
}

StepReport Simulation::step() { return take_step(nullptr); }

Advance Simulation::advance(Real wall_seconds) {
  Advance done;
  if (std::isfinite(wall_seconds) && wall_seconds > 0) left_over_ += wall_seconds;
  const Real h = settings.h;
  if (!(h > 0) || !std::isfinite(h)) return done;
  while (left_over_ >= h && done.steps < most_steps) {
    before_.take(world);
    const StepReport report = take_step(&before_);
    if (done.report.status == Status::ok) done.report = report;
    left_over_ -= h;
    ++done.steps;
  }
  if (left_over_ >= h) {
    // Whole steps beyond the cap are dropped; the fraction of a step is kept.
    const Real whole = std::floor(left_over_ / h) * h;
    done.dropped = whole;
    left_over_ -= whole;
  }
  done.fraction = std::clamp(left_over_ / h, Real(0), std::nextafter(Real(1), Real(0)));
  return done;
}

Pose Simulation::interpolated(Entity body, Real fraction) const {
  const Body* b = world.bodies.find(body);
  if (!b) return {};
  const Pose* from = b->teleport ? nullptr : before_.find(body);
  if (!from) return b->pose;
  return {glm::mix(from->position, b->pose.position, fraction),
          glm::slerp(from->rotation, b->pose.rotation, fraction)};
}

std::span<const DrawnPose> Simulation::drawn_poses(Real fraction) {
  drawn_.resize(world.bodies.size());
  for (std::size_t i = 0; i < drawn_.size(); ++i) {
    DrawnPose& d = drawn_[i];
    d.body = world.bodies.owners()[i];
    const Pose* origin = world.origins.find(d.body);
    const Pose centre = interpolated(d.body, fraction);
    const Pose at = origin ? compose(centre, *origin) : centre;
    for (int k = 0; k < 3; ++k) d.position[k] = static_cast<float>(at.position[k]);
    const Quat& q = at.rotation;
    const Real numbers[4] = {q.x, q.y, q.z, q.w};
    for (int k = 0; k < 4; ++k) d.rotation[k] = static_cast<float>(numbers[k]);
  }
  return drawn_;
}

std::span<const Entity> Simulation::awake_bodies() {
  awake_.clear();
  for (std::size_t i = 0; i < world.bodies.size(); ++i)
    if (const Entity e = world.bodies.owners()[i];
        world.bodies.values()[i].motion == Motion::dynamic && !is_asleep(world, e))
      awake_.push_back(e);
  return awake_;
}

}  // namespace pantin
