// The inner loops of the solver, pass by pass in the files of kernels/. Compiled once per
// instruction set; PANTIN_KERNELS is its name.
#include "engine/solvers/articulated/kernels.hpp"

#include "engine/solvers/articulated/kernels/blocks.hpp"
#include "engine/solvers/articulated/kernels/conserving.hpp"
#include "engine/solvers/articulated/kernels/geometry.hpp"
#include "engine/solvers/articulated/kernels/inward.hpp"
#include "engine/solvers/articulated/kernels/island_lanes.hpp"
#include "engine/solvers/articulated/kernels/pair_lanes.hpp"
#include "engine/solvers/articulated/kernels/pairs.hpp"
#include "engine/solvers/articulated/kernels/predict.hpp"
#include "engine/solvers/articulated/kernels/sweep.hpp"
#include "engine/solvers/articulated/kernels/velocities.hpp"

#ifndef PANTIN_KERNELS
#define PANTIN_KERNELS baseline
#endif

namespace pantin::detail::articulated {

#define PANTIN_TEXT_OF(word) #word
#define PANTIN_TEXT(word) PANTIN_TEXT_OF(word)

#define PANTIN_JOINED_OF(a, b) a##b
#define PANTIN_JOINED(a, b) PANTIN_JOINED_OF(a, b)
extern const Kernels PANTIN_JOINED(kernels_, PANTIN_KERNELS);
const Kernels PANTIN_JOINED(kernels_, PANTIN_KERNELS) = {PANTIN_TEXT(PANTIN_KERNELS),
                                                         predict,
                                                         levers,
                                                         prepare,
                                                         fill_blocks,
                                                         inward_pass,
                                                         sweep,
                                                         apply_poses,
                                                         update_velocities,
                                                         sweep_and_update,
                                                         conserve,
                                                         conserve_lanes,
                                                         kWide,
                                                         lane_numbers,
                                                         scale,
                                                         add_path_responses,
                                                         subtract_products,
                                                         multiply_motions,
                                                         iterate_pair,
                                                         prepare_pairs,
                                                         push_pairs,
                                                         solve_pairs,
                                                         subtract_row};

}  // namespace pantin::detail::articulated

#undef INLINE
