#pragma once
/// Context shared by the groups of a recipe while they are built: messages, limits, finished
/// prefabs.
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/scene/build/build.hpp"
#include "engine/scene/build/mirror.hpp"
#include "engine/scene/poll.hpp"

namespace pantin::detail {

/// Counts of objects, in floating point, since a few lines can ask for more than any integer holds.
struct BuildCount {
  Real bodies = 0, links = 0, parts = 0;  // parts: shapes and keyframes
  Real copies = 0;                        // of prefabs, by grids
  Real name_bytes = 0;

  void add(const BuildCount& other, Real times);
};

/// A finished prefab.
struct BuiltPrefab {
  BuiltScene built;
  BuildCount count;  // of the whole prefab, without `copies`
};

struct BuildContext {
  BuildContext(const Recipe& recipe, BuildMessages& messages, const SceneLimits& limits);

  const Recipe& recipe;
  BuildMessages& messages;
  const SceneLimits& limits;
  Poll poll;
  BuildCount used;  // by all groups so far
  MirrorImages images;

  /// A prefab by name, built on first use; null after an error, which is reported at a member of
  /// `at`.
  const BuiltPrefab* prefab(const std::string& name, const ElementId& at, std::string_view member);
  /// The same by its index.
  const BuiltPrefab* built(std::uint32_t which, const ElementId& at, std::string_view member);

 private:
  enum class State { unknown, open, done, broken };

  void tell_of_cycle(std::uint32_t which, const ElementId& at, std::string_view member);
  void build(std::uint32_t which);

  std::map<std::pair<std::uint32_t, std::string_view>, std::uint32_t>
      number_of_;  // index of a prefab by scope and name; the first of a name
  std::vector<BuiltPrefab> built_;
  std::vector<State> states_;
  std::vector<std::uint32_t> open_;  // prefabs being built, outermost first
};

}  // namespace pantin::detail
