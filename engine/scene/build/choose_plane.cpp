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
  std::vector<std::uint32_t> slots;
  bool is_solid = false;
  std::string why;
};

std::vector<Choice> choices_for(const World& world) {
  std::vector<Choice> choices;
  const std::vector<IslandPlan> islands = find_islands(world);
  std::vector<std::string> faults = plane_faults(world, islands);
  for (std::size_t i = 0; i < islands.size(); ++i) {
    const IslandPlan& island = islands[i];
    const auto has_own = [&](std::uint32_t slot) {
      return world.settings.find(world.bodies.owners()[slot]) != nullptr;
    };
    if (std::any_of(island.slots.begin(), island.slots.end(), has_own)) continue;
    Choice choice{island.slots.front(), island.slots, false, std::move(faults[i])};
    for (const std::uint32_t slot : island.slots)
      if (const Collision* c = world.collisions.find(world.bodies.owners()[slot]))
        choice.is_solid = choice.is_solid || !c->sensor;
    choices.push_back(std::move(choice));
  }
  return choices;
}

/// Assigns the solver "planar" to the islands that have no fault. Bodies that collide are left out
/// unless all of them are in the plane: others could touch them.
void assign(const std::vector<Choice>& choices, World& world) {
  const bool all_solid = std::none_of(choices.begin(), choices.end(),
                                      [](const Choice& c) { return c.is_solid && !c.why.empty(); });
  for (const Choice& c : choices) {
    if (!c.why.empty() || (c.is_solid && !all_solid)) continue;
    SolverSettings settings = world.default_settings;
    settings.solver = Solver::planar;
    world.settings.add(world.bodies.owners()[c.slot], settings);
  }
}

}  // namespace

void choose_plane(World& world, BuildMessages& messages) {
  const ElementId scene{ElementKind::group, 0, 0};
  if (!has_planar_solver())
    return messages.warn(scene, "plane",
                         "\"plane\" has no effect: this build of pantin was made without Box2D");
  const std::vector<Choice> choices = choices_for(world);
  for (const Choice& c : choices)
    if (!c.why.empty())
      messages.warn(scene, "plane",
                    "\"" + world.name_of(world.bodies.owners()[c.slot]) +
                        "\" is not solved by \"planar\": " + c.why);
  assign(choices, world);
}

}  // namespace pantin::detail
