#pragma once
/// Declarations shared by the files of the Lagrangian solver. Names follow the equations
///
///   M a = f + J^T lambda,   J a = gamma
///
/// with twists V = (velocity, angular velocity) and accelerations a of all bodies, world axes.
#include <span>

#include "engine/joints/joint_force.hpp"
#include "engine/solvers/lagrangian/jacobian.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::lagrangian {

/// Assert the layout of an island, and the preconditions of an elimination; empty in unchecked
/// builds (invariants.cpp).
void assert_packed(const Island& m);
void assert_factorable(const KktPattern& p);

/// Symbolic factorisation: elimination order and layout of the factor, once per structure. Without
/// hubs its pivots reveal the rank, but it is slow.
enum class Hubs : std::uint8_t { none, allowed };
KktPattern make_pattern(const Island& m, Hubs hubs);

/// Row arrays to compute. Without `jacobian`, joints and pins keep theirs; all others write it.
struct Want {
  bool c = true, gamma = true, jacobian = true;
};

/// Forward kinematics: rotation matrices and world inertia from `scratch.state`.
void update_kinematics(Island& m);
/// Recomputes the inverse inertia with moments of at least `least` times the body's largest; valid
/// until update_kinematics().
void regularise_inertia(Island& m, Real least);
/// Evaluates the rows of all blocks. Inactive limits have a zero Jacobian.
void write_all_rows(const World& world, Island& m, Want want);
/// The same for one block. Rolling is written with the surface block before it.
void write_block(const World& world, Island& m, std::size_t block, Want want);
/// Poses and twists of frames at the fraction `part` (0 to 1) of a step of `h` that ends at
/// World::time + h. Their accelerations follow those of the bodies in `scratch.motion`.
void update_frames(const World& world, Island& m, Real part, Real h);
/// Applied forces and torques at the current state, into scratch.force. Integrators in momenta take
/// them without the gyroscopic torque.
enum class Torques : std::uint8_t { applied, with_gyroscopic };
void add_forces(const World& world, Island& m, Torques torques);

/// A force on body a, N, and the opposite one on body b, at arms from their mass centres, m; world
/// axes.
struct OppositeForces {
  Vec3 on_a, arm_a, arm_b;
};
/// Adds equal and opposite forces at points of two bodies to scratch.force.
void add_pair_force(Island& m, const BodyPairForce& p, const OppositeForces& forces);
/// Counts the spring pins at each body (BodyPairForce::beside), once they are listed.
void count_pins(Island& m);
/// Adds the forces of spring pins: at the current state, or as at the end of scratch.forces_over.
void add_pin_forces(const World& world, Island& m);
/// Adds joint forces at the current state to scratch.force.
void add_joint_forces(const World& world, Island& m);
/// The stiffest joint force at the current rows, relative to the mass it moves: 1/s^2 and 1/s.
struct Stiffness {
  Real spring = 0, damper = 0;
  /// Whether explicit integration by `h` is unstable.
  bool is_long(Real h) const { return h * h * spring + 2 * h * damper > 4; }
};
/// Substeps that a step is divided into at most, before another integrator takes it.
inline constexpr int kMostParts = 64;
Stiffness stiffness_of(const World& world, const Island& m);
/// An upper bound of the same for spring pins, at the current kinematics.
Stiffness stiffness_of_pins(const World& world, const Island& m);
/// The same for drives and soft stops.
Stiffness stiffness_of_torques(const World& world, const Island& m);
/// Joint forces as rows: forces into `requested`, compliances into scratch.weights. `by_way` and
/// `by_speed` are the derivatives of coordinate and rate by the unknown acceleration.
struct ImplicitForce {
  Real by_way = 0, by_speed = 0;
  Slope slope = Slope::tangent;
};
void write_joint_force_rows(const World& world, Island& m, std::span<Real> requested,
                            const ImplicitForce& by);
/// The same for a step of `h` whose unknowns are twists and impulses, with joint forces at its end:
///
///   rate + impulse / (h (h k + c)) = (effort + c rate_before) / (h k + c)
void write_joint_force_rows_at_end(const World& world, Island& m, std::span<Real> right, Real h);
/// After a part of a step with contacts, with rows of springs: notes in scratch.held which motors
/// are at their bounds. Whether any has changed.
bool hold_motors(const World& world, Island& m);
/// Torque of a joint's drive and soft stops on its body b, N m, at the current state. Also minus
/// its derivatives by rotation and angular velocity of b relative to a, and the axes along which
/// these act.
struct JointTorque {
  Vec3 torque{0};
  Mat3 stiffness{0}, damping{0};
  Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
};
JointTorque torque_of(const World& world, const Island& m, const BodyPairForce& joint);
/// Adds the torques of all joints to scratch.force: at the current state, or as at the end of
/// scratch.forces_over.
void add_joint_torques(const World& world, Island& m);
// Exact drives (drives.cpp). Those with a maximum torque may yield.

