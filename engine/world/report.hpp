#pragma once
/// What one step has to say.
#include <cstdint>

#include "engine/base/math.hpp"
#include "engine/world/entity.hpp"

namespace pantin {

enum class Status : std::uint8_t {
  ok,
  diverged,      // a number is not finite or out of all bounds; the bodies concerned were not moved
  system_failed, // a user's own system threw; the rest of the step was taken
  inconsistent,  // joints of a mechanism contradict one another; see StepReport::worst_hold
  bad_clock,     // World::time is not finite, or the step is too short or too long to compute with
                 // (see kShortestStep): what was left of it was not taken
  energy_grew    // a solver that does not keep the energy made it grow severalfold; see README
};

/// Rulers of one state, SI units.
struct Measures {
  // Over the joints of all trees, the one that holds a root included. Where a tree is held once
  // more, StepReport::worst_residual tells how far that place is off.
  Real worst_gap = 0;               // m
  Real worst_gap_rel = 0;           // the same over the articulation's size
  Entity worst_link;                // where; none for a pin
  Real worst_violation = 0;         // rad: a joint beyond what its kind and limits allow
  Real kinetic = 0, potential = 0;  // J; potential of gravity, zero at the origin
  Real elastic = 0;                 // J; in springs along the freedoms of joints
  Vec3 momentum{0};                 // kg m/s, dynamic bodies
  Vec3 spin_momentum{0};            // kg m^2/s, about the world's origin
  Real energy() const { return kinetic + potential + elastic; }
};

struct StepReport {
  Status status = Status::ok;
  Entity body;        // where a divergence, or energy that grew, was seen
  Real residual = 0;  // worst joint gap then, m
  std::uint64_t tick = 0;
  Real time = 0;            // s, after the step
  int rounds_used = 0;      // most relaxation rounds of any articulation
  int limited = 0;          // articulations whose energy was limited
  int unreached = 0;        // pins and strings farther from their place than the tolerance
  Entity worst_hold;        // the worst of them (a pin or a string)
  Real worst_residual = 0;  // m
  int contacts = 0;         // points that bear a load
  Real worst_depth = 0;     // m, overlap left at a contact
  int stops_hit = 0;        // joints held by a limit
  int drives_capped = 0;    // pose drives that would need more torque than they may exert
  int resting = 0;          // articulations that lie still and are let lie
  int passes_used = 0;      // most solves of any articulation to find what stops and contacts bear
  // Of mechanisms (Lagrangian solver):
  int rows = 0, rank = 0;    // of the joints' equations; fewer: some follow from others
  Real worst_constraint = 0; // m or rad, residual after the step
  int parts = 0;             // most steps of the integrator that this step was made of
  int events = 0;            // limits that were reached
  int rescued = 0;           // mechanisms whose step Euler took: their integrator could not
  // What the structure has that cannot be used or that its solver does not know: see check(World).
  int faults = 0;
  Entity fault;  // of the first
  bool measured = false;
  Measures measures;  // only if asked for
};

}  // namespace pantin
