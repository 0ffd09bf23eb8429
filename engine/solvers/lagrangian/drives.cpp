// Exact drives: a row that requires a coordinate of a joint to follow a function of time.
//
// A drive without a maximum torque is a constraint like any other. One with a maximum torque first
// takes each step as a constraint, too. Its coordinate may be behind its motion by a lag e then; it
// is required to catch up like a critically damped oscillator, from the present lag and its rate:
//
//   e(t) = (e0 + (e0' + k e0) t) exp(-k t),   k^2 = a / |e0|, at most 1 / (4 h)^2
//
// where a is twice the acceleration by the maximum torque. With this k, which grows as e falls, it
// brakes by (3 - 2 sqrt 2) a, a third of that torque.
//
// If that takes more than the maximum torque in the mean of the step, the step is repeated with the
// maximum torque as a constant force.
#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/lagrangian/internal.hpp"
#include "engine/world/joint_drive.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Least time constant of catching up, in steps.
constexpr Real kCatchUpSteps = 4;
/// Acceleration by which it catches up, by that of the maximum torque: it brakes with a third of it
/// then, and the rest is for loads.
constexpr Real kPace = 2;
/// A smaller lag is caught up in the least time, rad or m, relative to the coordinate.
constexpr Real kBehind = 1e-9;
/// Relative excess of the torque that counts as rounding.
constexpr Real kRounding = 1e-9;
/// rad or m: a coordinate that is farther from where it should be could not follow.
constexpr Real kFollowed = 1e-8;
constexpr Real kUnlimited = 1e299;

const JointDrive& drive_of(const World& world, const Island& m, const Block& b) {
  return world.joint_drives.values()[m.frames[b.body[2] - m.count()].drive];
}
DriveLag& lag_of(Island& m, const Block& b) { return m.frames[b.body[2] - m.count()].lag; }

CoordinateRow row_of_drive(const World& world, const Island& m, const Block& b, Real before) {
  return coordinate_row(world, m, {b.source, {b.body[0], b.body[1]}, b.coordinate, before});
}

/// A coordinate with less than this fraction of the mobility of its two bodies alone is stopped.
constexpr Real kStopped = 1e-9;

/// Acceleration along a drive's row by a unit force, with the current factor; where it is stopped,
/// as by a limit, that of its two bodies alone.
Real mobility_of(Island& m, const Block& b, const CoordinateRow& row) {
  StepScratch& s = m.scratch;
  std::fill(s.force.begin(), s.force.end(), Vec3(0));
  std::fill(s.right.begin(), s.right.end(), 0.0);
  for (std::size_t k = 0; k < 4; ++k)
    if (const std::uint32_t body = b.body[k / 2]; body < m.count())
      s.force[2 * body + k % 2] += row.j[k];
  solve(m, {s.force, s.right}, {std::span(s.motion).first(2 * m.count()), s.lambda});
  Real sum = 0, alone = 0;
  for (std::size_t k = 0; k < 4; ++k)
    if (const std::uint32_t body = b.body[k / 2]; body < m.count()) {
      sum += glm::dot(row.j[k], s.motion[2 * body + k % 2]);
      alone += k % 2 == 0 ? glm::dot(row.j[k], row.j[k]) / m.mass[body]
                          : glm::dot(row.j[k], s.inverse_inertia[body] * row.j[k]);
    }
  return sum > kStopped * alone ? sum : alone;
}

/// Sets how fast a drive that is behind catches up.
void set_pace(const World& world, Island& m, std::size_t block) {
  const Block& b = m.blocks[block];
  const Real most = drive_of(world, m, b).max_torque;
  DriveLag& lag = lag_of(m, b);
  const CoordinateRow row = row_of_drive(world, m, b, m.memory[block].before[0]);
  const Real mobility = mobility_of(m, b, row);
  const Real able = kPace * most * mobility;
  if (lag.value != 0) lag.decay = std::min(lag.decay, std::sqrt(able / std::abs(lag.value)));
}

}  // namespace

CoordinateMotion drive_motion(const World& world, const Frame& frame, Real time) {
  CoordinateMotion x = motion_at(world.joint_drives.values()[frame.drive].motion, time);
  const DriveLag& lag = frame.lag;
  if (lag.value == 0 && lag.rate == 0) return x;
  const Real t = time - lag.from, k = lag.decay, faded = std::exp(-k * t);
  const Real slope = lag.rate + k * lag.value, now = lag.value + slope * t;
  x.value -= now * faded;
  x.rate -= (slope - k * now) * faded;
  x.acceleration -= k * (k * now - 2 * slope) * faded;
  return x;
}

