#pragma once
/// The layout of packed articulations, shared with the vector kernels. Names numbers only: nothing
/// here makes code, so that files built for other instruction sets may include it.
#include <cstddef>
#include <cstdint>

namespace pantin::articulated {

inline constexpr std::int32_t kHeld = -1;  // parent: the joint point follows a place in the world
inline constexpr std::int32_t kFree = -2;  // parent: nothing

/// Bodies handled side by side. Tables hold `kLanes` columns together, row by row.
inline constexpr std::size_t kLanes = 4;

/// Rows of Island::constants.
enum Constant : std::size_t {
  kMass,
  kInertia,                        // 3 principal moments
  kOwnAnchor = kInertia + 3,       // 3, the joint to the parent, in this body
  kParentAnchor = kOwnAnchor + 3,  // 3, the same point in the parent
  kDrag = kParentAnchor + 3,
  kGravityScale,
  kConstantRows
};

/// Rows of Island::memory, for the integrators.
enum Memory : std::size_t {
  kLastSlide,                                 // 3, displacement over the last step, m
  kLastTurn = kLastSlide + 3,                 // 3, rotation vector of the last step, rad
  kVelocityBefore = kLastTurn + 3,            // 3, velocity at the start of the last step, m/s
  kSpinMomentumBefore = kVelocityBefore + 3,  // 3, I w at the start of the last step, world
  kLoad = kSpinMomentumBefore + 3,            // 3, joint multiplier of the last step, kg m, world
  kMemoryRows = kLoad + 3
};

/// Rows of the work table: what one step computes and forgets.
enum Work : std::size_t {
  kPosition,                            // 3, predicted mass centre
  kRotation = kPosition + 3,            // 4 (x y z w), predicted
  kSpinStar = kRotation + 4,            // 3, predicted spin
  kArm = kSpinStar + 3,                 // 3, centre to own joint, world axes
  kParentArm = kArm + 3,                // 3, the parent's centre to the same joint
  kTurning = kParentArm + 3,            // 6 (xx xy xz yy yz zz), inertia; see prepare()
  kTurn = kTurning + 6,                 // 4 (x y z w), compulsive turn, any length
  kAttach = kTurn + 4,                  // 3, where the own joint goes
  kFinalPosition = kAttach + 3,         // 3
  kFinalRotation = kFinalPosition + 3,  // 4
  kWorkRows = kFinalRotation + 4
};

/// From the own joint point to the parent's, 3 numbers; lives where kAttach comes to stand.
inline constexpr std::size_t kGap = kAttach;

/// Stiffness that the parent feels of a loaded joint, 6 numbers; lives where the final pose comes
/// to stand, and is gone by then.
inline constexpr std::size_t kOutwardTension = kFinalPosition;

/// What elimination leaves of each body, 24 numbers side by side.
enum Node : std::size_t {
  kAnswer = 0,  // 3 rows of 4: turn per displacement of the own joint | turn if it does not move
  kGroup = 12,  // 3 rows of 4: mass that the joint feels of everything outboard | load, kg m
  kNodeSize = 24
};

}  // namespace pantin::articulated
