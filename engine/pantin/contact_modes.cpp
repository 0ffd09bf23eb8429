// Reads back the contact modes of laminas.
#include "engine/solvers/quasistatic/contact_modes.hpp"

#include <pantin/laminas.hpp>

#include "engine/modes/outline.hpp"

namespace pantin {

using namespace detail;

namespace {

Vec3 spatial(modes::Vec2 v) { return {v.x, v.y, 0}; }

ContactState state_of(const modes::Signs& signs, std::size_t contact) {
  const std::uint32_t bit = 1u << contact;
  // The tangent points left, as seen along the normal.
  return signs.roll & bit    ? ContactState::sticks
         : signs.plus & bit  ? ContactState::slides_left
         : signs.minus & bit ? ContactState::slides_right
                             : ContactState::separates;
}

ContactMode told(const quasistatic::Grip& grip, const quasistatic::GripMode& mode, Vec3 centre) {
  ContactMode made;
  for (std::size_t i = 0; i < grip.contacts.size(); ++i) {
    const modes::Contact& c = grip.contacts[i];
    made.contacts.push_back({grip.fingers[i], spatial(c.point), spatial(c.normal),
                             state_of(mode.mode.signs, i),
                             mode.mode.normal_force[i] * spatial(c.normal) +
                                 mode.mode.tangent_force[i] * spatial(tangent_of(c.normal))});
  }
  const Vec3 twist = mode.mode.twist;
  made.velocity = {twist.x - twist.z * centre.y, twist.y + twist.z * centre.x, 0};
  made.angular_velocity = twist.z, made.is_stable = mode.is_stable;
  return made;
}

}  // namespace

std::vector<ContactMode> contact_modes(const World& world, Entity lamina) {
  std::vector<ContactMode> all;
  const quasistatic::Grip grip = quasistatic::grip_of(world, lamina);
  for (const quasistatic::GripMode& mode : quasistatic::modes_of(grip))
    all.push_back(told(grip, mode, world.bodies[lamina].pose.position));
  return all;
}

std::optional<ContactMode> contact_mode(const World& world, Entity lamina) {
  quasistatic::Grip grip;
  quasistatic::GripMode mode;
  if (!quasistatic::last_mode(world, lamina, grip, mode)) return std::nullopt;
  return told(grip, mode, world.bodies[lamina].pose.position);
}

}  // namespace pantin
