#pragma once
/// Faults of a World: objects that cannot be used as they are, or that the chosen solver does not
/// support.
#include <cstdint>
#include <string>
#include <vector>

#include "engine/world/entity.hpp"
#include "engine/world/settings.hpp"

namespace pantin {

struct JointDrive;
struct World;

struct StructureFault {
  enum Kind : std::uint8_t {
    left_out,   // cannot be solved: the step is taken without it
    unknown,    // its solver does not support it: the step ignores it
    impossible  // a number that no step can be computed with: its island does not move
  };
  Entity link;         // the object: a joint, a cable, a pin, a body ...
  std::string reason;  // one clause
  Kind kind = left_out;
  // Of kind `unknown`, but such scenes are accepted: contacts, soft stops, springs that hold
  // points.
  bool is_minor = false;
};

/// Lists all faults of a World without taking a step: unusable joints, impossible masses, and
/// motors, springs, friction, gears, joint kinds and the like under a solver that does not support
/// them. StepReport::faults counts the same.
std::vector<StructureFault> check(const World& world);

namespace detail {

struct Joint;
enum class Feature : std::uint8_t;  // solver_list.hpp

/// The solver that steps a body with this feature that asks for `asked`: "auto" passes unsupported
/// features to "lagrangian".
Solver solver_for(Solver asked, Feature feature);
/// The solvers that support it, in words: "\"lagrangian\"", "\"auto\" or \"lagrangian\"".
const std::string& solvers_that_know(Feature feature);
/// "a spring", "a motor", "a cable" ...
const char* name_of(Feature feature);

Feature feature_of(const JointDrive& drive);
struct Belt;
Feature feature_of(const Belt& belt);
struct SurfaceContact;
Feature feature_of(const SurfaceContact& contact);

/// The features of a joint besides a shared point and hard limits, its kind included.
std::vector<Feature> features_of(const Joint& joint);

}  // namespace detail
}  // namespace pantin
