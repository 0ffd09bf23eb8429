#pragma once
/// Inner loops over packed islands: four bodies per vector where bodies are independent, sequential
/// along the joints. Compiled once per instruction set. All builds give the same bits, since none
/// fuses or reorders operations.
///
/// Includes no header with code: the linker must never keep an inline function compiled for AVX2 as
/// the one for all.
#include "engine/solvers/articulated/lane_layout.hpp"

namespace pantin::detail::articulated {

/// Offsets of a Body's numbers, in doubles from its start.
struct BodyLayout {
  std::size_t stride, position, rotation, velocity, angular_velocity;
};

/// An island as seen by the kernels. Tables are stored as in LaneTable.
struct IslandView {
  std::size_t count;
  const std::uint32_t* slots;  // padded to whole lanes
  const std::int32_t* parents;
  double* bodies;
  BodyLayout layout;
  const double* constants;
  double* memory;
  double* work;
  double* nodes;
  const double* forces;      // acceleration and torque rows, or null
  const Children* children;  // unused for a chain
  bool is_chain;
};

/// Integration rule of the update stage.
enum class Rule : std::uint8_t {
  verlet,    // damped Verlet, constant angular velocity
  midpoint,  // damped Verlet, angular momentum kept at mid-step
  euler      // backward Euler, angular momentum kept
};

struct PredictInput {
  double h;
  double gravity[3];
  Rule rule;
  bool first;  // half the acceleration: first step from given velocities
};

struct VelocityInput {
  double h;
  Rule rule;
};

/// Positions beyond this distance from the origin count as diverged, m.
inline constexpr double kTooFar = 1e12;

/// The block of a body in a tree, before its rotation is eliminated: A_tt (6 numbers as in
/// kRotationalInertia, two unused), then three rows of 4 for A_ty | g_t and three for A_yy | g_y.
enum BlockPart : std::size_t {
  kRotationRotation = 0,
  kRotationTranslation = 8,
  kTranslationTranslation = 20,
  kBlockSize = 32
};

/// Forces between bodies besides the joints of trees, in a step by the energy-momentum method:
/// loops, pins, cables. Their own unknowns are solved for outside the kernels.
struct ConservingTies {
  void* context;
  const double* blocks;          // kTieBlock a body
  const std::uint8_t* grounded;  // a body: whether a tie leads from it to the world
  double* factors;               // kTieFactor a body
  /// Before an elimination: fills `blocks` at the iterate.
  void (*load)(void* context);
  /// After it: adds the response to the ties to kMove, kTurnBy and the impulses at the joints.
  /// False if the ties' equations have no solution.
  bool (*correct)(void* context);
  /// After convergence: false if the active set had to change, so that the iterations go on.
  bool (*settled)(void* context);
  /// After the iterations: false if the step is not acceptable. Adds the work of the ties, J, to
  /// `released`.
  bool (*accept)(void* context, double& released);
  /// Projects the velocities kMove and kTurnBy to those that the ties allow.
  bool (*project)(void* context);
  /// After these: whether no tie is connected to the world or to another tree; whether an impact
  /// dissipated energy; the work of moving points at the ties, J.
  const bool *inner, *struck;
  const double* place_work;
};

/// The unknowns: displacements that reduce the residual, or the allowed velocities.
enum class Unknown : std::uint8_t { displacement, velocity };

/// What the impulses that damp unresolved motion of joints do to the energy at the end of a step:
/// nothing, there being none; dampers only remove energy; drives and motors may also add some.
enum class AtEnd : std::uint8_t { keeps, damps, drives };

/// Joints that constrain rotations, or exert torques, in a step by the energy-momentum method:
/// their elimination replaces that of the kernels.
struct ConservingJoints {
  void* context;
  /// Inward: elimination, leaves to roots. Outward, roots to leaves: the unknowns kMove and
  /// kTurnBy, and the impulses at the joints.
  void (*inward)(void* context, Unknown);
  void (*outward)(void* context, Unknown);
  /// After the iterations: rotates the bodies to remove the remaining error of the joints' rows.
  void (*align)(void* context);
  /// Adds the work of the joints' torques, J.
  AtEnd (*add_work)(void* context, double& released);
};

/// Limits of joints that are not active: the bodies move as on free ball joints, if they keep clear
/// of them.
struct OpenLimits {
  void* context;
  /// After the iterations, with the rotations at the end in the work table: whether they do.
  bool (*are_clear)(void* context);
};

/// A step by the energy-momentum method. Arrays hold 3 numbers a tree.
struct ConservingInput {
  double h;
  double gravity[3];
  const double* targets;            // of the anchors at the end of the step, m
  const double* ways;               // displacements of the anchors over the step, m
  const double* anchor_velocities;  // at the end of the step, m/s
  int most_iterations;
  double enough;                   // rad: tolerance, largest rotation of the last iteration
  double enough_next;              // rad: the same for the next one, predicted from the last two
  bool may_keep;                   // matrices of an iteration serve the next ones
  bool still;                      // every tree is held, and no anchor moves
  bool knows_work;                 // all work on the island is known
  bool divisible;                  // large rotations may be left to shorter steps
  bool follows_equal_step;         // the rotations of the last step predict those of this one
  const ConservingTies* ties;      // or null
  const ConservingJoints* joints;  // or null
  const OpenLimits* limits;        // or null
  double most_due;                 // largest accepted ratio of due to computed energy
  double most_gain;                // largest accepted gain of kinetic energy, as a fraction
};

/// Cables of a batch of islands of equal structure: the common data.
struct LaneTies {
  struct Tie {
    std::uint32_t a, b;         // columns; a: UINT32_MAX for the world
    std::uint32_t path, count;  // its path to the roots
    bool stretches;
    bool is_chain;  // on its path each body is the parent of the one before
  };
  std::size_t count;
  const Tie* ties;
  const TiePathStep* paths;
  std::size_t steps, longest;  // of all paths, of one
  /// The steps of all paths, sorted by column (bodies, then displacements of free roots): those of
  /// a column start at column_starts[column]. The position of each step among them, and its cable.
  const std::uint32_t *column_starts, *positions, *tie_at;
  const std::uint8_t* grounded;  // as in ConservingTies
};
/// Numbers of rows, of steps and of places that a batch of islands of `bodies` needs.
inline std::size_t lane_tie_rows(const LaneTies& ties, std::size_t bodies) {
  return 2 * (ties.count + ties.steps + bodies);
}
/// State of an inextensible cable in a lane, as a number of its table.
inline constexpr double kSlackTie = 0, kTautTie = 1, kStrikingTie = 2;

/// One of the islands of a batch.
struct LaneIsland {
  IslandView view;
  ConservingInput input;  // without hooks: those of cables are below
  double size, mass;      // m, kg
  double yield;           // see StepScratch::tie_yield
  void* context;
  int* iterations;
  double* factors;  // kTieFactor a body
  /// After an iteration in which a cable became taut: whether the substep has to end there.
  bool (*is_hit_early)(void* context);
  /// After the iterations: the same for all cables that became taut.
  bool (*ends_early)(void* context);
  /// Velocities at the end after impacts of cables: see ConservingTies::project.
  bool (*strike)(void* context);
  const bool *inner, *struck;
  double* place_work;
};

/// Result of a step: refused; taken, with all written; or to be tried alone.
enum class LaneOutcome : std::uint8_t { refused, taken, alone };

/// Up to Kernels::lanes islands of equal structure: bodies, joints between the same columns, and
/// cables of the same kinds between these; no forces, and no other ties. Lanes beyond `count` are
/// ignored.
struct ConservingLanes {
  std::size_t count;
  const LaneIsland* islands;
  const LaneTies* ties;     // or null
  double* tie_table;        // of their cables, kLaneCableRows rows of Kernels::lanes each
  std::uint32_t* tie_rows;  // lane_tie_rows() numbers
  double* tie_gains;        // Kernels::lanes each
  double* memory;           // lane_numbers() numbers
  LaneOutcome* outcomes;    // one for each island
};

/// A joint whose response couples one row of blocks to the ties with a path through it. A block is
/// 3 x 3, its columns padded to four numbers.
struct PathJoint {
  const PathStep* steps;
  std::uint32_t first, last_tie;  // its first step; later ties are left out
  bool is_free_root;
  double by_torque[kBlockNumbers],
      by_force[kBlockNumbers];  // blocks: the row's response to torques and forces there
};

/// A contact point during iterations over the points of a pair of bodies, along its axes.
struct PairPoint {
  double impulse[3];        // N s, along the normal and two tangents
  double speed, parted;     // m/s: least normal speed, with and without a normal impulse
  double kept, gain;        // of the normal impulse; kg, impulse per missing speed
  double along, per_aside;  // 1/kg, normal response; kg
  double cross[2];          // 1/kg: tangential responses to a normal impulse
  double friction;
};

/// One iteration over the points of a pair, in impulse space: rows are three a point, then those of
/// rolling friction.
struct PairIteration {
  std::size_t points, stride;  // stride: rows, padded to whole lanes
  bool backwards;
  PairPoint* at;
  const double* responses;  // of all rows to an impulse along one, column by column
  double* speeds;           // m/s, along the rows
};

/// Motions of two bodies, velocity and spin of each: those that rows measure, number by number, and
/// those that impulses along the rows cause, one after the other.
struct RowMotions {
  std::size_t rows, stride;
  const double* seen;    // kMotionNumbers x stride
  const double* caused;  // rows x kMotionNumbers
};
inline constexpr std::size_t kMotionNumbers = 12;

/// Rows of pairs of bodies without joints, solved side by side, kPairLanes numbers each.
enum PairRow : std::size_t {
  kPairIterations,          // at most
  kPairOfA,                 // 7: inverse mass, 1/kg; inverse inertia, world axes, symmetric
  kPairOfB = kPairOfA + 7,  // 7
  kPairRows = kPairOfB + 7  // before those of the points
};
/// Rows of their points; points that a pair lacks are zero.
enum PointRow : std::size_t {
  kPointAxes,                      // 9: normal and tangents
  kPointArmA = kPointAxes + 9,     // 3, m
  kPointArmB = kPointArmA + 3,     // 3
  kPointSurface = kPointArmB + 3,  // 2: m/s, along the tangents
  kPointFriction = kPointSurface + 2,
  kPointAlong,                      // 1/kg, normal response
  kPointPerAlong,                   // kg
  kPointPerAside,                   // kg
  kPointCross,                      // 2: 1/kg, tangential responses to a normal impulse
  kPointImpulse = kPointCross + 2,  // 3: N s, along the axes
  kPointSpeed = kPointImpulse + 3,  // as in PairPoint, likewise the next two
  kPointParted,
  kPointKept,
  kPointByMass,  // of the impulse per missing speed of a rigid contact
  kPointRows
};
/// Up to kPairLanes pairs; no body that moves is in two of them.
struct PairLanes {
  std::size_t pairs, points;  // points: most of a pair
  double tolerance;           // relative to the first change of speed
  double* table;
  /// Velocity, spin and angular momentum, 9 numbers; of lanes without a pair, those of the first.
  double *a[kPairLanes], *b[kPairLanes];
};

struct Kernels {
  const char* name;
  /// Predicts the free motion of every body: pose and angular velocity into the work table. False
  /// if one is not finite. [Lee 2000, Eq. 1-2]
  bool (*predict)(const IslandView&, const PredictInput&);
  /// Joint geometry at the poses of the given rows: arms on both sides of the joints, gaps,
  /// inertias.
  void (*levers)(const IslandView&, std::size_t position_row, std::size_t rotation_row);
  /// The same; kRotationalInertia becomes the inertia about the own joint.
  void (*prepare)(const IslandView&, std::size_t position_row, std::size_t rotation_row);
  /// Inward pass of shake2, in two parts: the blocks of the bodies, then their elimination.
  void (*fill_blocks)(const IslandView&, double* blocks);
  void (*inward_pass)(const IslandView&, double* blocks);
  /// Root to leaf by least displacement. [Lee 2000, sec. 3.2 corrected]
  void (*sweep)(const IslandView&, const double* targets, std::size_t position_row,
                double stiffness);
  /// Applies rotations and joint points: final poses. `from` is the row of the initial rotations.
  void (*apply_poses)(const IslandView&, std::size_t from_rotation_row);
  /// Velocities from the final poses; writes bodies and state. False if a position was not finite
  /// or out of bounds; its block was not written then.
  bool (*update_velocities)(const IslandView&, const VelocityInput&);
  /// Sweep, apply_poses and update_velocities in one loop over the predicted poses.
  bool (*sweep_and_update)(const IslandView&, const double* targets, double stiffness,
                           const VelocityInput&);
  /// A whole step of free ball joints by the energy-momentum method; writes the bodies. False, with
  /// nothing written, if the iterations do not converge. [Betsch & Steinmann 2001]
  bool (*conserve)(const IslandView&, const ConservingInput&);
  /// The same for a batch of islands, one per SIMD lane. The bits of a lane do not depend on the
  /// other lanes.
  void (*conserve_lanes)(const ConservingLanes&);
  std::size_t lanes;  // largest batch
  /// Size of ConservingLanes::memory, in numbers.
  std::size_t (*lane_numbers)(std::size_t bodies, std::size_t trees, const LaneTies* ties);
  /// Scales all velocities; translation relative to `mean`.
  void (*scale)(const IslandView&, double factor, const double* mean);
  /// Adds to a row of blocks, one for each tie, the products with the steps of a joint.
  void (*add_path_responses)(const PathJoint&, double* row);
  /// to -= a b^T of 3 x 3 blocks over `columns` columns, each padded to four numbers.
  void (*subtract_products)(double* to, const double* a, const double* b, std::size_t columns);
  /// Speeds along all rows by an impulse along each: columns of `stride` numbers.
  void (*multiply_motions)(const RowMotions&, double* to);
  /// Projected Gauss-Seidel over the points of a pair, with Coulomb friction. Returns the largest
  /// change of speed, m/s.
  double (*iterate_pair)(const PairIteration&);
  /// Pairs side by side: responses of their points; impulses of all points; the iterations of
  /// iterate_pair(), each pair until its changes are small. Returns the largest change of speed.
  void (*prepare_pairs)(const PairLanes&);
  void (*push_pairs)(const PairLanes&);
  double (*solve_pairs)(const PairLanes&);
  /// to -= factor row.
  void (*subtract_row)(double* to, const double* row, double factor, std::size_t count);
};

/// The fastest set for this machine; the environment variable PANTIN_KERNELS selects another.
const Kernels& kernels();
/// All sets that this machine supports, slowest first; terminated by null.
const Kernels* const* all_kernels();

}  // namespace pantin::detail::articulated
