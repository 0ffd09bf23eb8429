#pragma once
/// The reference problems of tests/data/references as Worlds, and how a run is scored on them.
#include <functional>
#include <string>
#include <vector>

#include "engine/joints/kinds.hpp"
#include "engine/runtime/simulation.hpp"

namespace pantin::study {

using namespace detail;

/// One case of one file. Row 0 is the state that the World starts from.
struct Problem {
  std::string file, id;
  World world;                          // moved by the Lagrangian solver
  Real every = 0;                       // s between rows; rows[i] is at at_step[i] * every
  std::vector<std::vector<Real>> rows;  // as in the file, the first number is not the time always
  std::vector<int> at_step;
  /// How far a World is from a row: m, rad or as an attitude (a difference of quaternions).
  std::function<Real(const World&, const std::vector<Real>&)> error;
  int divisions = 1;  // of `every`, for Runge-Kutta of order 4
  Real allowed = 0;   // error then; with steps by tolerance 1e-10: allowed_adaptive
  Real allowed_adaptive = 0;
  bool conserves = true;  // energy: nothing drives or damps it
};

/// All cases that the solver covers. Throws where a file is missing or not as expected.
std::vector<Problem> read_problems(const std::string& folder);

/// What a hanging chain starts from: its shape at rest, or two straight halves and damped.
enum class HangingStart { at_rest, straight_halves };

std::vector<Problem> read_hanging_chains(const std::string& folder, HangingStart start);

struct Score {
  Status status = Status::ok;
  Real error = 0;       // the worst over all rows
  Real energy = 0;      // J, the farthest from the start
  Real constraint = 0;  // m or rad, the worst after a step
  int rows = 0, least_rank = 0;
  long parts = 0;  // steps of the integrator
};

/// Runs a problem as its settings say, with `divisions` steps between rows.
Score score(const Problem& problem, int divisions);

/// CPU seconds of the same run without measuring: median of `repeats`.
double time_of(const Problem& problem, int divisions, int repeats);

double cpu_seconds();
double median(std::vector<double> values);

/// A joint that turns about `axis` (body axes of both; bodies in the same attitude).
Joint hinge_about(Vec3 axis, Vec3 anchor_a, Vec3 anchor_b);

/// Uniform rods of 1 kg in a row from the origin, joined by balls or by hinges about z.
struct RodChain {
  int links = 0;
  Real length = 0;  // m, of each
  Real angle = 0;   // rad, from hanging down
  JointKind kind = JointKind::ball;
  bool held = true;  // at the first end
};
World chain(const RodChain& rods);
inline World chain(int links, Real length, Real angle, JointKind kind = JointKind::ball) {
  return chain({links, length, angle, kind, true});
}

/// The farthest that a body of one World is from its place in the other, m.
Real distance(const World& a, const World& b);
/// ... in m or rad.
Real difference(const World& a, const World& b);

}  // namespace pantin::study
