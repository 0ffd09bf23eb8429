#pragma once
/// Fills a recipe from a scene file in JSON, and records the position of each element.
#include <array>
#include <string>
#include <vector>

#include "engine/scene/build/build_messages.hpp"
#include "engine/scene/recipe.hpp"
#include "engine/scene/scene_files.hpp"

namespace pantin::detail {

class JsonPlaces final : public BuildMessages {
 public:
  explicit JsonPlaces(SceneFiles& files) : files_(files) {}

  /// Sets the file of a group's elements; call it before they are added.
  void open_group(std::uint32_t group, SceneFile& file);
  /// Records the position of the next element of a kind, group by group.
  void add(std::uint32_t group, ElementKind kind, NodeId node);
  NodeId node(const ElementId& at) const;

  void error(const ElementId& at, std::string_view member, std::string message) override;
  void warn(const ElementId& at, std::string_view kind, std::string message) override;
  std::size_t errors() const override { return files_.error_count(); }
  Hints& hints() override { return files_.first().diagnostics.hints; }

 private:
  static constexpr std::size_t kKinds = static_cast<std::size_t>(ElementKind::free) + 1;
  struct GroupPlaces {
    SceneFile* file = nullptr;
    std::array<std::vector<NodeId>, kKinds> nodes;
  };

  SceneFiles& files_;
  std::vector<GroupPlaces> groups_;
};

/// Reads the first file, and those of its prefabs. Reports errors in them, and fills `places`.
Recipe read_recipe(SceneFiles& files, JsonPlaces& places, const SceneLimits& limits);

}  // namespace pantin::detail
