#pragma once
/// The report of one step.
#include <cstdint>

#include "engine/base/math.hpp"
#include "engine/world/entity.hpp"

namespace pantin {

enum class Status : std::uint8_t {
  ok,
  diverged,       // a number is not finite or out of bounds; the affected bodies were not moved
  system_failed,  // a user's system threw an exception; the rest of the step was taken
  inconsistent,   // joints of an island contradict one another or a contact, or a cable is longer
                  // than it can be or has run up on a pulley; see StepReport::worst_residual_at
  bad_clock,      // World::time is not finite, or the step is too short or too long to compute with
                  // (see kShortestStep): what was left of it was not taken
  contact_lost,   // surfaces in contact reached an invalid place: see StepReport::contact_fault
  energy_grew,    // the energy grew severalfold under a solver that does not conserve it; see
                  // README
  aborted         // memory ran out within the step: bodies stay where it had moved them, and the
                  // next step starts from there
};

/// Measures of one state, SI units.
struct Measures {
  // Over all joints, including those to anchors and those that close loops. Residuals of pins and
  // cables are in StepReport::worst_residual.
  Real worst_gap = 0;               // m
  Real worst_gap_rel = 0;           // relative to the island's size
  Entity worst_link;                // its link
  Real worst_violation = 0;         // rad: violation of a joint's kind and limits
  Real kinetic = 0, potential = 0;  // J; potential of gravity, zero at the origin
  Real elastic = 0;                 // J; in joint springs, elastic cables and spring pins
  Vec3 momentum{0};                 // kg m/s, dynamic bodies
  Vec3 angular_momentum{0};         // kg m^2/s, about the world's origin
  Real energy() const { return kinetic + potential + elastic; }
};

/// Cost of a group of bodies in contact in the last substep of a step with StepSettings::budget.
struct GroupCost {
  Entity body;                    // one of them
  Real seconds = 0;               // elapsed
  int substeps = 0, planned = 0;  // taken, and what accuracy asks for
};

struct StepReport {
  Status status = Status::ok;
  Entity body;        // where the divergence, or the growth of energy, was detected; the body whose
                      // contact contradicts a surface joint, where inconsistent
  Real residual = 0;  // worst joint gap at that time, m
  std::uint64_t tick = 0;
  Real time = 0;             // s, after the step
  int sweeps_used = 0;       // most relaxation sweeps of any island
  int limited = 0;           // most islands whose energy was limited in a substep
  Real energy_removed = 0;   // J, by the energy limiter
  Entity limited_at;         // a body of the island from which most was removed
  int unreached = 0;         // pins and cables whose residual exceeds the tolerance
  Entity worst_residual_at;  // the pin or cable with the worst residual
  Real worst_residual = 0;   // m
  int contacts = 0;          // active contact points
  Real worst_depth = 0;      // m, deepest penetration after the step
  int stops_hit = 0;         // joints at an active limit
  int drives_capped = 0;     // joint drives limited by max_torque
  int asleep = 0;            // islands asleep
  // Lagrangian solver:
  int rows = 0, rank = 0;          // of the constraint equations; rank < rows: redundant rows
  Real worst_constraint = 0;       // m or rad, residual after the step
  int substeps = 0;                // most substeps of the integrator in this step
  int events = 0;                  // limits reached
  int rescued = 0;                 // islands whose step fell back to Euler
  Entity rescued_at;               // a body of the first
  const char* contact_fault = "";  // of Status::contact_lost: ContactLeftPatch, SurfaceSingular,
                                   // ContactDegenerate, lost
  Entity contact;                  // the joint in question; `body` is its body a
  int released = 0;                // joints of surfaces that released in this step
  int uncertain = 0;    // joints of surfaces that nearly fit one another where they touch:
  Entity uncertain_at;  // the place of contact is uncertain; the first of them
  int unsolved = 0;     // groups of islands whose contacts were not solved to the tolerance
  Entity unsolved_at;   // a body of the first
  int hurried = 0;      // islands whose impacts were not followed within the step, for
                        // StepSettings::budget
  Entity hurried_at;    // a body of the first
  int left_out = 0;     // islands that took no step, for StepSettings::budget
  Entity left_out_at;   // a body of the first
  int shortened = 0;    // groups in contact that took fewer substeps, for StepSettings::budget
  Entity shortened_at;  // a body of the one that gave up most
  Real given_up = 0;    // of its substeps, as a fraction
  // Quasi-static solver:
  int mode_switches = 0;  // changes of contact modes in this step
  int handed_over = 0;    // laminas that dynamics moved in this step: the quasi-static problem had
                          // no solution
  Entity lamina;          // the first that switched to dynamics in this step, or back
  const char* changed = "";  // why it went, in a clause; "" if it came back
  // Parts of the structure that cannot be used or that their solver does not support: see
  // check(World).
  int faults = 0;
  Entity fault;  // the first of these entities
  // With StepSettings::watch: see Simulation::findings().
  int findings = 0;  // that were first made in this step
  bool measured = false;
  Measures measures;  // only on request
};

}  // namespace pantin
