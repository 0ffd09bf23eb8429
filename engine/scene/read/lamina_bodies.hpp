#pragma once
/// Laminas and their fingers as bodies of a scene.
#include <vector>

#include "engine/modes/lamina_plan.hpp"
#include "engine/scene/recipe.hpp"

namespace pantin::detail {

/// The lists that they are added to.
struct LaminaParts {
  std::vector<BodyRecipe>& bodies;
  std::vector<Material>& materials;
};
/// Adds a plate for the outline, and a kinematic ball or bar for each finger. Requires is_body().
void add_lamina_bodies(const LaminaPlan& lamina, const SolverSettings& how, const LaminaParts& out);

}  // namespace pantin::detail
