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

/// Asserts how an island is packed, and what an elimination takes for granted; nothing where builds
/// are not checked (invariants.cpp).
void assert_packed(const Island& m);
void assert_factorable(const KktPattern& p);

/// Symbolic factorisation: elimination order and layout of the factor, once per structure. Without
/// hubs its pivots reveal the rank, but it is slow.
enum class Hubs : std::uint8_t { none, allowed };
KktPattern make_pattern(const Island& m, Hubs hubs);

/// Row arrays to compute.
struct Want {
  bool c = true, gamma = true;
};

/// Forward kinematics: rotation matrices and world inertia from `scratch.state`.
void update_kinematics(Island& m);
/// Inverses of inertia with moments of at least the part `least` of the body's largest; until
/// update_kinematics().
void thicken(Island& m, Real least);
/// Evaluates the rows of all blocks. Inactive limits have a zero Jacobian.
void write_all_rows(const World& world, Island& m, Want want);
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
/// After the spring pins of an island were listed.
void count_pins(Island& m);
/// Adds those of spring pins: at the current state, or as they are at the end of
/// scratch.forces_over.
void add_pin_forces(const World& world, Island& m);
/// Adds joint forces at the current state to scratch.force.
void add_joint_forces(const World& world, Island& m);
/// The stiffest joint force at the current rows, relative to the mass it moves: 1/s^2 and 1/s.
struct Stiffness {
  Real spring = 0, damper = 0;
  /// Whether explicit integration by `h` is unstable.
  bool is_long(Real h) const { return h * h * spring + 2 * h * damper > 4; }
};
/// The most parts that a step is divided into before another integrator takes it.
inline constexpr int kMostParts = 64;
Stiffness stiffness_of(const World& world, const Island& m);
/// Likewise of spring pins, at most, at the current kinematics.
Stiffness stiffness_of_pins(const World& world, const Island& m);
/// Likewise of drives and soft stops.
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
/// Torque of a joint's drive and soft stops on its body b, N m, at the current state, minus its
/// derivatives by a turn and by a spin of b relative to a, and axes along which these act.
struct JointTorque {
  Vec3 torque{0};
  Mat3 stiffness{0}, damping{0};
  Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
};
JointTorque torque_of(const World& world, const Island& m, const BodyPairForce& joint);
/// Adds those of all joints to scratch.force: at the current state, or as they are at the end of
/// scratch.forces_over.
void add_joint_torques(const World& world, Island& m);
/// Slopes of the forces of all compliant rows at the current state, by row: N/m and N s/m, or
/// N m/rad and N m s/rad; and what a force on a row accelerates it by, 1/kg or 1/(kg m^2).
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
/// since rows of lengths and of angles may differ in scale.
/// `share` of a body's inverse mass, by body; or none, where all of it counts.
void assemble(Island& m, std::span<const Real> share = {});
/// Factors J M^-1 J^T at the current rows; the second also lists redundant rows in m.faults.
void factor(Island& m);
void factor_and_report(Island& m);
/// By row, how nearly the factor finds it dependent on those before it: its scale over its pivot; 0
/// where it is off or compliant.
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
/// Takes from multipliers what moves no body, with the current factor; scratch.solution and
/// scratch.right are overwritten. Where rows are dependent, residuals of second order disagree, and
/// the regularised factor makes large multipliers of that. They move nothing as long as the
/// Jacobian is the same, but everything in the next step.
void keep_moving_part(Island& m, std::span<Real> lambda);

/// A substep that begins `from` seconds after the start of the step and lasts `h`; the step lasts
/// `whole`.
struct Span {
  Real from = 0, h = 0, whole = 0;
  Real fraction(Real c) const { return (from + c * h) / whole; }
};

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

/// Whether the step took so many factorisations that no part of it is halved again, nor the step
/// repeated.
inline bool is_dear(const Island& m) { return m.solves > 4000; }

/// Advances by the requested time. Where no substep is short enough it falls back to Euler, which
/// dissipates but is stable; as a last resort joints may stay open a little.
bool advance(const World& world, Island& m, const Span& span);

/// Initial active set: limits that are reached and not being left, at the current rows.
void begin_active_set(const World& world, Island& m);
/// A step with limits: to the first event, then the remainder.
bool advance_among_limits(World& world, Island& m, Real h);

/// A copy of an island as at the start of a step, where nothing has been stepped yet.
void place_for_inspection(const World& world, Island& m, Real h);

