#pragma once
/// Brings the bodies of a World from any poses to poses at which all laws hold: joints, pins,
/// gears, belts, cables, limits, surfaces and curves in contact. Method and figures: README.md.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "engine/assembly/descent.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::assembly {

struct AssemblyChoices {
  const Method* method = nullptr;  // null: the first
  Effort effort;
  std::vector<Entity> held;            // bodies that stay where they are
  std::vector<DesignVariable> free{};  // numbers of laws that may change
  int starts = 24;                     // attempts from perturbed poses, beside the first
  std::uint64_t seed = 1;              // of perturbations
  std::function<void(const Iteration&)> watch{};
  bool finds_contradictions = true;
};

/// The residual of one law, or of a limit of a joint.
struct LawResidual {
  Entity law;
  Real residual = 0;  // root of the sum of squares of its rows, m and rad
  bool is_limit = false;
};

/// A law with rows that follow from others.
struct RedundantLaw {
  Entity law;
  int rows = 0;
};

/// A design variable, before and after.
struct DesignChange {
  DesignVariable of;
  DesignValue before, after;
  bool is_at_bound = false;
};

struct AssemblyReport {
  bool assembled = false;
  Real residual = 0;  // the largest, m or rad
  int iterations = 0;
  int starts = 0;         // perturbed starts that were taken
  int perturbations = 0;  // at saddle points
  int turned_over = 0;    // bodies turned half round, off a spurious branch
  int brought = 0;        // bodies put against a surface that they did not face
  std::uint64_t seed = 0;
  std::size_t bodies = 0, rows = 0, rank = 0;
  std::int64_t mobility = 0;           // degrees of freedom that are left
  std::vector<LawResidual> residuals;  // of all laws, the largest first
  std::vector<RedundantLaw> redundant;
  std::vector<DesignChange> design;    // as in AssemblyChoices::free
  std::vector<Entity> wrong_branch;    // joints whose axes are opposed
  std::vector<Entity> reached_limits;  // joints at a limit, cables that are taut
  // A set of laws that cannot all hold, each of which is needed for that; empty if none was found.
  std::vector<Entity> contradictory;
  Real moved = 0, turned = 0;  // the largest displacement and rotation of a body, m, rad
};

/// Assembles a World in place; its design variables are changed as little as possible. If that is
/// impossible, its bodies are left in the pose of least squares, and the report names laws that
/// contradict one another.
AssemblyReport assemble(World& world, const AssemblyChoices& choices);

/// Laws of a World that contradict one another, by deletion: each of them is needed for it. `world`
/// is in a pose of least squares, and `start` where it came from.
std::vector<Entity> find_contradiction(const World& world, const World& start,
                                       const AssemblyReport& report,
                                       const AssemblyChoices& choices);

/// Places all dynamic bodies that are not held at random: rotated by any angle, and displaced by a
/// normal distribution of `spread` m along each axis.
void scatter(World& world, std::uint64_t seed, Real spread, std::span<const Entity> held);

}  // namespace pantin::detail::assembly
