#pragma once
// Parts of `pantin assemble`: poses and design variables written into a scene file, pictures.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "engine/assembly/assemble.hpp"
#include "engine/base/result.hpp"
#include "engine/scene/build/joint_place.hpp"
#include "engine/scene/json/json.hpp"
#include "engine/world/world.hpp"
#include "tools/pantin/pictures.hpp"

namespace pantin::program {

using namespace detail;

/// The text of a scene file with the poses of a World as its "poses": of bodies that are not where
/// `start` has them, or whose pose the file gives there already. Comments and all other keys stay.
Result<std::string> with_poses(std::string_view text, const World& start, const World& world);

/// The text of a scene file with the design variables of a World. Those from prefabs and generators
/// stay.
std::string with_design(std::string_view text, const World& world,
                        const std::vector<SceneFree>& free);

/// The end of a value in the text of a document.
std::size_t end_of_member(const JsonDocument& json, NodeId value);

/// "joints/3/length 0.3 -> 0.303"
std::string words_of(const World& world, const SceneFree& free,
                     const assembly::DesignChange& change);
nlohmann::json design_to_json(const World& world, const std::vector<SceneFree>& free,
                              const std::vector<assembly::DesignChange>& changes);

/// The iterations of an assembly: poses of all bodies, and the largest residual, m or rad.
struct AssemblyFilm {
  std::vector<std::vector<Pose>> poses;
  std::vector<double> residuals;
};
/// Draws frames, films and a strip of them; `scene` has the poses of the end. The camera moves back
/// where parts reach beyond the picture. Returns the exit code.
int draw_assembly(const PictureChoices& choices, const Scene& scene, const AssemblyFilm& film);

}  // namespace pantin::program
