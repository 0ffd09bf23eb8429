#pragma once
/// Bodies as triangles, for files of models.
#include <array>
#include <vector>

#include "engine/render/bounds.hpp"

namespace pantin::detail {

/// Triangles of one material.
struct ModelPart {
  Material material;
  std::vector<std::array<float, 3>> positions;  // m, in the body's own frame (World::origin_pose)
  std::vector<std::array<float, 3>> normals;    // unit
  std::vector<std::uint32_t> indices;           // counter-clockwise seen from outside
};

/// The shapes of a body as they are drawn, and its curves in contact. Empty for another entity.
std::vector<ModelPart> model_of(const World& world, Entity body);

/// A tube from the origin to (0, 1, 0), open at its ends.
ModelPart tube(Real radius);

}  // namespace pantin::detail