/// The state of a drive's block.
inline const DriveLag& lag_of(const Island& m, const Block& drive) {
  return m.frames[drive.body[2] - m.count()].lag;
}
/// A frame takes over its state at the end of a step.
void note_end(const World& world, Frame& frame, const BodyState& at);
/// The coordinate that a drive's frame requires at `time`.
CoordinateMotion drive_motion(const World& world, const Frame& frame, Real time);
/// Writes the row of a drive.
void write_drive(const World& world, Island& m, std::size_t block);
/// At the start of a step of `h`, at the state in scratch.state: how far each drive is behind.
void begin_drives(const World& world, Island& m, Real h);
/// After a step of `h`: lets drives yield that needed more than their maximum torque, or all others
/// if the step failed. True if any did: the step has to be repeated.
bool yield_drives(const World& world, Island& m, Real h, StepOutcome outcome);
/// Whether a drive is a row now that could yield.
bool may_yield(const World& world, const Island& m);
/// Adds the forces of drives that yield to scratch.force.
void add_drive_forces(const World& world, Island& m);
/// Before contacts: drives that may yield do so, with the force of the step, since a constraint
/// would leave no motion for contacts to stop.
void release_drives(const World& world, Island& m);
/// After contacts: writes the torques of drives to the World.
void note_drives(World& world, Island& m);
/// Slopes of the forces of all compliant rows at the current state, by row: N/m and N s/m, or N
/// m/rad and N m s/rad. Mobility: acceleration by a unit force on the row, 1/kg or 1/(kg m^2).
struct ForceSlopes {
  std::span<Real> stiffness, damping, mobility;
};
void find_force_slopes(const World& world, Island& m, const ForceSlopes& slopes);
/// The coordinate of a joint force with its Jacobian at the current state.
struct CoordinateRow {
  Real value = 0, gamma = 0;
  Vec3 j[4];
  Real rate = 0;
};
CoordinateRow coordinate_row(const World& world, const Island& m, const JointForce& of);

/// The Jacobian of a block.
inline const Vec3* jacobian_of(const Island& m, const Block& b) {
  return &m.scratch.jacobian[b.first_vector];
}

/// Assembles the matrix into scratch.values and the diagonal of J M^-1 J^T into scratch.scales,
/// since rows of lengths and of angles may differ in scale. `share`: fraction of each body's
/// inverse mass that counts; none: all of it.
void assemble(Island& m, std::span<const Real> share = {});
/// Factors J M^-1 J^T at the current rows; the second also lists redundant rows in m.faults.
void factor(Island& m);
void factor_and_report(Island& m);
/// By row, its scale over its pivot in the factor: large if it nearly depends on the rows before
/// it. 0 where it is inactive or compliant.
void note_dependence(const Island& m, std::span<Real> by_row);
/// Rank and redundant rows of islands with hubs, by a pattern without hubs. Slow, hence only when
/// the motion begins.
void find_rank(Island& m);
/// The same with every row regularised by `weight` times its diagonal.
void factor_soft(Island& m, Real weight);
/// Forces and torques, two vectors a body or none at all, and the right-hand side of the rows,
/// which includes the motion of frames.
struct Known {
  std::span<const Vec3> force;
  std::span<const Real> right;
};
/// Accelerations, twists or corrections, two vectors a body, and the multipliers.
struct Unknowns {
  std::span<Vec3> motion;
  std::span<Real> lambda;
};
/// Solves M a = force + J^T lambda, J a + diag(weights) lambda = right with the current factor.
/// With loops the solution is refined until the relative residual is below `tolerance`. Returns the
/// largest |right - J a| relative to its terms.
inline constexpr Real kSolveTolerance = 2e-13;
Real solve(Island& m, const Known& known, const Unknowns& found, Real tolerance = kSolveTolerance);

/// Multipliers only, without refinement: (J M^-1 J^T) lambda = right with the current factor.
void solve_lambda(Island& m, std::span<const Real> right, std::span<Real> lambda);
/// Removes the part of the multipliers that moves no body, with the current factor; overwrites
/// scratch.solution and scratch.right. If rows are dependent, second-order residuals contradict
/// each other and the regularised factor turns them into large multipliers. With an unchanged
/// Jacobian these move nothing, but they disturb the next step.
void keep_moving_part(Island& m, std::span<Real> lambda);