/// Residuals below this bound count as zero.
Real tolerance_of(const Island& m);
Real worst_residual(const Island& m);
bool is_active(const Island& m, std::size_t block);
/// Takes over the state of an earlier build by the bodies and blocks of an island (carry_over.cpp).
void carry_memory(const World& world, std::vector<Island>& before, Island& m);
/// The length of a cable as a row, m (cables.cpp).
void write_cable_length(const World& world, const Island& m, const Block& block, RowsOut out);
/// After a step: counts the turns of cables on their pulleys, and lists those that are wrong.
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
/// After a step: where belts are, and their tensions.
void follow_belts(World& world, Island& m);
/// Adds the forces of elastic cables over guides.
void add_path_forces(const World& world, Island& m);
/// Finds the places of contacts of surfaces that are not known, or may be other ones by now, at
/// the start of a step of `h` (surface_places.cpp).
void find_touches(const World& world, Island& m, Real h);
/// Whether a pair of curves that was lost in this part of a step may give way to another one there:
/// a side that lies down flat.
bool may_turn_over(const World& world, Island& m);
/// Whether a contact that touched before the step has sunk into the other surface where no place
/// tells: it is lost (surface_sweep.cpp).
bool any_sank(const World& world, Island& m);
/// Looks at all pairs again, where the bodies are now.
void look_for_touches(const World& world, Island& m, Real h);
/// Where surfaces touch on either at the start of a part of a step; and whether they have come so
/// far along one since that the part is too long: a normal that turns fast is a blow.
void note_touches(const World& world, Island& m);
bool touches_leap(const World& world, Island& m, Real h);
/// How the normal of a contact turns as seen from either body, where no gamma told of it.
void find_turning(const World& world, Island& m, std::size_t block);
/// The pair near `from`, of surfaces or curves.
nurbs::CommonNormal track_pair(const SurfaceContact& contact, const Pose& a_in_b,
                               const nurbs::PlacePair& from);
/// Finds the contacts whose gap follows from their rolling and all other joints, as that of gears
/// on fixed axes does.
void find_following_gaps(const World& world, Island& m, Real h);
/// The rows of a contact of surfaces, and of its rolling.
void write_surface(const World& world, Island& m, std::size_t block, Want want);
/// Rows of rolling bind nothing.
void clear_rolling(Island& m);
/// The contact that was lost in the step lets go, if its joint says so.
bool release_lost(const World& world, Island& m);
// Friction where surfaces touch (surface_friction.cpp). `block` is of rolling, `lambda` by row.

/// At the current rows: what slips, slips; the rest holds.
void begin_slips(Island& m);
/// At the start of a part of a step of `h`: friction acts against the slips as they are now.
void turn_slips(Island& m, Real h);
/// The same within an impact.
void aim_slips(Island& m);
/// m/s: how fast it slips along the way of its slip; below 0 where that has ended. Far from 0
/// where nothing slips.
Real slip_left(const Island& m, std::size_t block);
bool has_slip_ended(const Island& m, std::size_t block, Real tolerance);
/// Slips of no more than `tolerance` along their ways have ended: they hold, or go on in another.
void end_slips(Island& m, Real tolerance);
/// What holds by more than friction can, and by more than `least`, gives way; what gave way and
/// does not slip holds. True: any.
bool yield_holding(Island& m, std::span<const Real> lambda, Real least = 0);
/// N: what friction may still take where it holds; far from 0 where it does not, or holds anyway.
Real grip_left(const Island& m, std::size_t block, std::span<const Real> lambda);
/// What holds gives way, against the force that held it.
void give_way_at(Island& m, std::size_t block, std::span<const Real> lambda);
/// What presses the surfaces together, from forces or impulses. Returns by how much that is other
/// than before where they slip, relative.
Real set_grips(Island& m, std::span<const Real> lambda);
/// Adds the friction of what slips to scratch.force.
void add_slip_forces(Island& m);
/// Adds to `load`, two vectors a body, what friction changes by as scratch.lambda tells, forces
/// times `h`. Returns by how much, N; 0 where that does not count.
Real raise_grips(Island& m, Real h, std::span<Vec3> load);
/// Takes all friction from `load` again: what slips is jammed, and holds in the next attempt.
void jam_slips(Island& m, Real h, std::span<Vec3> load);
/// Solutions for the friction of a step.
inline constexpr int kMostGrips = 40;
/// Those after which friction that still grows jams.
inline constexpr int kSureGrips = 4;
/// Solves anew until friction agrees with what presses surfaces together.
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

