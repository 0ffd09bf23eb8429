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
  std::vector<ImpulseBounds> bounds;
  std::vector<Vec3> jacobian;  // of those that may be hit
  std::vector<std::size_t> first_vector;
  std::vector<Vec3> twists, twists_closed;  // before it; joints closed
  ComplementarityScratch complementarity;
};

}  // namespace pantin::detail::lagrangian
