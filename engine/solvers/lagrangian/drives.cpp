// Exact drives: a row that requires a coordinate of a joint to follow a function of time.
// One with a maximum torque may yield: see engine/solvers/drive_lag.hpp.
#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/lagrangian/internal.hpp"
#include "engine/world/joint_drive.hpp"

namespace pantin::detail::lagrangian {
namespace {

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

/// A drive that moves its joint within the limits moves it off one that bore. The limits of a link
/// come before its drive.
void leave_limits(Island& m, std::size_t drive) {
  const Block& b = m.blocks[drive];
  for (std::size_t i = drive; i-- > 0 && m.blocks[i].source == b.source;) {
    const Block& limit = m.blocks[i];
    if (limit.kind == BlockKind::joint) return;
    if (limit.kind == BlockKind::limit && !limit.lock && limit.coordinate == b.coordinate)
      m.memory[i].active = false;
  }
}

}  // namespace

CoordinateMotion drive_motion(const World& world, const Frame& frame, Real time) {
  return motion_behind(world.joint_drives.values()[frame.drive], frame.lag, time);
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
    if (!has_most(drive)) continue;
    if (!m.memory[i].counted) m.memory[i].before[0] = motion_at(drive.motion, world.time).value;
    const CoordinateRow row = row_of_drive(world, m, b, m.memory[i].before[0]);
    DriveLag& lag = lag_of(m, b);
    lag = lag_at(drive, {row.value, row.rate}, world.time, h);
    lag.yields = true;  // while mobilities are found
    any_behind = any_behind || is_behind(drive, lag);
  }
  if (any_behind) write_all_rows(world, m, {true, true}), factor(m);
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    if (b.kind != BlockKind::drive || !lag_of(m, b).yields) continue;
    const JointDrive& drive = drive_of(world, m, b);
    DriveLag& lag = lag_of(m, b);
    const CoordinateRow row = row_of_drive(world, m, b, m.memory[i].before[0]);
    if (any_behind) set_pace(drive, mobility_of(m, b, row), lag);
    lag.yields = false;
    const DrivenJoint of{world.links.values()[b.source].joint, row.value};
    const Real beyond = beyond_limit(drive, lag, of, world.time + h);
    if (beyond != 0) press(drive, beyond, lag);
  }
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (m.blocks[i].kind == BlockKind::drive && !lag_of(m, m.blocks[i]).yields) leave_limits(m, i);
}

bool yield_drives(const World& world, Island& m, Real h, StepOutcome outcome) {
  const bool failed = outcome == StepOutcome::failed;
  return yield_any(outcome, [&](auto&& look) {
    for (const Block& b : m.blocks) {
      if (b.kind != BlockKind::drive) continue;
      const DriveNeed need{m.scratch.impulses[b.first_row] / h, -m.scratch.c[b.first_row], failed};
      look(drive_of(world, m, b), need, lag_of(m, b));
    }
  });
}

bool may_yield(const World& world, const Island& m) {
  return m.driven && std::any_of(m.blocks.begin(), m.blocks.end(), [&](const Block& b) {
           return b.kind == BlockKind::drive && !lagrangian::lag_of(m, b).yields &&
                  has_most(drive_of(world, m, b));
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
    if (b.kind != BlockKind::drive || !has_most(drive_of(world, m, b))) continue;
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
