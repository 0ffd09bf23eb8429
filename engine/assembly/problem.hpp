#pragma once
/// The laws of a World that fix poses, as a least-squares problem in the poses of its bodies.
///
///   minimise  sum of C_r^2 / D_r      C: rows of the Lagrangian solver, one-sided ones where
///   violated
///
/// Steps are least in the metric W^-1 of poses: a displacement counts 1, a rotation the square of
/// the body's arm. D_r is the row's diagonal of J W J^T for unit directions, so residuals of angles
/// count as lengths at the arm.
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "engine/assembly/design.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::assembly {

/// One island: bodies that laws connect.
struct Part {
  explicit Part(lagrangian::Island island) : m(std::move(island)) {}
  Part(Part&&) = default;
  Part& operator=(Part&&) = default;
  // Poses and factor are in the scratch memory, which copies of an Island leave out.
  Part(const Part& from) : m(from.m), units(from.units), bounds(from.bounds), design(from.design) {
    static_cast<lagrangian::StepScratch&>(m.scratch) = from.m.scratch;
  }
  Part& operator=(const Part& from) { return *this = Part(from); }

  lagrangian::Island m;      // mass 1, inertia arm^2: the metric of poses
  std::vector<Real> units;   // by row: D
  std::vector<Real> bounds;  // by block: of gears without an offset, from the first poses
  Design design;
};

struct Problem {
  World world;  // a copy; held bodies are fixed, all are of the Lagrangian solver
  std::vector<Part> parts;
  std::vector<Entity> unfit;  // bodies with numbers that are not finite: their islands are no parts
};

/// Prepares the problem of a World, `held` bodies where they are, with design variables `free`. The
/// poses are those of the World.
Problem make_problem(const World& world, std::span<const Entity> held,
                     std::span<const DesignVariable> free = {});

/// A pose of every body of a part, in its order.
using Poses = std::vector<Pose>;
Poses poses_of(const Part& part);
/// Sets poses and evaluates the rows there. Whole revolutions are counted from these poses.
void set_poses(const World& world, Part& part, std::span<const Pose> poses);

/// Evaluates all rows at the current poses. Then one-sided rows are active where they are violated,
/// or where they were active and their multiplier of the last step kept them.
void look(const World& world, Part& part);
/// The same, except that joints and pins keep the Jacobian of earlier poses.
void look_at_residuals(const World& world, Part& part);
/// Whole revolutions of the poses that were accepted.
void count(const World& world, Part& part);
/// Whether a row adds to the residual: active, and violated if it is one-sided.
bool counts(const Part& part, std::size_t block);
/// Half the weighted sum of squares, m^2.
Real merit_of(const Part& part);
/// The larger of a residual so far and |c|. Not a number counts as the largest.
inline Real worse_of(Real worst, Real c) {
  const Real size = std::abs(c);
  return size <= worst || std::isnan(worst) ? worst : size;
}
/// The largest residual, m or rad.
Real worst_of(const Part& part);
/// |J^T D^-1 C| relative to |C|, in the metrics of both: 0 at a stationary point.
Real slope_of(Part& part);

/// Sets scratch.right to -C and scratch.weights to damping D for all rows that act.
void set_equations(Part& part, Real damping);
/// Solves (J W J^T + weights) lambda = right and finds the step W J^T lambda, into
/// scratch.solution, and that of the design variables. [Levenberg 1944, in dual form]
void solve_equations(Part& part);
/// The same with the factor and the weights of the last step, without design variables.
void solve_again(Part& part);
/// Both, with a new factor.
void solve_step(Part& part, Real damping);
/// The largest rotation of the step, rad.
Real turn_of(const Part& part);
/// Displaces all bodies by a fraction of the step.
void move(Part& part, Real fraction);
/// The same, and the design variables.
void displace(World& world, Part& part, Real fraction);

/// Writes the poses of a part to a World with the same bodies.
void write_poses(const Part& part, World& world);

}  // namespace pantin::detail::assembly
