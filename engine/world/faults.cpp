#include "engine/world/faults.hpp"

#include <stdexcept>

#include "engine/joints/kinds.hpp"
#include "engine/world/belt.hpp"
#include "engine/world/store.hpp"
#include "engine/world/surface_contact.hpp"

namespace pantin::detail {
namespace {

constexpr unsigned bit(Solver s) { return 1u << static_cast<int>(s); }
constexpr unsigned kAuto = bit(Solver::articulated), kExact = bit(Solver::lagrangian),
                   kPlanar = bit(Solver::planar), kSlow = bit(Solver::quasistatic),
                   kSweeps = bit(Solver::sweep) | bit(Solver::shake2) | bit(Solver::procedural);

struct Knowledge {
  const char* name;
  unsigned solvers;
  const char* told;
};
// By Feature. "planar" knows its own only for what stays in a plane, so that nobody is sent to it.
// Sweeps pose: they close joints one after the other and clamp hard limits, no more.
constexpr Knowledge kKnowledge[kFeatures] = {
    {"a kind of joint whose bodies share no point", kExact | kPlanar, "\"lagrangian\""},
    {"a spring", kAuto | kExact | kPlanar, "\"auto\" or \"lagrangian\""},
    {"friction", kAuto | kExact | kPlanar, "\"auto\" or \"lagrangian\""},
    {"a motor", kAuto | kExact | kPlanar, "\"auto\" or \"lagrangian\""},
    {"limits with restitution", kExact, "\"lagrangian\""},
    {"a gear", kExact | kPlanar, "\"lagrangian\""},
    {"a soft stop", kAuto | kExact, "\"auto\" or \"lagrangian\""},
    {"a joint drive", kAuto | kExact, "\"auto\" or \"lagrangian\""},
    {"a cable", kAuto | kExact, "\"auto\" or \"lagrangian\""},
    {"contact", kAuto | kExact | kPlanar | kSlow, "\"auto\" or \"lagrangian\""},
    {"a spring pin", kAuto | kExact, "\"auto\" or \"lagrangian\""},
    {"rolling or spinning friction, or a moving surface", kAuto | kExact,
     "\"auto\" or \"lagrangian\""},
    {"a ring or a pulley of a cable", kExact, "\"lagrangian\""},
    {"a contact of surfaces", kExact, "\"lagrangian\""},
    {"a belt", kExact | kPlanar, "\"planar\" or \"lagrangian\""},
    {"a contact of curves", kExact | kPlanar, "\"planar\" or \"lagrangian\""},
    {"friction of a contact of curves", kExact, "\"lagrangian\""},
    {"a belt that slips", kPlanar, "\"planar\""},
    {"a joint that closes a loop by more than its point", kExact | kPlanar | kSweeps,
     "\"lagrangian\""}};

const Knowledge& knowledge(Feature f) { return kKnowledge[static_cast<int>(f)]; }

}  // namespace

bool knows(Solver solver, Feature feature) {
  return (knowledge(feature).solvers & bit(solver)) != 0;
}

Solver solver_for(Solver asked, Feature feature) {
  const bool leaves =
      asked == Solver::articulated && !knows(asked, feature) && knows(Solver::lagrangian, feature);
  return leaves ? Solver::lagrangian : asked;
}

const char* solvers_that_know(Feature feature) { return knowledge(feature).told; }

const char* name_of(Feature feature) { return knowledge(feature).name; }

Feature feature_of(const Belt& belt) {
  return belt.friction > 0 ? Feature::belt_friction : Feature::belt;
}

Feature feature_of(const SurfaceContact& contact) {
  if (!contact.on_b.curve) return Feature::surface_contact;
  return contact.friction >= 0 ? Feature::curve_friction : Feature::curve_contact;
}

std::vector<Feature> features_of(const Joint& joint) {
  std::vector<Feature> found;
  if (!is_articulated(joint.kind)) found.push_back(Feature::kind);
  if (joint.parameters.any()) {
    const Dof &rotation = joint.parameters->rotation, &translation = joint.parameters->translation;
    const auto springs = [](const Dof& f) {
      return f.spring.stiffness != 0 || f.spring.damping != 0;
    };
    const auto rubs = [](const Dof& f) { return f.friction.viscous != 0 || f.friction.dry != 0; };
    const auto drives = [](const Dof& f) { return f.motor.kind != MotorKind::none; };
    if (springs(rotation) || springs(translation)) found.push_back(Feature::spring);
    if (rubs(rotation) || rubs(translation)) found.push_back(Feature::friction);
    if (drives(rotation) || drives(translation)) found.push_back(Feature::motor);
    if (joint.parameters->restitution != 0) found.push_back(Feature::restitution);
  }
  if (joint.limits.any() && joint.limits->soft_zone > 0) found.push_back(Feature::soft_stop);
  return found;
}

void throw_missing(Entity owner) {
  throw std::out_of_range("no such component of entity #" + std::to_string(owner.index) +
                          ", generation " + std::to_string(owner.generation));
}

}  // namespace pantin::detail
