#pragma once
/// Elements of a scene file, found after it was read.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"
#include "engine/world/design.hpp"

namespace pantin::detail {

/// Reads a scene whose bodies may be anywhere, for assembly: bilateral surfaces need not be in
/// contact.
Result<Scene> load_scene_in_parts(const std::string& path, const SolverChoices& solver);

/// What a scene with "error" has chosen for its groups of bodies that cannot meet, and why: one
/// line for each solver and reason. None without "error". Reads the file again.
std::vector<std::string> lines_of_models(const std::string& path);

/// An error of a joint, by its name in the World: file, position and JSON pointer of the element
/// that it was built from, then the message. Reads the file again; without a position if the file
/// has changed.
Error error_of_joint(const std::string& path, std::string_view joint, const std::string& message);

/// A design variable of a scene.
struct SceneFree {
  std::string path;  // as written: "joints/3/length"
  DesignVariable variable;
  std::string_view list;  // the key of its list: "joints", "surfaces"
  // Its element in the list of the file; none: it comes from a prefab or generator.
  std::optional<std::uint32_t> element;
  std::vector<std::uint32_t> images{};  // a control point: its numbers in the face or curve
};

/// The design variables of a scene that was read from a file, and of further paths, whose errors
/// begin with `option`. Reads the file again.
struct FurtherFree {
  std::string option;
  std::vector<std::string> paths;
};
Result<std::vector<SceneFree>> free_numbers(const std::string& file, const World& world,
                                            const FurtherFree& further);

}  // namespace pantin::detail
