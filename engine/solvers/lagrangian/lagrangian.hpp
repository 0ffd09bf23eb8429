#pragma once
/// The Lagrangian solver: Newton-Euler equations in absolute coordinates with constraint
/// multipliers, in time linear in the number of bodies. [Nelson & Cohen; Baraff 1996]
///
/// Method, orders and figures: README.md beside this file.
#include "engine/solvers/lagrangian/island.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::lagrangian {

/// Allocates scratch memory of islands that have none: after compile, and after a World was copied.
void prepare(World& world);

/// One step of `h` seconds from World::time of one island. If it fails, m.lost names a body and
/// nothing has moved.
void step(World& world, Island& m, Real h);

/// Faults of the joints in the present state: redundant rows, joints that cannot be closed
/// together, joints on a spurious branch. Moves nothing; allocates.
std::vector<Fault> inspect(const World& world, std::size_t island);

/// The stiffest spring, damper or motor of a joint, where the island's integrator cannot resolve it
/// in steps of `h`: Euler's method takes these. None: it can.
Entity too_stiff_joint(const World& world, std::size_t island, Real h);

/// Gap of a joint in the present state: root of the sum of its squared residuals, m and rad.
Real joint_gap(const World& world, const Island& m, std::size_t block);

/// Reaction of a joint and its limits on its body b, mean over the last step, world axes. Without
/// springs, motors and friction.
struct ConstraintWrench {
  Vec3 force{0};   // N
  Vec3 torque{0};  // N m, about the mass centre of b
};
ConstraintWrench joint_wrench(const Island& m, std::size_t block);

}  // namespace pantin::detail::lagrangian
