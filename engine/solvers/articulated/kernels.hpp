#pragma once
/// The inner loops over packed articulations: four bodies side by side where bodies do not depend
/// on one another, one after the other along the joints. Built once for every instruction set the
/// machine may have; all builds give the same bits, since none fuses or reorders an operation.
///
/// Includes nothing that makes code: an inline function compiled here for AVX2 must never be the
/// one the linker keeps for everybody.
#include "engine/solvers/articulated/packed.hpp"

namespace pantin::articulated {

/// Where a Body keeps its numbers, counted in doubles from its start.
struct BodyLayout {
  std::size_t stride, position, rotation, velocity, spin;
};

/// An articulation as the kernels see it. Tables are packed as in Table.
struct Packed {
  std::size_t count;
  const std::uint32_t* slots;  // padded to whole lanes
  const std::int32_t* parents;
  double* bodies;
  BodyLayout layout;
  const double* constants;
  double* memory;
  double* work;
  double* nodes;
  const double* forces;  // acceleration and torque rows, or null
  bool is_chain;
};

/// How the update stage integrates.
enum class Rule : std::uint8_t {
  verlet,    // damped Verlet, constant spin
  midpoint,  // damped Verlet, angular momentum kept at mid-step
  euler,     // backward Euler, angular momentum kept
  bdf2       // second order, angular momentum kept
};

struct PredictInput {
  double h;
  double gravity[3];
  Rule rule;
  bool first;  // half the acceleration: the first step from given velocities
};

/// Sums over the bodies, taken at the start of the step.
struct StartSums {
  double kinetic, potential, damped;  // J; damped: what the drag takes in one step
  double momentum[3];                 // kg m/s
  bool finite;                        // every prediction is
};

struct FinishInput {
  double h;
  double gravity[3];
  Rule rule;
  bool first;
  double calm_angle;  // rad
};

struct EndSums {
  double kinetic, potential, work;  // J; work of the given forces
  double momentum[3];
  double largest_turn2;  // square of the largest rotation of the step, rad^2
  bool sane;             // false: a position was not finite or too far; its block was not written
};

/// A body this far from the origin is lost, m.
inline constexpr double kTooFar = 1e12;

/// The block of a body in a tree, before its turn is eliminated: A_tt (6 numbers as in kTurning,
/// two unused), then three rows of 4 for A_ty | g_t and three for A_yy | g_y.
enum BlockPart : std::size_t { kTurnTurn = 0, kTurnSlide = 8, kSlideSlide = 20, kBlockSize = 32 };

struct Kernels {
  const char* name;
  /// Free motion of every body: predicted pose and spin into the work table. [Lee 2000, Eq. 1-2]
  StartSums (*predict)(const Packed&, const PredictInput&);
  /// The levers of the poses in the given rows: arms on both sides of the joints, gaps, inertias.
  void (*levers)(const Packed&, std::size_t position_row, std::size_t rotation_row);
  /// The same, and the turning blocks: kTurning becomes the inertia about the own joint. `tension`
  /// adds the stiffness of loaded joints, here and in kOutwardTension.
  void (*prepare)(const Packed&, std::size_t position_row, std::size_t rotation_row, bool tension);
  /// Leaf to root along a chain, prepare() for the predicted poses included: the nodes.
  void (*gather_chain)(const Packed&, bool tension);
  /// The same for any tree, in two parts: the blocks of the bodies alone, to which rows may add;
  /// then the elimination.
  void (*fill_blocks)(const Packed&, double* blocks);
  void (*gather_tree)(const Packed&, bool tension, double* blocks);
  /// Root to leaf: every joint closed exactly, turns by Cayley's map, multipliers into the memory.
  void (*close)(const Packed&, const double* targets, std::size_t position_row);
  /// Root to leaf: least displacement. [Lee 2000, sec. 3.2 corrected]
  void (*sweep)(const Packed&, const double* targets, std::size_t position_row, double stiffness);
  /// Turns and attach points applied: final poses. `from` is the row of rotations they start from.
  void (*commit)(const Packed&, std::size_t from_rotation_row);
  /// Velocities from the final poses; writes the bodies and the memory.
  EndSums (*finish)(const Packed&, const FinishInput&);
  /// close or (levers and) sweep, commit and finish in one pass over the predicted poses.
  EndSums (*close_and_finish)(const Packed&, const double* targets, const FinishInput&);
  EndSums (*sweep_and_finish)(const Packed&, const double* targets, double stiffness,
                              const FinishInput&);
  /// Scales all velocities: about `mean` in translation.
  void (*scale)(const Packed&, double factor, const double* mean);
};

/// The fastest that this machine can run; the environment variable PANTIN_KERNELS names another.
const Kernels& kernels();
/// All that this machine can run, slowest first; null ends the list.
const Kernels* const* all_kernels();

}  // namespace pantin::articulated
