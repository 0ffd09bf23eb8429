// Chooses which islands of a scene are solved in the plane.
#include <algorithm>

#include "engine/scene/build/build.hpp"
#include "engine/world/flat.hpp"
#include "engine/world/partition.hpp"

namespace pantin::detail {
namespace {

/// An island, and why it cannot be moved in the plane.
struct Choice {
  std::uint32_t slot = 0;  // of its first body
  bool is_solid = false;
  std::string why;
};

std::vector<Choice> choices_for(const World& world) {
  std::vector<Choice> choices;
  for (const IslandPlan& island : find_islands(world)) {
    const auto has_own = [&](std::uint32_t slot) {
      return world.settings.find(world.bodies.owners()[slot]) != nullptr;
    };
    if (std::any_of(island.slots.begin(), island.slots.end(), has_own)) continue;
    Choice choice{island.slots.front(), false, {}};
    choice.why = plane_fault(world, world.bodies.owners()[choice.slot]);
    for (const std::uint32_t slot : island.slots)
      if (const Collision* c = world.collisions.find(world.bodies.owners()[slot]))
        choice.is_solid = choice.is_solid || !c->sensor;
    choices.push_back(std::move(choice));
  }
  return choices;
}

}  // namespace

void choose_plane(World& world, BuildMessages& messages) {
  const ElementId scene{ElementKind::group, 0, 0};
  if (!has_planar_solver())
    return messages.warn(scene, "plane",
                         "\"plane\" has no effect: this build of pantin was made without Box2D");
  std::vector<Choice> choices = choices_for(world);
  const bool all_solid = std::none_of(choices.begin(), choices.end(),
                                      [](const Choice& c) { return c.is_solid && !c.why.empty(); });
  for (const Choice& c : choices) {
    const Entity body = world.bodies.owners()[c.slot];
    if (!c.why.empty()) {
      messages.warn(scene, "plane",
                    "\"" + world.name_of(body) + "\" is not solved by \"planar\": " + c.why);
    } else if (!c.is_solid || all_solid) {
      SolverSettings settings = world.default_settings;
      settings.solver = Solver::planar;
      world.settings.add(body, settings);
    }
  }
}

}  // namespace pantin::detail
