#include "engine/world/faults.hpp"

#include <array>
#include <stdexcept>

#include "engine/joints/kinds.hpp"
#include "engine/world/belt.hpp"
#include "engine/world/joint_drive.hpp"
#include "engine/world/solver_list.hpp"
#include "engine/world/store.hpp"
#include "engine/world/surface_contact.hpp"

namespace pantin::detail {
namespace {

struct FeatureInfo {
  const char* name;
  bool in_plane = false;  // messages name solvers of the plane too
};
constexpr std::array<FeatureInfo, kFeatures> kFeatureInfos{
    {{"a kind of joint whose bodies share no point"},
     {"a spring"},
     {"friction"},
     {"a motor"},
     {"limits with restitution"},
     {"a gear"},
     {"a soft stop"},
     {"a joint drive"},
     {"an exact joint drive"},
     {"a cable"},
     {"contact"},
     {"a spring pin"},
     {"rolling or spinning friction, or a moving surface"},
     {"a ring or a pulley of a cable"},
     {"a surface contact"},
     {"a belt", true},
     {"a curve contact", true},
     {"friction of a curve contact", true},
     {"a belt that slips", true},
     {"a loop-closing joint that constrains more than a point"}}};

const FeatureInfo& info_of(Feature f) { return kFeatureInfos[static_cast<std::size_t>(f)]; }

std::string told_for(Feature feature) {
  std::string told;
  for (const SolverScope scope : {SolverScope::plane, SolverScope::any})
    for (const SolverInfo& s : kSolverInfos) {
      const bool named =
          s.scope == scope && (scope == SolverScope::any || info_of(feature).in_plane);
      if (!named || !knows(s.solver, feature)) continue;
      told += (told.empty() ? "\"" : " or \"") + std::string(s.name) + '"';
    }
  return told;
}

}  // namespace

Solver solver_for(Solver asked, Feature feature) {
  const bool leaves =
      asked == Solver::articulated && !knows(asked, feature) && knows(Solver::lagrangian, feature);
  return leaves ? Solver::lagrangian : asked;
}

const std::string& solvers_that_know(Feature feature) {
  static const std::array<std::string, kFeatures> told = [] {
    std::array<std::string, kFeatures> all;
    for (int f = 0; f < kFeatures; ++f)
      all[static_cast<std::size_t>(f)] = told_for(static_cast<Feature>(f));
    return all;
  }();
  return told[static_cast<std::size_t>(feature)];
}

const char* name_of(Feature feature) { return info_of(feature).name; }

Feature feature_of(const JointDrive& drive) {
  return drive.exact ? Feature::exact_drive : Feature::pose_drive;
}

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
