#pragma once
/// Symbols of the frame where joints hold bodies to the world, as in drawings of mechanisms.
#include <vector>

#include "engine/render/bounds.hpp"

namespace pantin::detail {

/// A rotation that takes y to a direction (unit).
Quat upright(Vec3 y);

/// A part of a symbol at its pose.
struct SupportPart {
  Shape shape;
  Pose pose;
};

/// Appends the symbols of all joints to fixed bodies without shapes: a cone on a plate at a joint
/// that holds a point, unless it is about the middle of its body like an axle, rails along a
/// translation, the disc of a wheel whose body has no shape. A body that starts below its anchor
/// hangs from the plate, others stand on it. The symbols stay in place while the mechanism moves.
void add_supports(const PosedWorld& scene, std::vector<SupportPart>& to);

}  // namespace pantin::detail
