#pragma once
/// Laminas and their fingers as bodies of a scene.
#include <vector>

#include "engine/modes/lamina_plan.hpp"
#include "engine/scene/recipe.hpp"

namespace pantin::detail {

/// What they are added to.
struct LaminaParts {
  std::vector<BodyRecipe>& bodies;
  std::vector<Material>& materials;
};
/// A plate of the outline, and for each finger a ball or a bar, kinematic. Of what is_body().
void add_lamina_bodies(const LaminaPlan& lamina, const SolverSettings& how, const LaminaParts& out);

}  // namespace pantin::detail
