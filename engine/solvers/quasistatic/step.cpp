// A step of a lamina: by contact modes as far as they are determined, then by dynamics.
#include <algorithm>
#include <cmath>

#include "engine/base/invariants.hpp"
#include "engine/solvers/quasistatic/island.hpp"

namespace pantin::detail::quasistatic {
namespace {

constexpr Real kSameTurn = 1e-9;      // rad: the caller did not rotate the body
constexpr Real kLeastStretch = 1e-9;  // of a step

Why why_of(const modes::StepEnd& end) {
  using modes::Ending, modes::Verdict;
  switch (end.ending) {
    case Ending::free_motion:
      return Why::free_motion;
    case Ending::at_corner:
      return Why::at_corner;
    case Ending::crowded:
      return Why::crowded;
    case Ending::undecided:
      return Why::ambiguous;
    case Ending::zeno:
      return Why::zeno;
    case Ending::done:
    case Ending::no_mode:
      break;
  }
  return end.verdict == Verdict::squeezed     ? Why::squeezed
         : end.verdict == Verdict::conflict   ? Why::conflict
         : end.verdict == Verdict::no_balance ? Why::no_balance
                                              : Why::unresolved;
}

void read_pose(const World& world, Island& m) {
  const Pose& pose = world.bodies.values()[m.slot].pose;
  const Real angle = 2 * std::atan2(pose.rotation.z, pose.rotation.w);
  const Real gained = std::remainder(angle - m.turned, 2 * kPi);
  if (!(std::abs(gained) < kSameTurn)) m.turned += gained;
  m.scratch.stepper.placed = {{pose.position.x, pose.position.y}, m.turned};
}

/// Writes the body at the end of the modes.
void write_body(World& world, Island& m) {
  const modes::Stepper& s = m.scratch.stepper;
  Body& b = world.bodies.values()[m.slot];
  m.turned = s.placed.angle;
  b.pose.position.x = s.placed.shift.x, b.pose.position.y = s.placed.shift.y;
  const Real half = 0.5 * std::remainder(m.turned, 2 * kPi);
  b.pose.rotation = Quat(std::cos(half), 0, 0, std::sin(half));
  b.velocity = b.angular_velocity = Vec3(0);
  if (!s.motion.is_known) return;
  const Vec3 twist = s.motion.twist;
  b.velocity = {twist.x - twist.z * b.pose.position.y, twist.y + twist.z * b.pose.position.x, 0};
  b.angular_velocity = {0, 0, twist.z};
}

bool is_finite(const modes::Placement& p) {
  return std::isfinite(p.shift.x) && std::isfinite(p.shift.y) && std::isfinite(p.angle);
}

/// Steps by modes, from one waypoint of a finger to the next. False if no mode is determined.
bool step_modes(World& world, Island& m, Clock& clock) {
  IslandScratch& s = m.scratch;
  PANTIN_ASSERT(m.phase == Phase::modes && !m.unfit);
  s.stepper.motion = m.motion;
  const modes::Part part = part_of(world, m);
  Body& b = world.bodies.values()[m.slot];
  modes::StepEnd end;
  while (clock.left() > kLeastStretch * clock.h && end.ending == modes::Ending::done) {
    const Real until = find_fingers(world, m, clock);
    PANTIN_ASSERT(clock.done >= 0 && clock.done <= clock.h);
    const Real stretch = std::clamp(until - clock.now(), kLeastStretch * clock.h, clock.left());
    const modes::Motion last = s.stepper.motion;
    end = s.stepper.step(part, s.fingers, stretch);
    s.switches += end.switches;
    clock.done += end.ending == modes::Ending::done ? stretch : end.time;
    // Dynamics starts from the last known motion.
    if (!s.stepper.motion.is_known && end.ending != modes::Ending::done) s.stepper.motion = last;
  }
  m.motion = s.stepper.motion;
  if (is_finite(s.stepper.placed)) write_body(world, m);
  b.restart = b.teleport = false;
  if (end.ending == modes::Ending::done) return true;
  m.motion = {};
  m.why = why_of(end);
  return false;
}

}  // namespace

const char* word_for(Why why) {
  constexpr const char* kWords[] = {"",
                                    "every motion penetrates a finger",
                                    "no forces of the fingers balance its load",
                                    "feasible motions and equilibria exist, but no mode has both",
                                    "too many modes to enumerate",
                                    "its fingers do not determine the motion",
                                    "a finger is at a corner, where it has no normal",
                                    "it has more than 32 contacts",
                                    "several modes hold, or only an unstable one",
                                    "modes switch without end"};
  PANTIN_ASSERT(static_cast<std::size_t>(why) < std::size(kWords));
  return kWords[static_cast<std::size_t>(why)];
}

void step(World& world, Island& m, Real h) {
  IslandScratch& s = m.scratch;
  s.start = world.bodies.values()[m.slot].pose;
  s.stepped = !m.unfit, s.changed = false, s.switches = 0;
  m.lost = false;
  if (m.unfit) return;
  PANTIN_ASSERT(m.slot < world.bodies.size() && world.bodies.owners()[m.slot] == m.body);
  read_pose(world, m);
  if (!is_finite(s.stepper.placed)) {
    m.lost = true;
    return;
  }
  Clock clock{world.time, h, 0};
  if (m.phase == Phase::modes) {
    if (step_modes(world, m, clock)) return;
    m.phase = Phase::dynamics, m.calm = 0, m.touches.clear();
    s.changed = true;
  }
  if (clock.left() > kLeastStretch * h) step_dynamics(world, m, clock);
}

}  // namespace pantin::detail::quasistatic
