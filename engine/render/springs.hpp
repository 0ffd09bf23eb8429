#pragma once
/// Draws springs between two points as coils.
#include <optional>
#include <vector>

#include "engine/render/bounds.hpp"

namespace pantin::detail {

/// A coil around the line from `a` to `b`.
struct Coil {
  Vec3 a{0}, b{0};            // its ends, world, m
  Real radius = 0, wire = 0;  // m, of the coil and of its wire
};

/// The coil of a spring joint: as wide as befits its rest length, so that it only becomes longer or
/// shorter. None for other joints, without extent, and if a body is gone.
std::optional<Coil> coil_of(const PosedWorld& scene, const Link& link);

/// The points of its wire from a to b, `around` of them a turn: straight ends and eight turns
/// between them.
std::vector<Vec3> wire_of(const Coil& coil, int around);

}  // namespace pantin::detail
