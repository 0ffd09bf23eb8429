#pragma once
/// The contact modes of a lamina of a World, by finger.
#include <vector>

#include "engine/solvers/quasistatic/island.hpp"

namespace pantin::detail::quasistatic {

/// A lamina in contact with its fingers.
struct Grip {
  std::vector<modes::Contact> contacts;
  std::vector<Entity> fingers;  // of each contact
  std::vector<Real> roll, slide;
  Vec3 load{0};  // about the World's origin
  std::vector<modes::Vec2> outline;
  std::vector<modes::Finger> tips;
  std::vector<Entity> bodies;  // of the tips
};
/// A mode, its contacts numbered as in Grip::contacts.
struct GripMode {
  modes::SignedMode mode;
  bool is_stable = false;
};

/// The grip at the current poses; without contacts if there is no such lamina, or contacts cannot
/// be determined.
Grip grip_of(const World& world, Entity lamina);
/// The feasible modes.
std::vector<GripMode> modes_of(const Grip& grip);
/// The contacts and the mode of the last step, at the current pose of the lamina; false if it was
/// moved by dynamics, or not at all.
bool last_mode(const World& world, Entity lamina, Grip& grip, GripMode& mode);

}  // namespace pantin::detail::quasistatic
