#pragma once
/// Spurious roots of the rows of joints: an axis opposed to the one it should coincide with.
#include <vector>

#include "engine/assembly/problem.hpp"

namespace pantin::detail::assembly {

/// Blocks of joints on a spurious branch at the current poses.
std::vector<std::uint32_t> wrong_branches(const World& world, const Part& part);

/// Turns the bodies on one side of a joint by half a turn about one of its axes through its anchor,
/// so that it is on the right branch: all that hang on that side alone, or its body only.
void turn_over(const World& world, Part& part, std::uint32_t block);

/// Turns single bodies by half a turn where the nearest root of a joint is a spurious one, in the
/// order of joints. Returns the number of turns.
int face(const World& world, Part& part);

/// Places bodies one after the other along joints, from those that cannot move outwards: anchors
/// meet, and rotations and travels are the nearest that the joint allows within its limits. Joints
/// that close loops stay open.
void lay_out(const World& world, Part& part);

}  // namespace pantin::detail::assembly
