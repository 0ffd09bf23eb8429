#pragma once
/// The articulated solver: joints closed in linear time, conservation of energy and momentum in
/// free motion, impulses in substeps for bodies in contact, and the rules of [Lee 2000]: README.md.
#include "engine/contact/memory.hpp"
#include "engine/solvers/articulated/island.hpp"

namespace pantin::detail {
struct StepTask;
}

namespace pantin::detail::articulated {

/// Allocates scratch memory of islands that have none: after compile, and after a World was copied.
void prepare(World& world);
/// The same of one island.
void prepare(const World& world, Island& a);

/// Update stage: predicts the free motion of every body of an island over `h` seconds.
void update(World& world, Island& a, Real h);

/// Wakes an island (Island::asleep), within a step.
void wake(World& world, Island& a, Real h);

/// Bounds on the displacement of each body's surface in the step, m, by body slot, from the
/// predictions.
void find_reaches(const World& world, Real h, const contact::Reaches& out);
/// Whether every island is asleep.
bool all_asleep(const World& world);
/// Whether this solver moves the body in a slot.
bool is_own(const World& world, std::uint32_t slot);
/// Assigns the detected contacts to their islands, and wakes islands.
void take_contacts(World& world, Real h);
/// Assigns again, after more islands woke, whose contacts are added.
void assign_contacts(World& world, Real h);

/// Bodies and trees in contact with fixed bodies and with one another (step_group.cpp): finds the
/// groups, after the contacts were assigned, and steps them with their contacts.
void plan_contact_groups(World& world, Real h);
void step_contact_groups(World& world, const StepTask& task);

/// Adjust stage: closes the joints at the predicted poses, computes velocities, writes the bodies.
/// False if a number is not finite or out of bounds; the bodies are then unchanged and `lost` names
/// one of them.
bool adjust(World& world, Island& a, Real h, Entity& lost);

/// Factor from multipliers of the last step, kg m, to forces, N; 0 if the solver "auto" took no
/// step since the World was built or copied.
Real force_per_lambda(const Island& a);
/// Reaction on the column's body from the joint to its parent in the last step, world axes;
/// includes limits, without drives and soft zones.
struct JointLoad {
  Vec3 force{0};   // N
  Vec3 torque{0};  // N m, about the joint point
};
JointLoad joint_load(const Island& a, std::size_t column);

}  // namespace pantin::detail::articulated
