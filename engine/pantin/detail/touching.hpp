#pragma once
/// Bodies that touched in the last step.
#include <algorithm>

#include "engine/contact/contact.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

/// Calls `each(a, b)` for the bodies of every contact, for those of resting bodies too.
template <class Each>
void each_touching(const World& world, const Each& each) {
  each_contact(world, [&](const Contact& c) {
    const std::uint32_t a = world.bodies.slot_now(c.slot_a), b = world.bodies.slot_now(c.slot_b);
    if (std::max(a, b) < world.bodies.size())
      each(world.bodies.owners()[a], world.bodies.owners()[b]);
  });
}

}  // namespace pantin::detail
