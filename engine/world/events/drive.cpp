#include "engine/world/events/drive.hpp"

#include <cmath>

#include "engine/world/drive_motion.hpp"

namespace pantin {

using namespace detail;

namespace {

/// The value of an event, or the one before where it says none.
Real or_before(Real said, Real before) { return std::isnan(said) ? before : said; }

bool is_fitting(Real x) { return std::isnan(x) || is_amount(x); }

constexpr Real kUnlimited = 1e299;

}  // namespace

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
  const auto reach = [&](Real& of, Real from, Real to) {
    of = std::lerp(from, or_before(to, from), made.in_middle);
  };
  reach(d->stiffness, start.x, stiffness), reach(d->damping, start.y, damping);
  // A motion alone leaves the maximum as it is.
  if (!motion || !(max_torque > kUnlimited)) reach(d->max_torque, start.z, max_torque);
}

std::optional<EventFault> DriveEvent::fault() const {
  constexpr EventFault kFault{"stiffness", "a number that is not finite or below 0",
                              "numbers from 0 on"};
  if (!is_fitting(stiffness) || !is_fitting(damping) || !is_fitting(max_torque)) return kFault;
  if (motion && !is_sound(*motion))
    return EventFault{"motion", "numbers that are not finite, or times that do not increase",
                      "finite numbers, and each knot after the one before"};
  return std::nullopt;
}

}  // namespace pantin
