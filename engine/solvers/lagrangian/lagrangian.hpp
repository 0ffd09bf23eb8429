#pragma once
/// The Lagrangian solver: Newton's and Euler's equations in absolute coordinates, with multipliers
/// for the joints, in time linear in the bodies. [Nelson & Cohen; Baraff 1996]
///
/// Method, orders and figures: README.md beside this file.
#include "engine/solvers/lagrangian/island.hpp"
#include "engine/world/world.hpp"

namespace pantin::lagrangian {

/// Memory for the steps of every island that has none; after compile, and after a copy.
void prepare(World& world);

/// One step of `h` seconds from World::time, of one mechanism: joints, limits, forces. Where it
/// cannot be taken, m.lost names a body and nothing has moved.
void step(World& world, Island& m, Real h);

/// What is wrong with the joints as the World stands, by name: rows that follow from others, joints
/// that cannot all be closed, joints at a wrong root. Does not move anything; allocates.
std::vector<Fault> inspect(const World& world, std::size_t island);

/// What a joint lacks as the World stands, root of the sum of squares of its residuals: m and rad.
Real joint_gap(const World& world, const Island& m, std::size_t block);

/// What a joint and its stops do to its body b, mean over the last step, world axes. Springs, motors
/// and friction are not in it.
struct JointForce {
  Vec3 force{0};   // N
  Vec3 torque{0};  // N m, about the mass centre of b
};
JointForce joint_force(const Island& m, std::size_t block);

}  // namespace pantin::lagrangian
