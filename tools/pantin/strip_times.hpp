#pragma once
// The times of the pictures in a filmstrip.
#include <cstdint>
#include <optional>

#include "engine/scene/scene.hpp"

namespace pantin::program {

using namespace detail;

/// The period with which the last part of a run repeats, s: the configurations of all bodies over
/// the last period, and those over the period before, differ by at most a few hundredths of the
/// motion. None for a run of fewer than two periods, for a motion that does not repeat, and for
/// more than kMostFollowed bodies. Runs a copy of the scene.
inline constexpr std::size_t kMostFollowed = 200;
std::optional<double> period_of_run(const Scene& scene, std::uint64_t steps);

}  // namespace pantin::program