/// A substep that begins `from` seconds after the start of the step and lasts `h`; the step lasts
/// `whole`.
struct Span {
  Real from = 0, h = 0, whole = 0;
  Real fraction(Real c) const { return (from + c * h) / whole; }
};

/// Whether no frame moves in a substep. A function of the World, not of the frames' last motion.
bool frames_rest(const World& world, const Island& m, const Span& span);

/// Accelerations at the current state, into scratch.motion and scratch.lambda.
void accelerate(const World& world, Island& m, Real part, Real whole);

/// Subtracts the motion of frames from the right-hand side: J V of their twists, or J a of their
/// accelerations.
void subtract_frame_twists(Island& m, std::span<Real> right);
void subtract_frame_accelerations(Island& m, std::span<Real> right);
/// J V at the current state.
Real rate_of(const Island& m, const Block& b, std::size_t row);

/// Mass-orthogonal projection of poses and twists onto the constraints, with frames at the fraction
/// `part` of the step. Rows are evaluated on return. False: joints stay open.
bool project(const World& world, Island& m, Real part, Real whole);
/// Projects twists only; `bias` holds the required rates by row, or is empty.
void project_twists(Island& m, std::span<const Real> bias);

/// Whether the step took so many factorisations that it is neither divided further nor repeated.
inline bool is_expensive(const Island& m) { return m.solves > 4000; }

/// Advances by the requested time. Where no substep is short enough it falls back to Euler, which
/// dissipates but is stable; as a last resort joints may stay open a little.
bool advance(const World& world, Island& m, const Span& span);

/// Initial active set: limits that are reached and not opening, at the current rows.
void begin_active_set(const World& world, Island& m);
/// A step with limits: to the first event, then the remainder.
bool advance_among_limits(World& world, Island& m, Real h);

/// Updates BlockMemory::before of gears, belts, screws and limited angles at the current
/// kinematics. What has not counted yet begins at the nearest revolution, unless the travel of a
/// screw or rack determines it; gears without an offset then take it from the current poses.
void count_turns(const World& world, Island& m);
/// Makes all count anew.
void forget_turns(Island& m);

/// Prepares a copy of an island as at the start of a step, before any step was taken.
void place_for_inspection(const World& world, Island& m, Real h);

/// Residuals below this bound count as zero.
Real tolerance_of(const Island& m);
Real worst_residual(const Island& m);
/// Whether a block is one of rows now: for kinds that may be none.
bool is_active_now(const Island& m, std::size_t block);
inline bool is_active(const Island& m, std::size_t block) {
  const Block& b = m.blocks[block];
  const bool always = b.kind == BlockKind::pin || (b.kind == BlockKind::joint && b.holonomic);
  return always || is_active_now(m, block);
}
/// How gears and belts of the last build mesh: their counted turns, and offsets found.
class Meshes {
 public:
  Meshes(const World& world, const std::vector<Island>& before);
  void carry(const World& world, Island& m) const;

 private:
  using Key = std::tuple<BlockKind, std::uint32_t, std::uint32_t>;  // slot now, pulley
  struct Mesh {
    Key key;
    Real bound = 0;
    BlockMemory memory;
  };
  void add(const Block& b, std::uint32_t now, const BlockMemory& memory);

  std::vector<Mesh> all_;  // sorted
};
/// Takes over the state of an earlier compilation, by bodies and blocks (carry_over.cpp).
void carry_memory(const World& world, const Meshes& meshes, std::vector<Island>& before, Island& m);
/// The length of a cable as a row, m (cables.cpp).
void write_cable_length(const World& world, const Island& m, const Block& block, RowsOut out);
/// After a step: counts the turns of cables on their pulleys, and lists inconsistent ones.
void follow_cables(World& world, Island& m, Real h);
/// A span of a belt as a row, m (belts.cpp).
void write_belt(const World& world, const Island& m, std::size_t block, RowsOut out);
/// One of the two pulleys of a span, and its angle before, rad.
struct BeltEnd {
  const Block& block;
  std::size_t end;
  Real before;
};
/// Its angle now, rad.
Real belt_angle(const World& world, const Island& m, const BeltEnd& of);
/// After a step: stores the positions and tensions of belts.
void follow_belts(World& world, Island& m);
/// Adds the forces of elastic cables over guides.
void add_path_forces(const World& world, Island& m);
/// Finds the contact points of surface joints that are unknown or outdated, at the start of a step
/// of `h` (surface_places.cpp).
void find_touches(const World& world, Island& m, Real h);
/// Whether a pair of curves that was lost in this substep may be replaced by another: a side that
/// becomes a face contact.
bool may_turn_over(const World& world, Island& m);
/// Whether a contact that was active before the step penetrates at an untracked pair: it is lost
/// (surface_sweep.cpp).
bool any_sank(const World& world, Island& m);
/// Searches all pairs at the current poses.
void look_for_touches(const World& world, Island& m, Real h);
/// Records the contact points on both surfaces at the start of a substep; and whether they have
/// travelled too far since. A fast rotation of the normal acts like an impact, so the substep is
/// too long.
void note_touches(const World& world, Island& m);
bool touches_leap(const World& world, Island& m, Real h);
/// Rates of a contact's normal as seen from either body, if no gamma has computed them.
void find_turning(const World& world, Island& m, std::size_t block);
/// Tracks the pair from `from`, of surfaces or curves.
nurbs::CommonNormal track_pair(const SurfaceContact& contact, const Pose& a_in_b,
                               const nurbs::PlacePair& from);
