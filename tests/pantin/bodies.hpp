#pragma once
/// Bodies that several tests of the public interface put into a world.
#include <pantin/pantin.hpp>

namespace pantin::test {

/// A ball of 2 kg, 0.1 m in radius, without drag.
inline Entity add_ball(World& world, Vec3 at, Collision collision = {}) {
  return world
      .add(RigidBody{.shape = SphereShape{.radius = 0.1},
                     .mass = 2.0,
                     .position = at,
                     .collision = collision,
                     .drag = 0})
      .value();
}

}  // namespace pantin::test
