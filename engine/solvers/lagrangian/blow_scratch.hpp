#pragma once
/// Memory of an impact at several limits and cables.
#include <cstdint>
#include <vector>

#include "engine/base/complementarity.hpp"

namespace pantin::detail::lagrangian {

/// See blows.cpp.
struct BlowScratch {
  std::vector<std::uint32_t> blocks, resting;  // candidates; those that stay in contact
  std::vector<Real> matrix, bias, impulses, scale;
  std::vector<Real> at_start;            // N s, by row: impulses before the first step
  std::vector<Real> gap_before;          // by block: at the start of the step
  std::vector<Real> gap, rate;           // by block: at the start of a substep
  std::vector<std::uint8_t> is_near;     // by block: the rate is known
  std::vector<int> hits, touches;        // by block: reached in the step, with and without impact
  std::vector<std::uint32_t> passed;     // beyond their bounds, and opening
  std::vector<std::uint32_t> early;      // hit ahead of time, together with others
  Real together = 0;                     // s: bounds reached within this time are hit together
  std::vector<std::uint8_t> was_active;  // by block: in the step before contacts
  std::vector<ImpulseBounds> bounds;
  std::vector<Vec3> jacobian;  // of the candidates
  std::vector<std::size_t> first_vector;
  std::vector<Vec3> twists, twists_closed;  // before the impact; with joints closed
  ComplementarityScratch complementarity;
};

}  // namespace pantin::detail::lagrangian
