#include "engine/world/events/motor.hpp"

#include <cmath>

#include "engine/joints/kinds.hpp"

namespace pantin {

using namespace detail;

namespace {

Dof* motor_of(World& world, Entity joint) {
  Link* link = world.links.find(joint);
  if (!link) return nullptr;
  JointParameters& own = link->joint.parameters.edit();
  const bool turns = info_of(link->joint.kind).is_used(Coordinate::angle, kActuated);
  return turns ? &own.rotation : &own.translation;
}

}  // namespace

/// A joint that gains or loses a motor changes the structure.
void MotorEvent::begin(const EventStep& step, EventProgress& progress) const {
  Dof* dof = motor_of(step.world, joint);
  if (!dof) return;
  const bool same = dof->motor.kind == motor.kind;
  if (!same) step.world.mark_dirty();
  const JointMotor before = dof->motor;
  progress.start.x = same || motor.kind == MotorKind::velocity ? dof->motor.target : 0;
  if (dof->motor.kind == MotorKind::none) progress.start.x = 0;
  dof->motor = motor;
  dof->motor.target = progress.start.x;
  if (motor.gain != 0) return;
  // Chosen gains are kept; a motor of another kind gets its own in the next step.
  if (same) dof->motor.gain = before.gain, dof->motor.damping = before.damping;
}

void MotorEvent::change(const EventStep& step, EventProgress& progress,
                        const EventChange& made) const {
  if (Dof* dof = motor_of(step.world, joint))
    dof->motor.target = std::lerp(progress.start.x, motor.target,
                                  motor.kind == MotorKind::position ? made.at_end : made.in_middle);
}

std::optional<EventFault> MotorEvent::fault() const {
  constexpr EventFault kFault{"motor", "a number that is not finite or below 0",
                              "finite numbers, from 0 on but for the target"};
  const bool good = std::isfinite(motor.target) && is_amount(motor.gain) &&
                    is_amount(motor.damping) && is_amount(motor.cap);
  return good ? std::nullopt : std::optional(kFault);
}

}  // namespace pantin
