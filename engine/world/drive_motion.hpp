#pragma once
/// Changes of the motions of exact drives.
#include "engine/world/joint_drive.hpp"

namespace pantin::detail {

/// Whether its numbers are finite, and the times of its knots increase.
bool is_sound(const DriveMotion& motion);
/// The same motion, later by `by` (s).
void delay(DriveMotion& motion, Real by);
/// The same motion with its coordinate times a factor: in another unit, or, by -1, reversed.
void scale(DriveMotion& motion, Real factor);

}  // namespace pantin::detail
