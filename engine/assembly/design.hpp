#pragma once
/// Design variables of a part: numbers p of its laws that are solved for together with the poses.
///
///   minimise  dq^T W^-1 dq + dp^T S^-1 dp   subject to   J dq + G dp = -C,    G = dC/dp
///
/// With the factor of A = J W J^T + damping D, and few numbers p, by Woodbury's identity:
///
///   (S^-1 + G^T A^-1 G) dp = -G^T A^-1 C,    A lambda = -C - G dp,    dq = W J^T lambda
///
/// S weighs changes by their size: a length or pitch by itself, an anchor by the size of the
/// mechanism, an axis by 1 rad; each such change counts as much as a displacement by that size.
#include <span>
#include <vector>

#include "engine/world/design.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::lagrangian {
struct Block;
}

namespace pantin::detail::assembly {

struct Part;

/// A design variable of a part.
struct FreeQuantity {
  DesignVariable of;
  DesignValue start;      // its value at the start
  std::size_t first = 0;  // of its numbers
};

/// Displacements of numbers from their start.
struct Design {
  std::vector<FreeQuantity> all;
  std::vector<Real> numbers, before;  // at present; before the last step
  std::vector<Real> step, scale;      // of the last solve; square root of S
  Real size = 0;                      // m, of the mechanism
  std::vector<Real> room;             // how far each may rise until pulleys of a belt overlap
  std::vector<Real> slopes;           // G: all rows of the first number, of the next ...
  Real weight = 1;                    // of displacements beside changes, in the next step
  bool returns = false;               // the next step minimises the distance of p from the start

  bool any() const { return !all.empty(); }
};

/// Takes the variables that belong to laws of a part.
void find_design(const World& world, Part& part, std::span<const DesignVariable> free);

/// Whether a block has rows that depend on a design variable.
bool is_of(const lagrangian::Block& block, const DesignVariable& variable, const World& world);

/// Evaluates G at the present poses, and how far the radii of belts may grow there.
void write_slopes(const World& world, Part& part);

/// Solves for dp with the current factor, and subtracts G dp from the right-hand side in
/// scratch.right. Numbers that would pass a bound end there.
void solve_design(Part& part);

/// Sets the numbers, in the World that the rows are evaluated in.
void set_design(World& world, Part& part, std::span<const Real> numbers);
/// Displaces the numbers by a fraction of the last step, or back to where they were before it.
void move_design(World& world, Part& part, Real fraction);
void undo_design(World& world, Part& part);

/// The sum of S |G^T r|^2 for r by row: the slope of a merit in p.
Real slope_of_design(const Part& part, std::span<const Real> by_row);

/// Half the sum of squares of the displacements, weighed by S^-1, m^2.
Real change_of(const Design& design);

/// Moves an assembled part to where the numbers have changed least.
void lessen_change(World& world, Part& part, Real tolerance);

}  // namespace pantin::detail::assembly
