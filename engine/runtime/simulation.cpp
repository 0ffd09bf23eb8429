#include "engine/runtime/simulation.hpp"

#include <algorithm>

#include "engine/runtime/monitor.hpp"

namespace pantin {

using namespace detail;

namespace {

Error within_step(const std::string& what) {
  return {"Simulation: found " + what + " within a step, expected it between steps"};
}

}  // namespace

namespace detail {

MonitorBox::MonitorBox() : held_(std::make_unique<Monitor>()) {}
MonitorBox::MonitorBox(const MonitorBox& o) : held_(std::make_unique<Monitor>(*o.held_)) {}
MonitorBox::MonitorBox(MonitorBox&&) noexcept = default;
MonitorBox& MonitorBox::operator=(MonitorBox o) noexcept {
  held_ = std::move(o.held_);
  return *this;
}
MonitorBox::~MonitorBox() = default;

}  // namespace detail

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

StepReport Simulation::take_step(std::span<Pose> drawn_from) {
  stepping_ = true;
  const StepReport report = step_world(
      world, settings, systems_,
      {timing ? &times : nullptr, drawn_from, settings.watch ? monitor_.get() : nullptr});
  stepping_ = false;
  return report;
}

std::span<const Finding> Simulation::findings() const { return (*monitor_).findings(); }

bool Simulation::is_energy_checked(Entity body) const {
  return (*monitor_).energy().is_asked(world.bodies.slot(body));
}

StepReport Simulation::step() { return take_step({}); }

Advance Simulation::advance(Real wall_seconds) {
  Advance done;
  if (std::isfinite(wall_seconds) && wall_seconds > 0) left_over_ += wall_seconds;
  const Real h = settings.h;
  if (!(h > 0) || !std::isfinite(h)) return done;
  while (left_over_ >= h && done.steps < most_steps) {
    before_.clear();
    for (const Body& b : world.bodies.values()) before_.push_back(b.pose);
    before_version_ = world.bodies.version();
    const StepReport report = take_step(before_);
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
  const std::uint32_t slot = world.bodies.slot(body);
  if (slot == kNoSlot) return {};
  const Body& b = world.bodies.values()[slot];
  if (b.teleport || before_version_ != world.bodies.version() || slot >= before_.size())
    return b.pose;
  const Pose& from = before_[slot];
  return {glm::mix(from.position, b.pose.position, fraction),
          glm::slerp(from.rotation, b.pose.rotation, fraction)};
}

}  // namespace pantin