// Events where surfaces touch (surface_events.cpp).

/// After a substep: the end of the first one that, in the mean, pulls at what may lift off or takes
/// more than friction gives.
void note_pulls(Island& m, const Span& span);
/// The same where one may do so at `end`, that of what was taken: as the forces go on that changed
/// from scratch.lambda_before.
void note_ends(Island& m, Real end);
/// The least that is left, in the present state, of what presses surfaces together and of friction
/// that holds, N; below 0 where one pulls, or takes more than friction gives.
Real least_left(const World& world, Island& m, Real part, Real whole);
/// Those with least left bear no more, or slip.
void let_go(const World& world, Island& m, Real part, Real whole);
/// What ends within another bears in the next attempt. True: any.
bool hold_within(Island& m);
/// How fast surfaces come apart at the start of a part of a step.
void note_openings(Island& m);
/// Euler falls by g h^2 where others fall by half of that, so what leaves a surface that bends away
/// ends within it. Where neither start nor end of the part came nearer its pose is set back, and
/// what that lifts is paid. False: it cannot be.
bool set_back(const World& world, Island& m, const Span& span);

// What surfaces meet on their way (surface_sweep.cpp).

/// Where they stand at the start of a part of a step.
void note_sweep(const World& world, Island& m);
/// After which part of it surfaces that may lift off are within one another where no place tells of
/// it: 1 at its end, where none follows them; less on the way; 2: nowhere.
Real met_unseen(const World& world, Island& m);

/// Results of contacts of surfaces, to the World.
void write_back_touches(World& world, Island& m);
/// Their forces alone, which contacts have changed.
void write_back_touch_forces(World& world, Island& m);
// Impacts (limits.cpp, blows.cpp).

/// A limit violated by less counts as reached, m or rad.
inline constexpr Real kLimitTolerance = 1e-9;

/// Whether impacts return a part of the speed, as the joints say, or none.
enum class Impact : std::uint8_t { with_restitution, inelastic };
/// Impact at the limits reached, for the whole island at once.
void resolve_impacts(const World& world, Island& m, Impact kind);
/// The same within a step: the first ones with restitution.
void hit(const World& world, Island& m);
/// Of the active unilateral rows, which are written, those that are hit stay active, `bias` being
/// the rates after the impact; scratch.blow.resting are those that it does not leave.
void choose_hit(const World& world, Island& m, std::span<const Real> bias);
void allocate_blows(Island& m);

// Bounds that are passed (bounds.cpp).

/// How fast a limit or cable that binds nothing opens, m/s or rad/s.
Real opening_rate(const World& world, Island& m, std::size_t block);
/// A part of a step begins on its constraints: where contacts, or an event too many, left limits
/// and cables beyond their bounds, these are hit now and closed. Multipliers of poses would make
/// speed of it. False: it cannot be.
bool begin_on_bounds(const World& world, Island& m, const Span& at);
/// What limits and cables do at the start of a part of a step of `h`.
void note_bounds(const World& world, Island& m, Real h);
/// When a limit passes its bound in a part of a step, in parts of its length, as its ends tell: it
/// falls from `low`, where it is `at_low`, to `high`. Beyond 1: none does.
struct Passing {
  Real low = 0, high = 1, guess = 2, at_low = 0;
};
/// The first one in a part of `h`, now at its end.
Passing find_passing(const World& world, Island& m, Real h);

/// Unilateral rows: cables, limits that are not locks, surfaces that may lift off.
inline bool is_one_sided(const Island& m, std::size_t block) {
  const Block& b = m.blocks[block];
  return ((b.kind == BlockKind::limit || b.kind == BlockKind::surface) && !b.lock) ||
         b.kind == BlockKind::cable;
}
/// J, of the bodies of an island in this motion.
Real kinetic_energy(const Island& m, const Motions& s);
/// Whether nothing that the island is joined to moves.
bool stands_on_rest(const Island& m);
/// Takes from the motion what the projection lifted, where nothing else can have paid for it:
/// `before` is the kinetic energy before, J. False: there was not as much, or the step of a free
/// island, whose momentum stays as it is, gained and is to be cut.
bool pay_projection(Island& m, Real before);
/// scratch.state of the World's bodies, back to them.
void write_back(World& world, const Island& m);
/// Finite, and at most 1e12 m, 1e9 m/s and 1e9 rad/s.
bool is_within_bounds(const Motions& motions, std::size_t body);
bool all_within_bounds(const Island& m);

}  // namespace pantin::detail::lagrangian
