#pragma once
/// Solver settings of an island.
#include <cstdint>
#include <string_view>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/world/integrators.hpp"

namespace pantin {

enum class Solver : std::uint8_t {
  articulated,  // conserves energy and momentum in free motion; substepped impulses in contact
  sweep,        // least displacement from root to leaf: kinematic posing
  shake2,       // two Newton steps in start-of-step directions, then a closing sweep
  procedural,   // rotation rule as printed in [Lee 2000], for comparison in charts
  lagrangian,   // Newton's and Euler's equations with multipliers: exact joints of every kind
  planar,       // bodies that stay in the plane of x and y, by Box2D; joints closed exactly
  quasistatic,  // laminas that fingers move so slowly that inertia is negligible
};
constexpr Solver last_of(Solver) { return Solver::quasistatic; }

/// How the Lagrangian solver corrects constraint drift.
enum class Stabilisation : std::uint8_t {
  projection,  // mass-orthogonal projection onto the constraints after every step
  baumgarte,   // Baumgarte feedback in the equations; for comparison
  none,        // no correction; for comparison
};
constexpr Stabilisation last_of(Stabilisation) { return Stabilisation::none; }

/// Jacobians of surface joints in the Lagrangian solver and in assembly.
enum class Jacobians : std::uint8_t {
  analytic,          // closed forms
  differences,       // central differences, extrapolated once; for comparison
  squared_distance,  // the same of the squared distance; for comparison [Nelson & Cohen, Eqn 3]
};
constexpr Jacobians last_of(Jacobians) { return Jacobians::squared_distance; }

/// The length^2 that the rule of the paper takes for its `h` [Lee 2000, sec. 3.2].
enum class ProceduralReluctance : std::uint8_t {
  inertia_over_mass,  // I / m
  literal_step,       // I dt^2 / (2 m), as printed
};
constexpr ProceduralReluctance last_of(ProceduralReluctance) {
  return ProceduralReluctance::literal_step;
}

struct SolverSettings {
  Solver solver = Solver::articulated;
  Real rotation_stiffness = 1;  // beta of the least displacement: 0 rotates, large values translate
  int sweeps = 16;              // most relaxation sweeps
  // An island at rest on fixed bodies sleeps once it has been slower than this for half a second,
  // m/s; 0: never. For the other conditions on jointed bodies see has_rested() of `articulated`.
  Real sleep_speed = 2e-3;
  Real tolerance = 1e-4;   // residual of a pin, as a fraction of the island's size
  Real stall_drop = 1e-3;  // least relative improvement per sweep
  bool limiter = true;     // off only for comparison
  ProceduralReluctance procedural_reluctance = ProceduralReluctance::inertia_over_mass;
  // Lagrangian solver:
  Integrator integrator = Integrator::rk4;
  Stabilisation stabilisation = Stabilisation::projection;
  Jacobians jacobians = Jacobians::analytic;
  Real baumgarte = 0;  // euler: fraction of the gap closed in a step (0: 0.2); others: rate, 1/s
                       // (0: 5)
  Real step_tolerance =
      0;  // rk4, radau: bound on the local error of each substep (m, rad, m/s, rad/s)
  Real damping_ratio = 0.8;  // implicit: spectral radius at infinity, 0 to 1

  friend bool operator==(const SolverSettings&, const SolverSettings&) = default;

  static void fields(auto& self, auto&& field) {
    field("solver", self.solver);
    field("rotation_stiffness", self.rotation_stiffness);
    field("sweeps", self.sweeps);
    field("sleep_speed", self.sleep_speed);
    field("tolerance", self.tolerance);
    field("stall_drop", self.stall_drop);
    field("limiter", self.limiter);
    field("procedural_reluctance", self.procedural_reluctance);
    field("integrator", self.integrator);
    field("stabilisation", self.stabilisation);
    field("jacobians", self.jacobians);
    field("baumgarte", self.baumgarte);
    field("step_tolerance", self.step_tolerance);
    field("damping_ratio", self.damping_ratio);
  }
};

/// Its word in files: "auto", "lagrangian" ...
const char* name_of(Solver solver);
/// False for any other word; `solver` is then unchanged.
bool solver_from_name(const char* name, Solver& solver);

namespace detail {
/// Words of Jacobians in files, in its order.
inline constexpr std::string_view kJacobianNames[] = {"analytic", "differences",
                                                      "squared_distance"};
/// Why no step can be computed with the settings, as a clause, or null. The bounds are those of the
/// scene keys, except that counts may be larger.
const char* settings_fault(const SolverSettings& settings);
}  // namespace detail
}  // namespace pantin
