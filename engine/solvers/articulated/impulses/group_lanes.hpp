#pragma once
/// Contact points of pairs of bodies without joints, four pairs side by side.
#include "engine/solvers/articulated/impulses/group_points.hpp"
#include "engine/solvers/articulated/kernels.hpp"

namespace pantin::detail::articulated {

/// After the contacts are placed: forms batches of the pairs in lanes with active points, and
/// computes their responses.
void prepare_lanes(const Group& g);
/// Applies the accumulated impulses of all contacts in lanes.
void push_lanes(const Group& g);
/// One sweep over the contacts in lanes. Returns the largest change of speed, m/s.
Real sweep_lanes(const Group& g, const Substep& s, Sweep sweep, Order order);

}  // namespace pantin::detail::articulated
