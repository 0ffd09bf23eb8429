#include "tools/pantin/states.hpp"

#ifdef PANTIN_HAS_RENDER
#include "engine/runtime/simulation.hpp"

namespace pantin::program {

using namespace detail;

namespace {

// Told apart with any colour vision, by lightness too.
constexpr Vec3 kFixed{0.45, 0.45, 0.45}, kKinematic{0.60, 0.19, 0.39}, kAwake{0.79, 0.35, 0.0},
    kAsleep{0.0, 0.09, 0.25};

}  // namespace

std::vector<Vec3> state_colours(const World& world) {
  std::vector<Vec3> colours;
  for (std::uint32_t slot = 0; slot < world.bodies.size(); ++slot) {
    const Motion motion = world.bodies.values()[slot].motion;
    if (motion == Motion::fixed)
      colours.push_back(kFixed);
    else if (motion == Motion::kinematic)
      colours.push_back(kKinematic);
    else
      colours.push_back(is_asleep(world, world.bodies.owners()[slot]) ? kAsleep : kAwake);
  }
  return colours;
}

std::vector<LegendEntry> states_legend(const World& world) {
  bool fixed = false, kinematic = false, dynamic = false;
  for (const Body& b : world.bodies.values()) {
    fixed |= b.motion == Motion::fixed;
    kinematic |= b.motion == Motion::kinematic;
    dynamic |= b.motion == Motion::dynamic;
  }
  std::vector<LegendEntry> entries;
  if (dynamic) entries.push_back({kAwake, "dynamic, awake"});
  if (dynamic) entries.push_back({kAsleep, "dynamic, asleep"});
  if (kinematic) entries.push_back({kKinematic, "kinematic"});
  if (fixed) entries.push_back({kFixed, "fixed"});
  return entries;
}

}  // namespace pantin::program
#endif
