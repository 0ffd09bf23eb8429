#include "engine/runtime/simulation.hpp"

#include <algorithm>

namespace pantin {

StepReport Simulation::step() {
  return step_world(world, settings, systems_, timing ? &times : nullptr);
}

Advance Simulation::advance(Real wall_seconds) {
  Advance done;
  if (std::isfinite(wall_seconds) && wall_seconds > 0) left_over_ += wall_seconds;
  const Real h = settings.h;
  if (!(h > 0) || !std::isfinite(h)) return done;
  while (left_over_ >= h && done.steps < most_steps) {
    before_.clear();
    for (const Body& b : world.bodies.values()) before_.push_back(b.pose);
    before_version_ = world.bodies.version();
    const StepReport report =
        step_world(world, settings, systems_, timing ? &times : nullptr, before_);
    if (done.report.status == Status::ok) done.report = report;
    left_over_ -= h;
    ++done.steps;
  }
  if (left_over_ >= h) {
    // Whole steps that there is no time for are given up, the part of a step is kept.
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
