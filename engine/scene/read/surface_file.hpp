#pragma once
/// Files of NURBS surfaces: JSON of the kind "surface", as in scenes.
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/geometry/shape.hpp"
#include "engine/nurbs/skin.hpp"

namespace pantin::detail {

/// A surface, and the warnings about it.
struct LoadedSurface {
  std::shared_ptr<const Surface> surface;
  std::vector<std::string> warnings;
};

/// Reads a file. Errors are lines as of scene files: file, line, JSON pointer, found, expected.
Result<LoadedSurface> load_surface(const std::string& path);

/// The text of such a file. Reading it back gives the same bits.
std::string surface_text(const nurbs::Skin& skin);

}  // namespace pantin::detail
