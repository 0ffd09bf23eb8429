#pragma once
/// Coordinates of joints at the present poses of their bodies.
#include "engine/joints/joint.hpp"
#include "engine/joints/rows.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

/// The state of a body for the rows of joints.
BodyState state_of(const Body& b);

/// A coordinate of a joint, rad or m, and its rate.
struct CoordinateAt {
  Real value = 0, rate = 0;
};
/// The coordinate of a link whose bodies exist and whose kind has it. An angle is the one nearest
/// to `before`, rad, so that whole turns are counted.
CoordinateAt coordinate_at(const World& world, const Link& link, Coordinate which, Real before = 0);

}  // namespace pantin::detail
