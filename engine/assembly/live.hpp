#pragma once
/// Assembly of one iteration a call: bodies follow targets while all laws hold.
///
///   minimise  |step|^2 / 2 + sum w |J step + C|^2 / (2 softness)   subject to  J step = -C of all
///   laws
///
/// One damped Gauss-Newton step of the Lagrangian solver's factor: rows of targets have the
/// compliance softness / w, those of laws have none. While laws stay closed, the factor and the
/// Jacobian serve several steps (chord method), each corrected by the response to the step before:
///
///   step = beta s + W J^T lambda,   A lambda = -C - beta y,   beta = -C.y / y.y
///
/// where that step s changed the rows by y. [Anderson 1965, with one step of memory]
#include <cstdint>
#include <vector>

#include "engine/assembly/problem.hpp"

namespace pantin::detail::assembly {

/// What a target holds.
enum class Goal : std::uint8_t {
  point,  // a point of the body at a point of the world
  pose,   // the body's frame at a frame of the world
  aim     // a point of the world on a line of the body
};

struct LiveTarget {
  Goal goal = Goal::point;
  Entity body;
  Pose own;     // in the mass-centre frame: the point; the frame; the line, along its x
  Pose target;  // world: where that should be
  Real weight = 1, turn_weight = 1;  // of lengths, and of rotations (per m^2 at the body's arm)
};

struct LiveReport {
  Real joint_error = 0;   // m or rad, the largest of all laws after the iteration
  Real target_error = 0;  // m or rad, the largest of all targets
};

class Live {
 public:
  Live(const World& world, std::vector<Entity> held);

  /// Adds a target; its number. The next iteration compiles.
  std::size_t add(const LiveTarget& target);
  void remove(std::size_t target);
  void hold(Entity body);
  void let_go(Entity body);
  const LiveTarget& target(std::size_t number) const { return targets_[number]; }
  bool has(std::size_t number) const { return number < targets_.size() && used_[number]; }
  /// Moves a target, without compiling.
  void move(std::size_t number, const Pose& target);
  void set_weight(std::size_t number, Real weight, Real turn_weight);

  LiveReport iterate();
  /// The largest displacement of the last iteration, m or rad.
  Real last_step() const { return last_step_; }

  /// The model with the poses of the last iteration.
  const World& world() {
    write_to(model_);
    return model_;
  }
  void write_to(World& world) const;

 private:
  struct Followed {  // a target in the problem
    std::size_t target = 0, part = 0, block = 0;
    Entity entity;  // its pin, or its frame
  };
  /// The rows at the present poses and targets that are evaluated.
  enum class Known : std::uint8_t { nothing, residuals, all };
  struct Factor {
    Real softness = 0;    // of its targets
    int steps = 0;        // that it has served; all but the first have a response
    bool stands = false;  // it may serve another
  };
  struct PartState {
    Real softness = 1e-3;
    Real merit = 0;       // of targets, after the last iteration
    Real error = 0;       // of laws, then
    Real misfit = 0;      // m or rad: rows after the last step that its model did not foresee
    bool closed = false;  // laws held before, and no target has moved
    bool moved = false;   // targets have, since rows were evaluated
    Known known = Known::nothing;
    Factor factor;
    std::vector<Real> pressing;  // by row: multipliers of the last step towards the targets
    // That step, and by row the change it made: s and y above. Within a step, -C before it.
    std::vector<Vec3> way;
    std::vector<Real> response;
  };

  void compile();
  void place(const Followed& f);
  void set_weights(Part& part, std::size_t number);
  void evaluate(std::size_t number, Known rows);
  void look_at_targets(std::size_t number);
  bool serves(std::size_t number) const;
  void solve_by_response(std::size_t number);
  void note_response(std::size_t number, Real opened);
  void solve(std::size_t number);
  void step(std::size_t number);
  Real joint_error(std::size_t number) const;
  Real target_merit(std::size_t number, Real& worst) const;
  Real correct(std::size_t number, Real error);
  void iterate_part(std::size_t number, LiveReport& report);

  World model_;
  std::vector<Entity> held_;
  std::vector<LiveTarget> targets_;
  std::vector<bool> used_;
  Problem problem_;
  std::vector<Followed> followed_;
  std::vector<PartState> states_;
  std::vector<std::vector<std::uint8_t>> is_target_;  // by part and block
  bool compiled_ = false;
  Real last_step_ = 0;
};

}  // namespace pantin::detail::assembly
