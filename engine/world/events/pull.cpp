#include "engine/world/events/pull.hpp"

namespace pantin {

using namespace detail;

/// The lowest: joints and pins of the scene take precedence.
constexpr int kHandPriority = -1000;

void PullEvent::begin(const EventStep& step, EventProgress& progress) const {
  World& world = step.world;
  if (!can_be_pushed(world, body)) {
    progress.done = true;
    return;
  }
  Pin pin;
  pin.body = body, pin.anchor = anchor, pin.priority = kHandPriority;
  pin.target = progress.start = to_world(world.bodies[body].pose, anchor);
  pin.kind = stiffness > 0 ? PinKind::spring : PinKind::exact;
  pin.stiffness = stiffness, pin.damping = damping;
  progress.pin = world.add_pin(pin);
}

void PullEvent::go_on(const EventStep& step, EventProgress& progress) const {
  World& world = step.world;
  Pin* pin = world.pins.find(progress.pin);
  progress.done = !pin || step.begins(to);
  if (progress.done) {
    if (pin) world.destroy(progress.pin);
    return;
  }
  const Real part = eased(progress_at({from, over}, step.to()));
  pin->target = progress.start + part * (target - progress.start);
}

std::optional<EventFault> PullEvent::fault() const {
  constexpr EventFault kFault{"stiffness", "a number that is not finite or below 0",
                              "numbers from 0 on"};
  return is_amount(stiffness) && is_amount(damping) ? std::nullopt : std::optional(kFault);
}

}  // namespace pantin
