#pragma once
/// Memory layout of packed islands, shared with the vector kernels. Constants only: no code is
/// generated here, so that files compiled for other instruction sets may include it.
#include <cstddef>
#include <cstdint>

namespace pantin::detail::articulated {

inline constexpr std::int32_t kHeld = -1;  // parent: the joint point is anchored in the world
inline constexpr std::int32_t kFree = -2;  // parent: none, a free root

/// The first child of a body, and the next sibling of a body, by columns.
inline constexpr std::uint32_t kNoChild = 0xffffffff;
struct Children {
  std::uint32_t first = kNoChild, sibling = kNoChild;
};

/// Bodies per vector. Tables store blocks of `kLanes` columns row by row.
inline constexpr std::size_t kLanes = 4;
/// Largest batch of islands, with the widest registers.
inline constexpr std::size_t kMostAbreast = 8;
/// Pairs of bodies without joints whose contact points are solved side by side.
inline constexpr std::size_t kPairLanes = 4;

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
  kLastTranslation,                      // 3, displacement over the last step, m
  kLastRotation = kLastTranslation + 3,  // 3, rotation vector of the last step, rad
  kMove = kLastRotation + 3,             // 3, unknown of the energy-momentum method
  kTurnBy = kMove + 3,                   // 3, likewise
  kLambda = kTurnBy + 3,                 // 3, joint lambda of the last step, kg m, world
  kMemoryRows = kLambda + 3
};

/// Rows of the work table: intermediate results of one step.
enum Work : std::size_t {
  kPosition,                                  // 3, predicted mass centre
  kRotation = kPosition + 3,                  // 4 (x y z w), predicted
  kAngularVelocityStar = kRotation + 4,       // 3, predicted angular velocity
  kArm = kAngularVelocityStar + 3,            // 3, centre to own joint, world axes
  kParentArm = kArm + 3,                      // 3, the parent's centre to the same joint
  kRotationalInertia = kParentArm + 3,        // 6 (xx xy xz yy yz zz), inertia; see prepare()
  kAppliedRotation = kRotationalInertia + 6,  // 4 (x y z w), applied rotation, any length
  kAttach = kAppliedRotation + 4,             // 3, new position of the own joint
  kFinalPosition = kAttach + 3,               // 3
  kFinalRotation = kFinalPosition + 3,        // 4
  kWorkRows = kFinalRotation + 4
};

/// Rows of the work table during a step by the energy-momentum method.
enum ConservingRow : std::size_t {
  kEndRotation,         // 4, of the iterate
  kJointWay = 4,        // 3, displacement of the own joint over the step
  kEndArm = 7,          // 3, from the own joint to the mass centre, at the iterate
  kMeanArm = 10,        // 3, mean of that and of the arm at the start
  kEndReach = 13,       // 3, from the parent's own joint to this one
  kMeanReach = 16,      // 3
  kImpulse = 19,        // 3, residual of the translation, or momentum, kg m/s
  kTorqueImpulse = 22,  // 3, about the own joint, kg m^2/s
  kTurn = 25,           // 9, derivative of the torque impulse, by rows; once it is eliminated,
                        // the inverse of the whole one, for iterations that keep it
  kConservingRows = kTurn + 9
};
static_assert(std::size_t{kConservingRows} <= std::size_t{kWorkRows});
inline constexpr std::size_t kEndJoint =
    kImpulse;  // 3, position of the own joint, once all is solved

/// Cayley vector of the rotation over the step, until the bodies are written.
inline constexpr std::size_t kTurned = kLastTranslation;

/// From the own joint point to the parent's, 3 numbers; shares its rows with kAttach, which is
/// written later.
inline constexpr std::size_t kGap = kAttach;

/// Result of the elimination of each body, 24 consecutive numbers.
enum Node : std::size_t {
  kResponse =
      0,  // 3 rows of 4: rotation per displacement of the own joint | rotation if it does not move
  kArticulatedMass =
      12,  // 3 rows of 4: articulated mass of the outboard subtree at the joint | bias, kg m
  kNodeSize = 24
};

/// Numbers of a body for ties (see ConservingTies): their contribution to its block, and the
/// factors of its elimination. Matrices are stored by rows.
enum TieBlock : std::size_t {
  kTieTurn = 0,       // 9, derivative of the torque by the rotation
  kTieImpulse = 9,    // 3
  kTieTorque = 12,    // 3
  kTieLoads = 15,     // so far: of all ties; the rest is of grounded ones, see grounded_block()
  kTieTurnMove = 15,  // 9, derivative of the torque by the displacement of the own joint
  kTieMoveTurn = 24,  // 9, of the impulse by the rotation
  kTieMoveMove = 33,  // 9, of the impulse by the displacement
  kTieBlock = 42
};
inline constexpr std::size_t kTieFactor = 18;

/// Rows of a cable in a batch of islands (ConservingLanes): numbers of ConservingTie.
enum LaneCableRow : std::size_t {
  kCableAnchorA = 0,  // 3, likewise below
  kCableAnchorB = kCableAnchorA + 3,
  kCableStartA = kCableAnchorB + 3,
  kCableStartB = kCableStartA + 3,
  kCableMeanA = kCableStartB + 3,
  kCableMeanB = kCableMeanA + 3,
  kCableEndA = kCableMeanB + 3,
  kCableEndB = kCableEndA + 3,
  kCableWay = kCableEndB + 3,
  kCableVelocity = kCableWay + 3,
  kCableBefore = kCableVelocity + 3,
  kCableNow = kCableBefore + 3,
  kCableMu = kCableNow + 3,
  kCableDerivative = kCableMu + 3,         // 9, by columns
  kCableDirection = kCableDerivative + 9,  // 3, of its row, likewise the next three
  kCableBy = kCableDirection + 3,          // 3
  kCableRight = kCableBy + 3,
  kCableOwn,
  kCableLength,
  kCableStiffness,
  kCableAcross,
  kCableSoftness,
  kCableResponse,
  kCableKind,      // kSlackTie, kTautTie or kStrikingTie
  kCableFollowed,  // 1: see CableRow, else 0
  kCableGrounded,  // 1: see ConservingTie, else 0
  kCableActs,      // 1: has a row, else 0
  kLaneCableRows
};
/// Least accepted diagonal pivot of the ties' equations, as a fraction of its row.
inline constexpr double kSafePivot = 1e-3;
/// A body on the path from a tie to its roots, or the displacement of a free root, whose column is
/// that of the root plus the number of bodies. `parent`: index of its parent on the path.
struct TiePathStep {
  std::uint32_t column, parent;
};

/// Numbers of a 3 x 3 block: each of its columns is padded to four.
inline constexpr std::size_t kBlockWide = 4, kBlockNumbers = 3 * kBlockWide;

/// A joint on the path from a tie, or a body, to its root. `torque` is the effect there of unit
/// impulses along the tie's directions, three columns: in groups with contacts the torque, and at a
/// free root `force` too; in the energy-momentum method the rotation. `next` is the step of the
/// next tie through the same joint, in the order of ties.
struct PathStep {
  std::uint32_t node = 0, tie = 0, next = UINT32_MAX;
  double torque[9] = {}, force[9] = {};
};
inline constexpr std::uint32_t kNoPathStep = UINT32_MAX;

}  // namespace pantin::detail::articulated
