#pragma once
/// Fills a recipe from a scene file in JSON, and remembers where each element stands in it.
#include <array>
#include <string>
#include <vector>

#include "engine/scene/build_messages.hpp"
#include "engine/scene/diagnostics.hpp"
#include "engine/scene/recipe.hpp"

namespace pantin::detail {

class JsonPlaces final : public BuildMessages {
 public:
  JsonPlaces(const JsonDocument& json, Diagnostics& diagnostics)
      : json_(json), complaints_(diagnostics) {}

  /// Notes where the next element of a kind stands, group by group.
  void add(std::uint32_t group, ElementKind kind, NodeId node);
  NodeId node(const ElementId& at) const;
  Diagnostics& diagnostics() { return complaints_; }

  void error(const ElementId& at, std::string_view member, std::string message) override;
  void warn(const ElementId& at, std::string_view kind, std::string message) override;
  std::size_t errors() const override { return complaints_.error_count(); }
  Hints& hints() override { return complaints_.hints; }

 private:
  static constexpr std::size_t kKinds = static_cast<std::size_t>(ElementKind::event) + 1;
  using Nodes = std::array<std::vector<NodeId>, kKinds>;

  const JsonDocument& json_;
  Diagnostics& complaints_;
  std::vector<Nodes> groups_;
};

/// What a reader needs besides the text.
struct ReadContext {
  const SceneLimits& limits;
  std::string folder;  // files that the scene names are looked for here
};

/// Complains through `places`, and fills it.
Recipe read_recipe(const JsonDocument& json, JsonPlaces& places, const ReadContext& context);

}  // namespace pantin::detail
