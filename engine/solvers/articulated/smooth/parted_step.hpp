#pragma once
/// A step by the energy-momentum method in parts: the whole, or as many as its events and the speed
/// of its bodies ask for; and islands alike whose parts are taken side by side.
#include <cstdint>
#include <vector>

#include "engine/base/math.hpp"
#include "engine/solvers/articulated/kernels.hpp"

namespace pantin::detail::articulated {

struct Island;

/// A part of a step of the length `whole`, s, by the fractions of it at which it begins and ends.
struct StepPart {
  Real begin, end, whole;
  bool yields = false;  // rigid ties give way
};

/// Lengths are in the shortest units of time, of which a step has kParts (conserving.cpp).
struct PartedStep {
  Real h = 0;                // s, the whole
  Real left = 0;             // of it
  Real part = 0;             // the next one
  Real usual = 0;            // likewise, but for ends at blows
  Real longest = 0;          // of the first
  Real bent = 0;             // as far as cones let the way be straight
  Real enough = 0;           // rad: see ConservingInput
  int attempt = 1;           // parts tried, with the next one
  bool follows = false;      // a step of the same length
  bool closes_gaps = false;  // of pins and loops
  bool yields = false;       // rigid ties give way
  bool inner = true;         // no tie led to the world or to another tree
  bool taken = false;        // the last part was
  bool fails = false;        // what is left has to be stepped otherwise
  StepPart now{};            // the last part

  bool goes_on() const { return left > 0 && !fails; }
};

/// The step of an island that has others like it (crowd.cpp).
struct CrowdStep {
  Island* island;
  std::uint32_t shape;
  PartedStep parts;
};
/// What islands alike have in common.
struct CrowdShape {
  std::vector<LaneTies::Tie> ties;
  std::vector<std::uint32_t> place_starts, positions, tie_at;  // see LaneTies
  std::size_t longest = 0;                                     // path of a tie
};
struct CrowdScratch {
  struct Member {
    std::uint32_t island, shape;
  };
  struct Unit {
    std::size_t first, count;  // in `going`
  };
  bool is_known = false;  // who is alike, since the last build
  std::vector<CrowdShape> shapes;
  std::vector<Member> order;  // islands that have others like them, these together
  std::vector<CrowdStep> steps;
  std::vector<std::uint32_t> going;  // of the steps, those that are not at their end
  std::vector<Unit> units;           // side by side
};

}  // namespace pantin::detail::articulated
