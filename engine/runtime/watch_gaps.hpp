#pragma once
/// Monitors constraints: joints, limits, cables, pins, gears, belts, surfaces. Evaluated from
/// poses, whatever the solver; pins and surfaces use the residuals of their solvers.
#include <vector>

#include "engine/runtime/finding_list.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

class GapWatch {
 public:
  /// Called after the structure has changed.
  void compile(const World& world);
  /// Called at the end of a step of `h` seconds.
  void end_step(const World& world, Real h, FindingList& found);

 private:
  /// Coordinates that a gear couples, tracked from step to step to count whole turns.
  struct Ratio {
    Real first = 0, second = 0, offset = 0;
    bool known = false;
  };

  void find_sizes(const World& world);
  Real size_of(const World& world, Entity a, Entity b) const;
  void check_joints(const World& world, FindingList& found) const;
  void check_cables(const World& world, FindingList& found) const;
  void check_pins(const World& world, Real h, FindingList& found);
  void check_gears(const World& world, FindingList& found);
  void check_belts(const World& world, FindingList& found) const;
  void check_surfaces(const World& world, FindingList& found) const;

  std::vector<Real> sizes_;        // m, of the mechanism of each body
  std::vector<Real> missed_for_;   // s, without interruption, by pin
  std::vector<Ratio> ratios_;      // by gear
  std::vector<std::size_t> held_;  // by belt: spans that have a constraint row
};

}  // namespace pantin::detail
