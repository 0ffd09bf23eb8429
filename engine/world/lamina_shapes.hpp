#pragma once
/// What laminas and their fingers are as bodies: plates of even thickness, balls and bars. Corners
/// are in the plane of x and y.
#include <span>
#include <vector>

#include "engine/geometry/shape.hpp"
#include "engine/world/collision.hpp"

namespace pantin::detail {

/// About the mass centre of a plate, whose outline is given about it, counter-clockwise: principal
/// moments, kg m^2.
Vec3 plate_inertia(std::span<const Vec3> outline, Real mass);

/// A lamina or a finger, as it is drawn.
struct LaminaLook {
  Real extent = 1;  // m, of the outline
  std::uint32_t material = 0;
};
/// Of the convex pieces of an outline, each given about the mass centre.
std::vector<Shape> plate_shapes(const std::vector<std::vector<Vec3>>& pieces,
                                const LaminaLook& look);

/// The end of a finger: what touches, into the lamina.
struct FingerTip {
  Vec3 normal{0, 1, 0};  // unit
  bool flat = false;
};
Shape finger_shape(const FingerTip& tip, const LaminaLook& look);
/// From the centre of its body to the point that touches, m.
Vec3 finger_arm(const FingerTip& tip, const LaminaLook& look);

/// Laminas and fingers collide with nothing but the solver's contacts. Friction of a pair is the
/// root of the product: it is the finger's, and that of sliding.
Collision lamina_collision();
Collision finger_collision(Real slide);

}  // namespace pantin::detail
