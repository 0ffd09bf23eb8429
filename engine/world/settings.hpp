#pragma once
/// How an articulation is to be solved.
#include <cstdint>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/world/integrators.hpp"

namespace pantin {

enum class Solver : std::uint8_t {
  automatic,  // articulated masses, BDF2 or backward Euler by need, energy limiter
  sweep,      // least displacement, root to leaf: kinematic posing
  shake2,     // two Newton steps in start-of-step directions, then a closing sweep
  paper,      // the literal rule of [Lee 2000]; a control for charts
  lagrangian, // Newton's and Euler's equations with multipliers: exact joints of every kind
};
constexpr Solver last_of(Solver) { return Solver::lagrangian; }

/// What the Lagrangian solver does about joints that drift apart.
enum class Stabilisation : std::uint8_t {
  projection,  // back onto them after every step, by the least mass-weighted motion
  baumgarte,   // drawn back by the equations themselves; for charts
  none,        // nothing; for charts
};
constexpr Stabilisation last_of(Stabilisation) { return Stabilisation::none; }

/// Which length^2 the literal rule takes for its `h` [Lee 2000, sec. 3.2].
enum class PaperReluctance : std::uint8_t {
  inertia_over_mass,  // I / m
  literal_step,       // I dt^2 / (2 m), as printed
};
constexpr PaperReluctance last_of(PaperReluctance) { return PaperReluctance::literal_step; }

struct SolverSettings {
  Solver solver = Solver::automatic;
  Real turn_stiffness = 1;        // beta of the least displacement: 0 swings, large values slide
  Real calm_angle = 0.5;          // rad; a body that turns farther in a step drops the order
  Real reservoir_time = 1;        // s; how long numerical losses may be given back; 0 = never
  int rounds = 16;                // cap of the relaxation
  int passes = 6;                 // most solves of a step, to find which stops and contacts bear
  // What lies on others and moves no faster than this for half a second is let lie until something
  // stirs it, m/s; 0: never.
  Real rest_speed = 2e-3;
  Real tolerance = 1e-4;          // residual of a held point, part of the articulation's size
  Real stall_drop = 1e-3;         // least relative gain of a round
  bool tension_stiffness = true;  // off only to show what it is for
  bool limiter = true;            // off only to show what it is for
  PaperReluctance paper_reluctance = PaperReluctance::inertia_over_mass;
  // Of the Lagrangian solver:
  Integrator integrator = Integrator::rk4;
  Stabilisation stabilisation = Stabilisation::projection;
  Real baumgarte = 0;       // euler: part of the gap closed in a step (0: 0.2); else rate, 1/s (0: 5)
  Real step_tolerance = 0;  // rk4: steps are divided so that each errs by less (m, rad, m/s, rad/s)
  Real damping_ratio = 0.8; // implicit: spectral radius at infinity, 0 to 1

  static void fields(auto& self, auto&& field) {
    field("solver", self.solver);
    field("turn_stiffness", self.turn_stiffness);
    field("calm_angle", self.calm_angle);
    field("reservoir_time", self.reservoir_time);
    field("rounds", self.rounds);
    field("passes", self.passes);
    field("rest_speed", self.rest_speed);
    field("tolerance", self.tolerance);
    field("stall_drop", self.stall_drop);
    field("tension_stiffness", self.tension_stiffness);
    field("limiter", self.limiter);
    field("paper_reluctance", self.paper_reluctance);
    field("integrator", self.integrator);
    field("stabilisation", self.stabilisation);
    field("baumgarte", self.baumgarte);
    field("step_tolerance", self.step_tolerance);
    field("damping_ratio", self.damping_ratio);
  }
};

/// "auto", "sweep", "shake2", "paper", "lagrangian".
const char* name_of(Solver solver);
/// False, and `solver` untouched, for any other word.
bool solver_from_name(const char* name, Solver& solver);

}  // namespace pantin
