#pragma once
/// What a World has that cannot be used as it stands, or that the solver chosen for it does not
/// know.
#include <cstdint>
#include <string>
#include <vector>

#include "engine/world/entity.hpp"
#include "engine/world/settings.hpp"

namespace pantin {

struct World;

struct StructureFault {
  enum Kind : std::uint8_t {
    left_out,   // cannot be solved: the step is taken without it
    unknown,    // its solver does not know it: the step is taken as if it were not there
    impossible  // a number that no step can be computed with: its island does not move
  };
  Entity link;         // what is concerned: a joint, a cable, a pin, a body ...
  std::string reason;  // one clause
  Kind kind = left_out;
  // Unknown, but of a thing that scenes are read with all the same: contacts, soft stops, springs
  // that hold points.
  bool is_minor = false;
};

/// All that is wrong with a World as it stands, without a step: joints that cannot be used, motors,
/// springs, friction, ratios, kinds of joints and the like under a solver that does not know them,
/// impossible masses. StepReport::faults counts the same.
std::vector<StructureFault> check(const World& world);

namespace detail {

struct Joint;
enum class Feature : std::uint8_t;  // solver_list.hpp

/// The solver that steps what asks for `asked` and has the feature: "auto" leaves what it does not
/// know to "lagrangian".
Solver solver_for(Solver asked, Feature feature);
/// The solvers that know it, in words: "\"lagrangian\"", "\"auto\" or \"lagrangian\"".
const std::string& solvers_that_know(Feature feature);
/// "a spring", "a motor", "a cable" ...
const char* name_of(Feature feature);

struct Belt;
Feature feature_of(const Belt& belt);
struct SurfaceContact;
Feature feature_of(const SurfaceContact& contact);

/// What a joint has besides a shared point and hard limits; kinds included.
std::vector<Feature> features_of(const Joint& joint);

}  // namespace detail
}  // namespace pantin
