#pragma once
/// THE list of solvers: one row each tells its word in files, its place among the solvers, what it
/// is for and what it knows. A new solver is a word of Solver (settings.hpp), a row here, one in
/// engine/solvers/solver.hpp, and a folder.
#include <array>
#include <cstdint>
#include <string_view>

#include "engine/world/settings.hpp"

namespace pantin::detail {

/// Rows of kSolvers (engine/solvers/solver.hpp), in the order in which they predict and adjust.
enum SolverIndex : std::uint8_t { kQuasistatic, kPlanar, kLagrangian, kArticulated, kSolverCount };

/// What not every solver knows.
enum class Feature : std::uint8_t {
  kind,         // a joint whose bodies do not share a point
  spring,       // along the freedom of a joint
  friction,     // likewise
  motor,        // likewise
  restitution,  // of the limits of a joint
  ratio,        // of two joints
  soft_stop,    // a zone before a limit
  pose_drive,   // a joint drive that is a spring
  exact_drive,  // a joint drive that is a constraint
  cable,
  contact,
  spring_pin,   // of a pin
  surface,      // that moves, or that resists rolling or spinning
  cable_guide,  // a ring or a pulley that a cable is led over
  surface_contact,
  belt,
  curve_contact,  // of two curves of a plane
  curve_friction,
  belt_friction,
  closing  // a joint that closes a loop, and holds more than its point
};
inline constexpr int kFeatures = 20;

template <class... F>
constexpr std::uint32_t features(F... f) {
  return ((1u << static_cast<int>(f)) | ...);
}

/// What a solver can be asked to move.
enum class SolverScope : std::uint8_t {
  any,     // any scene; messages name it where it knows what another does not
  posing,  // any scene, as kinematic poses: messages send nobody to it
  plane,   // what stays in the plane of x and y
  laminas  // chosen by the scene itself
};

struct SolverInfo {
  Solver solver;
  SolverIndex row;
  SolverScope scope;
  bool closes_loops;  // by any kind of joint, to rounding
  std::uint32_t features;
  std::string_view name;
  std::string_view about;      // for the schema
  std::string_view once = {};  // its former word in files
};

/// In the order of Solver.
inline constexpr auto kSolverInfos = [] {
  using enum Feature;
  return std::array{
      SolverInfo{Solver::articulated, kArticulated, SolverScope::any, false,
                 features(spring, friction, motor, soft_stop, pose_drive, cable, contact,
                          spring_pin, surface),
                 "auto", "dynamics, stable at any step."},
      SolverInfo{Solver::sweep, kArticulated, SolverScope::posing, false, features(closing),
                 "sweep", "kinematic posing."},
      SolverInfo{Solver::shake2, kArticulated, SolverScope::posing, false, features(closing),
                 "shake2", "accurate at small steps."},
      SolverInfo{Solver::procedural, kArticulated, SolverScope::posing, false, features(closing),
                 "procedural", "the rotation rule as printed by Lee et al. (2000), for comparison.",
                 "paper"},
      SolverInfo{Solver::lagrangian, kLagrangian, SolverScope::any, true,
                 features(kind, spring, friction, motor, restitution, ratio, soft_stop, pose_drive,
                          exact_drive, cable, contact, spring_pin, surface, cable_guide,
                          surface_contact, belt, curve_contact, curve_friction, closing),
                 "lagrangian", "exact joints of every kind, by constraint forces."},
      SolverInfo{Solver::planar, kPlanar, SolverScope::plane, true,
                 features(kind, spring, friction, motor, ratio, exact_drive, contact, belt,
                          curve_contact, belt_friction, closing),
                 "planar",
                 "bodies that move in the xy plane, by Box2D, with joints closed exactly."},
      SolverInfo{Solver::quasistatic, kQuasistatic, SolverScope::laminas, true, features(contact),
                 "quasistatic", "laminas, which always use it."}};
}();

constexpr bool are_in_order() {
  for (std::size_t i = 0; i < kSolverInfos.size(); ++i)
    if (kSolverInfos[i].solver != static_cast<Solver>(i)) return false;
  return kSolverInfos.size() == static_cast<std::size_t>(last_of(Solver{})) + 1;
}
static_assert(are_in_order());

constexpr const SolverInfo& info_of(Solver solver) {
  return kSolverInfos[static_cast<std::size_t>(solver)];
}
constexpr std::uint8_t row_of(Solver solver) { return info_of(solver).row; }
/// Which solver does what.
constexpr bool knows(Solver solver, Feature feature) {
  return (info_of(solver).features & features(feature)) != 0;
}

/// Their words, in that order.
inline constexpr auto kSolverNames = [] {
  std::array<std::string_view, kSolverInfos.size()> names{};
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = kSolverInfos[i].name;
  return names;
}();

}  // namespace pantin::detail
