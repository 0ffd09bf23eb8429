#pragma once
/// A step by the energy-momentum method in substeps: one, or as many as events and fast rotations
/// require. Also the batches of similar islands whose substeps are vectorised (crowd.cpp).
#include <cstdint>
#include <vector>

#include "engine/base/math.hpp"
#include "engine/solvers/articulated/kernels.hpp"

namespace pantin::detail::articulated {

struct Island;

/// A substep of a step of length `whole`, s: the fractions of it at which it begins and ends.
struct StepPart {
  Real begin, end, whole;
  bool yields = false;  // rigid ties are compliant
};

/// Lengths are in the shortest units of time, of which a step has kParts (conserving.cpp).
struct PartedStep {
  Real h = 0;                // s, the whole
  Real left = 0;             // remaining length
  Real part = 0;             // the next substep
  Real usual = 0;            // the same, without ends at impacts
  Real longest = 0;          // the first substep
  Real bent = 0;             // longest for rotating gradients of cones
  int attempt = 1;           // substeps tried, with the next one
  bool follows = false;      // the last step had the same length
  bool closes_gaps = false;  // of pins and loops
  bool takes_up = false;     // a cable that was too long at the start of the step
  bool yields = false;       // rigid ties are compliant
  bool opens = false;        // joints have limits only, and none is active: see open_limits.cpp
  bool inner = true;         // no tie led to the world or to another tree
  bool taken = false;        // the last substep was accepted
  bool fails = false;        // the rest is left to sweeps
  bool hurries = false;      // impacts and losses of energy do not divide what is left
  StepPart now{};            // the last substep

  bool goes_on() const { return left > 0 && !fails; }
};

/// The step of an island of a batch (crowd.cpp).
struct CrowdStep {
  Island* island;
  std::uint32_t shape;
  std::uint64_t taut;  // which cables were, in the last step
  PartedStep parts;
};
/// The structure that the islands of a batch have in common.
struct CrowdShape {
  std::vector<LaneTies::Tie> ties;
  std::vector<std::uint32_t> column_starts, positions, tie_at;  // see LaneTies
  std::size_t longest = 0;                                      // longest path of a tie
};
struct CrowdScratch {
  struct Member {
    std::uint32_t island, shape;
  };
  bool is_known = false;     // batches have been found since the last build
  std::size_t unsorted = 0;  // islands that came since, and could be in one
  std::vector<CrowdShape> shapes;
  std::vector<Member> order;           // islands of batches, batch by batch
  std::vector<std::uint8_t> is_awake;  // by island, in step_crowds()
  std::vector<CrowdStep> steps;
  std::vector<std::uint32_t> going;  // indices of steps that are not finished, block by block
};

}  // namespace pantin::detail::articulated
