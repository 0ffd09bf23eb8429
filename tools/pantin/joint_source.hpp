#pragma once
// The object of a scene file that a joint comes from.
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/json/json.hpp"

namespace pantin::program {

using namespace detail;

/// Where the values of a joint stand.
struct JointSource {
  std::vector<NodeId> objects = {};  // the joint or its chain, then its classes and the defaults
  std::string shared = {};           // what else has these values: "all copies of prefab leg"
  bool is_shared_by_prefab = false;
  bool is_image = false;     // mirrored: positive translations are the other way round
  std::string missing = {};  // why there is no object, a clause; empty if there is one

  /// The nearest value of a key, which hides those behind it; kNoNode if none has it.
  NodeId value(const JsonDocument& json, std::string_view key) const;
  /// The text under a key, or nothing.
  std::string_view text(const JsonDocument& json, std::string_view key) const;
};

/// Finds a joint by its name in the World: of the scene's own list, of a chain, of a mirrored
/// group, or of a prefab of which an instance, a grid or a ring makes copies.
JointSource source_of_joint(const JsonDocument& json, std::string_view name);

}  // namespace pantin::program
