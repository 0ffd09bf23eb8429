#pragma once
/// Shared by the files of the Lagrangian solver. Names follow the equations
///
///   M a = f + J^T lambda,   J a = gamma
///
/// with twists V = (velocity, spin) and accelerations a of all bodies, world axes.
#include <span>

#include "engine/solvers/lagrangian/jacobian.hpp"
#include "engine/world/world.hpp"

namespace pantin::lagrangian {

/// Chooses the order of elimination and lays out the factor. Once a structure.
/// Without hubs its pivots tell the rank.
KktPattern make_pattern(const Island& m, bool may_have_hubs = true);

/// Which of the row arrays are wanted.
struct Want {
  bool c = true, gamma = true;
};

/// Poses and twists in `room.state` to what rows and masses need: rotation matrices, world inertia.
void place(Island& m);
/// Rows of all blocks at the placed bodies. Inactive limits have a Jacobian of zeros.
void write_all_rows(const World& world, Island& m, Want want);
/// Where frames are at `part` (0 to 1) of a step of `h` that ends at World::time + h, with their
/// twists, and their accelerations in `room.motion` behind those of the bodies.
void place_frames(const World& world, Island& m, Real part, Real h);
/// Forces and torques on the bodies at the placed state, into room.force. The gyroscopic torque is
/// left out where the integrator keeps momenta.
void add_forces(const World& world, Island& m, bool gyroscopic);

/// Force or torque along a freedom, and how it falls with the coordinate and its rate.
struct Pull {
  Real effort = 0, stiffness = 0, damping = 0;
};
/// `secant`: slopes towards the state without effort, which bound efforts that saturate.
Pull pull_of(const Freedom& freedom, Real coordinate, Real rate, bool secant);
/// Efforts as forces at the placed state, added to room.force.
void push_efforts(const World& world, Island& m);
/// The stiffest effort of all by the rows as placed, over what it moves: 1/s^2 and 1/s.
struct Stiffness {
  Real spring = 0, damper = 0;
};
Stiffness stiffness_of(const World& world, const Island& m);
/// Efforts as rows: what they should bear goes to `asked`, how they give way to room.weights.
/// `by_way`, `by_speed`: how coordinates and rates follow the unknown acceleration.
void meet_efforts(const World& world, Island& m, std::span<Real> asked, Real by_way,
                  Real by_speed, bool secant);
/// ... of a step of `h` whose unknowns are twists and impulses: efforts as they will be at its end,
///
///   rate + impulse / (h (h k + c)) = (effort + c rate_before) / (h k + c)
void meet_efforts_at_end(const World& world, Island& m, std::span<Real> right, Real h);
/// The joint's coordinate with its Jacobian, between the mechanism's bodies as placed.
struct CoordinateRow {
  Real value = 0, gamma = 0;
  Vec3 j[4];
  Real rate = 0;
};
CoordinateRow coordinate_row(const World& world, const Island& m, std::uint32_t link,
                             Coordinate which, std::uint32_t a, std::uint32_t b, Real before);

/// What room.jacobian keeps of a block.
inline const Vec3* jacobian_of(const Island& m, const Block& b) {
  return &m.room.jacobian[b.first_vector];
}

/// The matrix into room.values, and in room.scales the diagonal of J M^-1 J^T: rows of lengths and
/// rows of angles may be far apart in size.
void assemble(Island& m);
/// Factors J M^-1 J^T of the rows as written. Redundant rows are noted in m.faults if `report`.
void factor(Island& m, bool report);
/// Rank and redundant rows where bodies are hubs: by a pattern without them, which takes long, so
/// that it is done when the motion begins.
void find_rank(Island& m);
/// ... with rows that give way by `weight` of their diagonal.
void factor_soft(Island& m, Real weight);
/// With the factor as it stands: M a = force + J^T lambda, J a + diag(weights) lambda = right.
/// `accelerations` holds two vectors a body of the mechanism (frames are known and belong into
/// `right`). Where there are loops, refined against the rows as they are now until no more than
/// `enough` of what was asked is left. Returns the worst |right - J a|, relative to what was asked.
inline constexpr Real kExact = 2e-13;
Real solve(Island& m, std::span<const Vec3> force, std::span<const Real> right,
           std::span<Vec3> accelerations, std::span<Real> lambda, Real enough = kExact);

/// Loads alone, without refinement: (J M^-1 J^T) lambda = right with the factor as it stands.
void loads_for(Island& m, std::span<const Real> right, std::span<Real> lambda);

/// A part of a step: from `from` seconds after its start, `h` long; the step is `whole` long.
struct Span {
  Real from = 0, h = 0, whole = 0;
  Real part(Real c) const { return (from + c * h) / whole; }
};

/// Accelerations at the state as it stands, into room.motion and room.lambda.
void accelerate(const World& world, Island& m, Real part, Real whole);

/// Takes what frames do off the right-hand side: J V of their twists, or J a of their accelerations.
void take_known(Island& m, std::span<Real> right, bool accelerations);
/// J V of all bodies as placed.
Real rate_of(const Island& m, const Block& b, std::size_t row);

/// Moves bodies back onto their joints and twists into their directions, where frames are at `part`
/// of the step: the least mass-weighted change. Rows are left written. False: joints stay open.
bool project(const World& world, Island& m, Real part, Real whole);
/// ... twists only; `wanted` holds rates by row, or is empty.
void project_twists(Island& m, std::span<const Real> wanted);

/// As long as asked. What no part of the step was short enough for is done by Euler, which loses
/// energy but does not blow up; in the end with joints that stay open a little.
bool advance(const World& world, Island& m, const Span& span);

/// Which limits bear from the start, by the rows as written: those that are met and not being left.
void begin_limits(const World& world, Island& m);
/// A step among limits: as far as the first that is reached, then on with what is left.
bool advance_among_limits(World& world, Island& m, Real h);

/// Bounds on residuals that count as none.
Real tolerance_of(const Island& m);
Real worst_residual(const Island& m);
bool bears(const Island& m, std::size_t block);
/// Numbers, and not beyond 1e12 m, 1e9 m/s or 1e9 rad/s.
bool is_within_bounds(const Motions& motions, std::size_t body);
bool all_within_bounds(const Island& m);

}  // namespace pantin::lagrangian
