// Exact drives: rows that require the coordinate of a hinge or slider to follow a function of time,
// with a maximum as engine/solvers/drive_lag.hpp has it. Where Box2D moves the mechanism, its joint
// motor drives it at the mean rate of the step, by the maximum at most; what it leaves is closed
// unless it has reached the maximum.
#include <algorithm>

#include "engine/solvers/planar/island.hpp"

namespace pantin::detail::planar {
namespace {

/// Part of its way in a step that Box2D leaves to a drive that is stopped; less, rad or m, is
/// closed.
constexpr Real kStopped = 0.5, kLeft = 1e-9;

const JointDrive& joint_drive(const World& world, const FlatDrive& d) {
  return world.joint_drives.values()[d.drive];
}

PlaneJoint& joint_of(Planar& all, const FlatDrive& d) {
  PANTIN_ASSERT(all.scratch.joint_of[d.link] != kNobody);
  return all.scratch.plane.joints[all.scratch.joint_of[d.link]];
}

/// The coordinate of a drive with its rate, at the start of the step.
CoordinateMotion coordinate_of(const World& world, const Planar& all, const FlatDrive& d) {
  const Row row = drive_pull(world, all, d);
  return {row.c + d.first, rate_of(row, all.scratch.motions.velocity), 0};
}

/// Sets how fast drives that are behind catch up.
void set_paces(const World& world, Planar& all, Mechanism& of) {
  StepScratch& s = all.scratch;
  s.nows.resize(kMostPlaces * all.curves.size());
  find_rows(world, all, of);
  if (!of.closing.fits(s.rows.size())) of.closing.analyse(s.rows, s.motions.inverse_mass);
  of.closing.compute(s.rows, s.motions.inverse_mass);
  for (const std::uint32_t at : of.drives)
    if (FlatDrive& d = all.drives[at]; d.lag.yields)
      set_pace(joint_drive(world, d), mobility_of(s, of, drive_pull(world, all, d)), d.lag);
}

}  // namespace

Row drive_pull(const World& world, const Planar& all, const FlatDrive& of) {
  return counted_row(world, all, of.link, of.travels ? Coordinate::travel : Coordinate::angle);
}

Row drive_row(const World& world, const Planar& all, const FlatDrive& of) {
  Row row = drive_pull(world, all, of);
  if (of.lag.yields) {
    row.j = {}, row.c = 0;
    return row;
  }
  const CoordinateMotion asked =
      motion_behind(joint_drive(world, of), of.lag, world.time + all.scratch.motions.time);
  row.c += of.first - asked.value, row.rate = asked.rate;
  return row;
}

void begin_drives(const World& world, Planar& all, Real h) {
  all.scratch.motions.time = 0;
  bool any_behind = false;
  for (FlatDrive& d : all.drives) {
    const JointDrive& drive = joint_drive(world, d);
    d.lag = {}, d.impulse = d.beyond = 0;
    if (!has_most(drive)) continue;
    d.lag = lag_at(drive, coordinate_of(world, all, d), world.time, h);
    d.lag.yields = true;  // while mobilities are found
    any_behind = any_behind || is_behind(drive, d.lag);
  }
  for (Mechanism& of : all.mechanisms)
    if (any_behind && !of.drives.empty()) set_paces(world, all, of);
  for (FlatDrive& d : all.drives) {
    d.lag.yields = false;
    PlaneJoint& j = joint_of(all, d);
    d.sign = d.travels ? 1 : drive_pull(world, all, d).part(j.b).z;
    const JointDrive& drive = joint_drive(world, d);
    const CoordinateMotion now = coordinate_of(world, all, d);
    const Real way = motion_behind(drive, d.lag, world.time + h).value - now.value;
    const Joint& joint = world.links.values()[all.links[d.link].link].joint;
    d.beyond = beyond_limit(drive, d.lag, {joint, now.value}, world.time + h);
    if (d.beyond != 0 && has_most(drive)) press(drive, d.beyond, d.lag);
    j.drive = {.on = true, .rate = d.sign * way / h, .most = drive.max_torque};
  }
}

void take_drives(const World& world, Planar& all, Real h) {
  for (const Mechanism& of : all.mechanisms)
    for (const std::uint32_t at : of.drives) {
      if (of.moved) continue;
      FlatDrive& d = all.drives[at];
      const PlaneJoint& j = joint_of(all, d);
      const JointDrive& drive = joint_drive(world, d);
      // What is stopped although its maximum is not reached yet: Box2D's impulses grow with time.
      const Real now = drive_pull(world, all, d).c + d.first;
      const Real left = std::abs(motion_behind(drive, d.lag, world.time + h).value - now);
      const bool stopped = has_most(drive) && left > kStopped * h * std::abs(j.drive.rate) + kLeft;
      d.lag.yields = d.lag.limited = j.drive.capped || stopped;
      d.lag.force = d.sign * j.drive.force, d.impulse = h * d.lag.force;
    }
}

void write_drives(World& world, Planar& all, Real h) {
  for (FlatDrive& d : all.drives) {
    JointDrive& to = world.joint_drives.values()[d.drive];
    to.torque = d.lag.yields ? d.lag.force : d.impulse / h;
    to.capped = d.lag.limited;
    d.value = drive_pull(world, all, d).c + d.first;
  }
}

}  // namespace pantin::detail::planar
