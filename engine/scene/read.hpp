#pragma once
/// The pieces that read_recipe() is made of.
#include <optional>
#include <vector>

#include "engine/scene/reader.hpp"
#include "engine/scene/recipe.hpp"

namespace pantin {

/// What every part of a file is read against.
struct Reading {
  const JsonDocument& json;
  Complaints& complaints;
  const SceneLimits& limits;
  std::vector<Material> materials{};  // the first is the default
  SolverSettings solver{};            // of the scene; bodies and instances change some of it

  Reader open(NodeId node, std::string_view what) const {
    return Reader(json, complaints, node, keys_of(what));
  }
};

/// Settings under "solver", where keys that are absent keep the values of `base`.
std::optional<SolverSettings> read_solver(const Reading& reading, const Reader& from,
                                          const SolverSettings& base);

/// The index of a material by name, or of `otherwise`.
std::uint32_t read_material(const Reading& reading, const Reader& from, std::uint32_t otherwise);

/// The same, where `node` is the name itself.
std::uint32_t find_material(const Reading& reading, NodeId node, std::uint32_t otherwise);

/// Shapes, mass, mass centre and inertia. The frame of a body that is not dynamic stays its own,
/// since nothing turns it about its mass centre.
Matter read_matter(const Reading& reading, const Reader& from, Motion motion);

std::optional<Reference> read_reference(const Reader& from, std::string_view key,
                                        std::string_view expected, bool is_needed);

BodyRecipe read_body(const Reading& reading, NodeId node);
std::optional<JointRecipe> read_joint(const Reading& reading, NodeId node);
std::optional<StringRecipe> read_string(const Reading& reading, NodeId node);
std::optional<PinRecipe> read_pin(const Reading& reading, NodeId node);
std::optional<DriveRecipe> read_drive(const Reading& reading, NodeId node);
std::optional<InstanceRecipe> read_instance(const Reading& reading, NodeId node);
std::optional<GridRecipe> read_grid(const Reading& reading, NodeId node);
ChainRecipe read_chain(const Reading& reading, NodeId node);  // links == 0 if it cannot be read

}  // namespace pantin
