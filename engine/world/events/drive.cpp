#include "engine/world/events/drive.hpp"

#include <cmath>

#include "engine/world/drive_motion.hpp"

namespace pantin {

using namespace detail;

/// A motion that goes on from where the joint stands is found by the next build of the solvers
/// (start_drives()).
void DriveEvent::begin(const EventStep& step, EventProgress& progress) const {
  JointDrive* d = step.world.joint_drives.find(joint);
  if (!d) return;
  progress.start = {d->stiffness, d->damping, d->max_torque};
  if (!motion || !d->exact) return;
  const bool travels = d->motion.travels;
  d->motion = *motion, d->motion.travels = travels;
  fit_spline(d->motion), delay(d->motion, step.from);
  if (d->motion.at_start) step.world.mark_dirty();
}

void DriveEvent::change(const EventStep& step, EventProgress& progress,
                        const EventChange& made) const {
  JointDrive* d = step.world.joint_drives.find(joint);
  if (!d) return;
  const Vec3& start = progress.start;
  d->stiffness = std::lerp(start.x, stiffness, made.in_middle);
  d->damping = std::lerp(start.y, damping, made.in_middle);
  d->max_torque = std::lerp(start.z, max_torque, made.in_middle);
}

std::optional<EventFault> DriveEvent::fault() const {
  constexpr EventFault kFault{"stiffness", "a number that is not finite or below 0",
                              "numbers from 0 on"};
  if (!is_amount(stiffness) || !is_amount(damping) || !is_amount(max_torque)) return kFault;
  if (motion && !is_sound(*motion))
    return EventFault{"motion", "numbers that are not finite, or times that do not increase",
                      "finite numbers, and each knot after the one before"};
  return std::nullopt;
}

}  // namespace pantin
