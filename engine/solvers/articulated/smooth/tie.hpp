#pragma once
/// Forces between two points in a step by the energy-momentum method.
#include <cstdint>

#include "engine/base/math.hpp"
#include "engine/solvers/articulated/lane_layout.hpp"

namespace pantin::detail::articulated {

/// An inextensible cable in a substep: open, may become taut; followed, stays slack until it
/// reaches its length, where the substep ends.
enum class CableRow : std::uint8_t { open, followed };
/// The rows of a tie in the equations that couple ties: the first `count`, with an impulse along as
/// many directions.
struct TieRows {
  int count = 3;              // 0, 1 or 3
  Mat3 by = Mat3(1);          // of the change of d: a column each
  Vec3 right{0};              // right-hand side
  Mat3 own{0};                // factor of the impulse
  Mat3 directions = Mat3(1);  // a column each
};

enum class TieKind : std::uint8_t { rigid, spring, cable, taut, slack };
/// Kind, state and end points of a tie.
struct TiePlace {
  TieKind kind = TieKind::rigid;
  bool still = true;                    // closed, and its fixed point in the world is at rest
  bool open = false;                    // rigid, with a gap larger than by its compliance
  bool was_taut = false;                // an inextensible cable: at the start
  bool followed = false;                // likewise: see CableRow
  bool strikes = false;                 // likewise: takes part in the impact at the end
  bool grounded = false;                // leads to the world: the derivative of its impulse is part
                                        // of its body's block; no row, or only one for its length
  std::uint32_t a = UINT32_MAX, b = 0;  // columns; a: UINT32_MAX is the world
  std::uint32_t cable = UINT32_MAX;     // in Island::cables
  Vec3 anchor_a{0}, anchor_b{0};        // from the own joints, body frames
};

/// A force between two points in a step by the energy-momentum method: see conserving_ties.cpp.
struct ConservingTie : TiePlace {
  Vec3 way{0}, velocity{0};         // of the point in the world: over the substep, at the end
  Vec3 before{0}, now{0};           // from a's point to b's, at the start and at the end
  Real stiffness = 0, damping = 0;  // N/m, N s/m
  Real across = 0;                  // of a cable: mu by the mean of d, kg/s
  Real length = 0, rate = 0;        // m, m/s, of a cable: at the end
  Real softness = 0;                // s/kg, of a rigid tie or a taut cable
  Real response = 0;                // s/kg: change of d by an impulse
  Vec3 start_a{0}, start_b{0}, mean_a{0}, mean_b{0}, end_a{0}, end_b{0};  // arms
  Vec3 mu{0};          // impulse over half the step that pulls b to a, kg m/s
  Mat3 derivative{0};  // of mu by `now`
};

/// A row of the equations that couple ties: the first step of its path, the first of its shares.
struct TieRow {
  std::uint32_t path, count, share;
};

/// A row at a body of its path: the rotation that its impulse causes there, apart from other
/// bodies, and the row's gradient by that rotation. At a free root's own entry, displacements.
struct TieShare {
  Vec3 turn, by_turn;
};

/// Impulses and gradients accumulated along a path from the tie to the root.
struct TiePassing {
  Vec3 impulse{0}, torque{0}, by_move{0}, by_turn{0};
};

}  // namespace pantin::detail::articulated
