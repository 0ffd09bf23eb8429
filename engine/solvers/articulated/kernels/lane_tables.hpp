#pragma once
/// Tables of a batch of islands: kWide numbers for each number of one island.
#include "engine/solvers/articulated/kernels/rows.hpp"

namespace pantin::detail::articulated {
namespace {

/// Rows of the state at the start of a substep; velocities after half the drag.
enum LaneStart : std::size_t {
  kStartPosition = 0,                   // 3
  kStartVelocity = kStartPosition + 3,  // 3
  kStartSpin = kStartVelocity + 3,      // 3
  kStartRotation = kStartSpin + 3,      // 4
  kStartHalfDrag = kStartRotation + 4,
  kStartRows
};

/// Hands out memory; with a null pointer it only counts.
struct LaneMemory {
  double* free;
  std::size_t used = 0;
  double* take(std::size_t numbers) {
    double* const out = free ? free + used : nullptr;
    used += numbers * kWide;
    return out;
  }
};

struct LaneTables {
  double *constants, *memory_rows, *work_rows, *nodes, *starts;
  double *targets, *ways, *anchor_velocities;
  double *tie_blocks, *tie_factors;  // null without ties
  std::size_t count, trees;
  Lane running = all<Lane>(1);  // 1 while an island iterates, else 0

  void lay_out(LaneMemory& memory, std::size_t bodies, std::size_t roots) {
    count = bodies, trees = roots;
    constants = memory.take(kConstantRows * count), memory_rows = memory.take(kMemoryRows * count);
    work_rows = memory.take(kConservingRows * count), nodes = memory.take(kNodeSize * count);
    starts = memory.take(kStartRows * count);
    targets = memory.take(3 * trees), ways = memory.take(3 * trees);
    anchor_velocities = memory.take(3 * trees);
    tie_blocks = tie_factors = nullptr;
  }
  INLINE double* constants_at(std::size_t i) const { return constants + kConstantRows * kWide * i; }
  INLINE double* memory_at(std::size_t i) const { return memory_rows + kMemoryRows * kWide * i; }
  INLINE double* work_at(std::size_t i) const { return work_rows + kConservingRows * kWide * i; }
  INLINE double* node_at(std::size_t i) const { return nodes + kNodeSize * kWide * i; }
  INLINE double* start_at(std::size_t i) const { return starts + kStartRows * kWide * i; }
  INLINE double* tie_block_at(std::size_t i) const { return tie_blocks + kTieBlock * kWide * i; }
  INLINE double* tie_factor_at(std::size_t i) const { return tie_factors + kTieFactor * kWide * i; }
  INLINE Vec<Lane> kept(Vec<Lane> now, Vec<Lane> before) const {
    return chosen(running > 0.5, now, before);
  }
};

inline std::size_t trees_of(const IslandView& p) {
  std::size_t trees = 0;
  for (std::size_t i = 0; i < p.count; ++i) trees += p.parents[i] < 0;
  return trees;
}

}  // namespace
}  // namespace pantin::detail::articulated
