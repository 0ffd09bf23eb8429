#pragma once
/// Feature::surface of a body.
#include "engine/world/collision.hpp"

namespace pantin::detail {

/// Whether a surface moves, or resists rolling or spinning.
inline bool has_special_surface(const Collision& c) {
  return c.surface_velocity != Vec3(0) || c.rolling != 0 || c.spinning != 0;
}

}  // namespace pantin::detail