/// Finds the surface joints whose gap follows from rolling and all other joints, as for gears on
/// fixed axes.
void find_following_gaps(const World& world, Island& m, Real h);
/// Writes the rows of a joint that constrains velocities only.
void write_slip(const World& world, Island& m, std::size_t block, RowsOut out);
/// Writes the rows of a surface joint, and of its rolling.
void write_surface(const World& world, Island& m, std::size_t block, Want want);
/// Clears the rows of rolling that constrain velocities only.
void clear_rolling(Island& m);
/// Releases the surface joint that was lost in the step, if its joint says so.
bool release_lost(const World& world, Island& m);
/// Finds the joint that carries one that may slip by a coefficient of friction, which is divided
/// among those on it later. False: there is none, or more than one.
bool find_carrier(Island& m, std::size_t block);
/// N or N s: force along the contact's normal that a carrier exerts, signed.
Real load_of(const Island& m, const Block& slip, std::span<const Real> lambda);
// Friction of surface joints and of joints that may slip (surface_friction.cpp). `block` is of
// rolling or such a joint, `lambda` by row.

/// Initial state at the current rows: contacts with slip velocity slip, the others stick.
void begin_slips(Island& m);
/// At the start of a substep of `h`: friction opposes the current slip.
void update_slip_directions(Island& m, Real h);
/// The same within an impact.
void aim_slips(Island& m);
/// m/s: slip speed along the slip direction; below 0 after its reversal. 1e300 where nothing slips.
Real slip_left(const Island& m, std::size_t block);
bool has_slip_ended(const Island& m, std::size_t block, Real tolerance);
/// Ends slips of no more than `tolerance` along their direction: they stick, or change direction.
void end_slips(Island& m, Real tolerance);
/// Lets contacts slip where sticking needs more than mu N plus `least`. Contacts that started to
/// slip in this substep, but in the wrong direction, stick again. True: any changed.
bool yield_holding(Island& m, std::span<const Real> lambda, Real least = 0);
/// N: mu N minus the friction force while it sticks; 1e300 if it slips, or sticks at any force.
Real grip_left(const Island& m, std::size_t block, std::span<const Real> lambda);
/// Starts to slip, against the force of sticking.
void release_sticking(Island& m, std::size_t block, std::span<const Real> lambda);
/// Sets the normal forces of friction from multipliers or impulses. Returns their largest change
/// where contacts slip, relative.
Real set_grips(Island& m, std::span<const Real> lambda);
/// Adds the friction of slipping contacts to scratch.force.
void add_slip_forces(Island& m);
/// Updates friction to the multipliers in scratch.lambda: adds the change, times `h`, to `load`,
/// two vectors a body. Returns the largest change, N; 0 if it is negligible.
Real raise_grips(Island& m, Real h, std::span<Vec3> load);
/// Removes all friction from `load`: slipping contacts jam, and stick in the next attempt.
void jam_slips(Island& m, Real h, std::span<Vec3> load);
/// Iterations for the friction of a step.
inline constexpr int kMostGrips = 40;
/// Iterations after which friction that still grows jams.
inline constexpr int kSureGrips = 4;
/// Solves repeatedly until friction agrees with the normal forces.
template <class Solve>
void settle_grips(Island& m, Real h, std::span<Vec3> load, const Solve& solve_again) {
  Real before = 0;
  for (int n = 0; n < kMostGrips; ++n) {
    const Real change = raise_grips(m, h, load);
    if (!(change > 0)) return;
    const bool grows = n > kSureGrips && change >= before;
    if (grows) jam_slips(m, h, load);
    solve_again();
    if (grows) return;
    before = change;
  }
}

