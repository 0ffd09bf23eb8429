#pragma once
/// Memory of an impact at several limits and cables.
#include <cstdint>
#include <vector>

#include "engine/base/complementarity.hpp"

namespace pantin::detail::lagrangian {

/// See blows.cpp.
struct BlowScratch {
  std::vector<std::uint32_t> blocks, resting;  // those that may be hit; not left by it
  std::vector<Real> matrix, bias, impulses, scale;
  std::vector<Real> at_start;            // N s, by row: impulses before the first step
  std::vector<Real> gap_before;          // by block: at the start of the step
  std::vector<Real> gap, rate;           // by block: at the start of a part of it
  std::vector<std::uint8_t> is_near;     // by block: the rate is known
  std::vector<int> hits, touches;        // by block: in the step, with a blow and without
  std::vector<std::uint32_t> passed;     // within a bound that they are leaving
  std::vector<std::uint32_t> early;      // hit together with others that were hit just before
  Real together = 0;                     // s: so soon after one another bounds are reached at once
  std::vector<std::uint8_t> was_active;  // by block: in the step that contacts finish
  std::vector<ImpulseBounds> bounds;
  std::vector<Vec3> jacobian;  // of those that may be hit
  std::vector<std::size_t> first_vector;
  std::vector<Vec3> twists, twists_closed;  // before it; joints closed
  ComplementarityScratch complementarity;
};

}  // namespace pantin::detail::lagrangian
