#pragma once
// Sleighs: bodies on one blade, for tests of joints that constrain velocities only.
#include "engine/world/ties.hpp"
#include "tests/solvers/exact.hpp"

namespace pantin::test {

inline constexpr Real kMass = 2, kInertia = 0.3;  // kg, kg m^2 about y
inline const Vec3 kUp(0, 1, 0);

/// A sleigh in the plane xz, its blade along its x, `behind` m behind its mass centre.
struct Sleigh {
  World world;
  Entity ground, body, skate;
};
inline Sleigh sleigh(Integrator integrator, Real behind, Vec3 gravity = Vec3(0)) {
  Sleigh s{exact_world(integrator, gravity), {}, {}, {}};
  s.ground = add_ground(s.world);
  s.body = s.world.add_body(solid(kMass, Vec3(kInertia)));
  s.skate = add_link(s.world, {s.ground, s.body,
                               joint_at(s.world, s.ground, s.body, JointKind::skate,
                                        {-behind, 0, 0}, frame_along({0, 0, 1}))});
  return s;
}

inline Real sideways_at_blade(const World& w, Entity body, Real behind) {
  const Body& b = w.bodies[body];
  const Vec3 arm = b.pose.rotation * Vec3(-behind, 0, 0);
  return glm::dot(b.velocity + glm::cross(b.angular_velocity, arm),
                  b.pose.rotation * Vec3(0, 0, 1));
}

/// Keeps the sleigh's body at its height.
inline void add_table(Sleigh& s) {
  add_link(s.world, {s.ground, s.body,
                     joint_at(s.world, s.ground, s.body, JointKind::planar, {}, frame_along(kUp))});
}
/// The same on a table, its blade at the mass centre.
inline Sleigh loaded_sleigh(Integrator integrator, Vec3 gravity, Real friction) {
  Sleigh s = sleigh(integrator, 0, gravity);
  s.world.links[s.skate].joint.parameters.edit().friction = friction;
  add_table(s);
  return s;
}

}  // namespace pantin::test
