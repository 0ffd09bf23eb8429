#include "engine/world/findings.hpp"

namespace pantin {
namespace {

constexpr FindingInfo kInfos[] = {
    {"energy_gained", "J",
     "Bodies that are joined or touch have more energy than they began with and all work done on "
     "them, by more than a twentieth of what moves them.",
     "Take a shorter step; then the solver \"lagrangian\" with the integrator \"radau\"."},
    {"joint_open", "m", "A joint is open by more than a thousandth of its mechanism's size.",
     "Use the solver \"auto\" or \"lagrangian\"; check that no two joints contradict each other."},
    {"cable_overlong", "m",
     "A cable that cannot stretch is longer than its length by more than a thousandth of its "
     "mechanism's size.",
     "Take a shorter step; check that the bodies at its ends can come so near."},
};
static_assert(std::size(kInfos) == static_cast<std::size_t>(last_of(FindingKind{})) + 1);

}  // namespace

const FindingInfo& info_of(FindingKind kind) { return kInfos[static_cast<int>(kind)]; }

}  // namespace pantin