void write_drive(const World& world, Island& m, std::size_t block) {
  const Block& b = m.blocks[block];
  const bool active = is_active(m, block);
  Vec3* j = &m.scratch.jacobian[b.first_vector];
  Real &c = m.scratch.c[b.first_row], &gamma = m.scratch.gamma[b.first_row];
  const RowsOut out{&c, active ? j : nullptr, active ? &gamma : nullptr};
  write_coordinate({world.links.values()[b.source].joint, m.scratch.body_states[b.body[0]],
                    m.scratch.body_states[b.body[1]], m.memory[block].before[0]},
                   b.coordinate, out);
  c -= m.scratch.body_states[b.body[2]].position.x;
  if (active) {
    j[4] = {-1, 0, 0}, j[5] = Vec3(0);
    return;
  }
  gamma = 0;
  std::fill(j, j + vectors_of(b), Vec3(0));
}

void begin_drives(const World& world, Island& m, Real h) {
  for (Frame& f : m.frames)
    if (f.drive != UINT32_MAX) f.lag = {};
  update_kinematics(m), update_frames(world, m, 0, h);
  bool any_behind = false;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    if (b.kind != BlockKind::drive) continue;
    const JointDrive& drive = drive_of(world, m, b);
    if (!(drive.max_torque < kUnlimited)) continue;
    const CoordinateMotion target = motion_at(drive.motion, world.time);
    if (!m.counted) m.memory[i].before[0] = target.value;
    const CoordinateRow row = row_of_drive(world, m, b, m.memory[i].before[0]);
    DriveLag& lag = lag_of(m, b);
    lag.value = target.value - row.value, lag.rate = target.rate - row.rate;
    lag.from = world.time, lag.decay = 1 / (kCatchUpSteps * h);
    lag.yields = true;  // while mobilities are found
    any_behind = any_behind || std::abs(lag.value) > kBehind * (1 + std::abs(target.value));
  }
  if (any_behind) write_all_rows(world, m, {true, true}), factor(m);
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    if (m.blocks[i].kind != BlockKind::drive || !lag_of(m, m.blocks[i]).yields) continue;
    if (any_behind) set_pace(world, m, i);
    lag_of(m, m.blocks[i]).yields = false;
  }
}

bool yield_drives(const World& world, Island& m, Real h, StepOutcome outcome) {
  const bool failed = outcome == StepOutcome::failed;
  bool any = false;
  for (const Block& b : m.blocks) {
    if (b.kind != BlockKind::drive || lag_of(m, b).yields) continue;
    const Real most = drive_of(world, m, b).max_torque;
    if (!(most < kUnlimited)) continue;
    DriveLag& lag = lag_of(m, b);
    // Against another law of its joint, as a limit, its multiplier moves nothing and is removed.
    const Real missed = -m.scratch.c[b.first_row];
    const bool follows = std::abs(missed) <= kFollowed * (1 + std::abs(lag.value));
    Real needed = m.scratch.impulses[b.first_row] / h;
    if (failed) needed = lag.decay * lag.value + 2 * lag.rate;
    if (!failed && !follows) needed = missed;
    if (!failed && follows && std::abs(needed) <= (1 + kRounding) * most) continue;
    lag.yields = lag.limited = any = true;
    lag.force = needed == 0 ? 0 : std::copysign(most, needed);
  }
  return any;
}

bool may_yield(const World& world, const Island& m) {
  return m.driven && std::any_of(m.blocks.begin(), m.blocks.end(), [&](const Block& b) {
           return b.kind == BlockKind::drive && !lagrangian::lag_of(m, b).yields &&
                  drive_of(world, m, b).max_torque < kUnlimited;
         });
}

void add_drive_forces(const World& world, Island& m) {
  if (!m.driven) return;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    if (b.kind != BlockKind::drive || !lag_of(m, b).yields) continue;
    const CoordinateRow row = row_of_drive(world, m, b, m.memory[i].before[0]);
    for (std::size_t k = 0; k < 4; ++k)
      if (const std::uint32_t body = b.body[k / 2]; body < m.count())
        m.scratch.force[2 * body + k % 2] += lag_of(m, b).force * row.j[k];
  }
}

void release_drives(const World& world, Island& m) {
  for (const Block& b : m.blocks) {
    if (b.kind != BlockKind::drive || !(drive_of(world, m, b).max_torque < kUnlimited)) continue;
    DriveLag& lag = lag_of(m, b);
    if (!lag.yields) lag.yields = true, lag.force = m.forces[b.first_row];
  }
}

void note_drives(World& world, Island& m) {
  for (const Block& b : m.blocks) {
    if (b.kind != BlockKind::drive) continue;
    DriveLag& lag = lag_of(m, b);
    JointDrive& drive = world.joint_drives.values()[m.frames[b.body[2] - m.count()].drive];
    drive.torque = lag.yields ? lag.force : m.forces[b.first_row];
    drive.capped = lag.yields = lag.limited;
  }
}

}  // namespace pantin::detail::lagrangian