// Events of surface joints (surface_events.cpp).

/// After a substep: records the end of the first one whose mean has a tensile unilateral row, or
/// friction beyond mu N.
void note_pulls(Island& m, const Span& span);
/// The same if that is to be expected at `end`, the end of the substeps taken: extrapolates the
/// change of forces since scratch.lambda_before.
void note_ends(Island& m, Real end);
/// The least margin in the present state, N: of compressive multipliers, and of friction that
/// sticks. Below 0 where one is tensile, or friction exceeds mu N.
Real least_left(const World& world, Island& m, Real part, Real whole);
/// Releases the contacts with the least margin, or lets them slip.
void let_go(const World& world, Island& m, Real part, Real whole);
/// Activates penetrating contacts for the next attempt. True: any.
bool activate_penetrating(Island& m);
/// Records the opening speeds of surfaces at the start of a substep.
void note_openings(Island& m);
/// Euler falls by g h^2, the exact motion by half of that, so a contact that leaves a curved
/// surface would end in penetration. Where the surfaces approach neither at the start nor at the
/// end, poses are projected back and the energy gained is removed. False: failure.
bool project_penetrations(const World& world, Island& m, const Span& span);

// Contacts at untracked pairs within a step (surface_sweep.cpp).

/// Records the relative poses at the start of a substep.
void note_sweep(const World& world, Island& m);
/// Fraction of the substep after which unilateral surfaces penetrate at an untracked pair, or at a
/// tracked one before the end. 2: nowhere.
Real first_untracked_contact(const World& world, Island& m);

/// Writes the results of surface joints to the World.
void write_back_touches(World& world, Island& m);
/// Writes their forces alone, which contacts have changed.
void write_back_touch_forces(World& world, Island& m);
// Impacts (limits.cpp, blows.cpp).

/// A limit violated by less counts as reached, m or rad.
inline constexpr Real kLimitTolerance = 1e-9;

/// Whether impacts restore a fraction of the speed, as the joints say, or none.
enum class Impact : std::uint8_t { with_restitution, inelastic };
/// Impact at the limits reached, for the whole island at once.
void resolve_impacts(const World& world, Island& m, Impact kind);
/// The same within a step: the first impacts with restitution.
void hit(const World& world, Island& m);
/// Selects which active unilateral rows, already written, are hit and stay active; `bias` holds the
/// rates after the impact. scratch.blow.resting lists the rows that stay in contact.
void choose_hit(const World& world, Island& m, std::span<const Real> bias);
void allocate_blows(Island& m);

// Bounds that are crossed (bounds.cpp).

/// Opening rate of an inactive limit or cable, m/s or rad/s.
Real opening_rate(const World& world, Island& m, std::size_t block);
/// Starts a substep on its constraints. Contacts, or too many events, may have left limits and
/// cables beyond their bounds: these are hit now and closed. Otherwise multipliers of poses would
/// turn the violation into speed. False: failure.
bool begin_on_bounds(const World& world, Island& m, const Span& at);
/// Records gaps and rates of limits and cables at the start of a substep of `h`.
void note_bounds(const World& world, Island& m, Real h);
/// Where a limit crosses its bound within a substep, as fractions of its length, by interpolation
/// of both ends. It falls from `low`, where its gap is `at_low`, to `high`. Guess beyond 1: none
/// crosses.
struct Passing {
  Real low = 0, high = 1, guess = 2, at_low = 0;
};
/// The first one in a substep of `h`, now at its end.
Passing find_passing(const World& world, Island& m, Real h);

/// Unilateral rows: cables, limits that are not locks, surface joints that may lift off.
inline bool is_one_sided(const Island& m, std::size_t block) {
  const Block& b = m.blocks[block];
  return ((b.kind == BlockKind::limit || b.kind == BlockKind::surface) && !b.lock) ||
         b.kind == BlockKind::cable;
}
/// Kinetic energy of the bodies of an island in this state, J.
Real kinetic_energy(const Island& m, const Motions& s);
/// Removes from the kinetic energy what the projection added as potential energy, unless something
/// else may have paid for it. `before`: kinetic energy before, J. False: there is too little, or a
/// free island gained energy (its momentum is kept, so the step must be cut).
bool remove_projection_energy(Island& m, Real before);
/// Writes scratch.state of the bodies back to the World.
void write_back(World& world, const Island& m);
/// Finite, and at most 1e12 m, 1e9 m/s and 1e9 rad/s.
bool is_within_bounds(const Motions& motions, std::size_t body);
bool all_within_bounds(const Island& m);

}  // namespace pantin::detail::lagrangian
