#pragma once
/// The bodies of laminas and their fingers: plates of constant thickness, balls and bars. Corners
/// are in the xy plane.
#include <span>
#include <vector>

#include "engine/geometry/shape.hpp"
#include "engine/world/collision.hpp"

namespace pantin::detail {

/// Principal moments of a plate about its mass centre, kg m^2; the outline is given about that
/// centre, counter-clockwise.
Vec3 plate_inertia(std::span<const Vec3> outline, Real mass);

/// The appearance of a lamina or a finger.
struct LaminaLook {
  Real extent = 1;  // m, of the outline
  std::uint32_t material = 0;
};
/// The shapes of the convex pieces of an outline, each given about the mass centre.
std::vector<Shape> plate_shapes(const std::vector<std::vector<Vec3>>& pieces,
                                const LaminaLook& look);

/// The tip of a finger, which touches the lamina; its normal points into the lamina.
struct FingerTip {
  Vec3 normal{0, 1, 0};  // unit
  bool flat = false;
};
Shape finger_shape(const FingerTip& tip, const LaminaLook& look);
/// The vector from the centre of its body to the contact point, m.
Vec3 finger_arm(const FingerTip& tip, const LaminaLook& look);

/// Laminas and fingers have only the contacts of their solver. The friction of a pair is the
/// geometric mean, which yields the finger's sliding friction.
Collision lamina_collision();
Collision finger_collision(Real slide);

}  // namespace pantin::detail
