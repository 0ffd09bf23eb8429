#pragma once
/// Draws springs as coils: between two points, along the travels of joints, of pins.
#include <optional>
#include <vector>

#include "engine/render/bounds.hpp"

namespace pantin::detail {

/// A coil around the line from `a` to `b`.
struct Coil {
  Vec3 a{0}, b{0};            // its ends, world, m
  Real radius = 0, wire = 0;  // m, of the coil and of its wire
};

/// The coil of a spring joint, or of a spring along the travel of a joint: as wide as befits its
/// length at rest, so that it only becomes longer or shorter. A spring along a travel pushes body b
/// from a seat on body a, as far behind the rest position as the travel's limits demand, or else as
/// b reaches. None for other joints, without extent, and if a body is gone.
std::optional<Coil> coil_of(const PosedWorld& scene, const Link& link);

/// The coil of a spring pin, from its target to the point of its body; none for other pins.
std::optional<Coil> coil_of(const PosedWorld& scene, const Pin& pin);

/// The points of its wire from a to b, `around` of them a turn: straight ends and eight turns
/// between them.
std::vector<Vec3> wire_of(const Coil& coil, int around);

}  // namespace pantin::detail
