#pragma once
/// The files that a scene is read from: itself, and those that its prefabs come from.
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/json/diagnostics.hpp"
#include "engine/scene/scene.hpp"

namespace pantin::detail {

/// One file, and what there is to say of it. Stays where it is.
struct SceneFile {
  SceneFile(std::string named, std::string_view in_memory, const JsonLimits& limits);
  SceneFile(std::string named, std::string from_disk, const JsonLimits& limits);
  SceneFile(const SceneFile&) = delete;
  SceneFile& operator=(const SceneFile&) = delete;

  /// False: too broken to be read any further.
  bool is_json() const;

  std::string name;
  std::string owned;  // the text, unless somebody else owns it
  JsonDocument json;
  Diagnostics diagnostics;
  SceneFile* named_by = nullptr;  // the file that names it, and where
  NodeId named_at = kNoNode;
};

class SceneFiles {
 public:
  explicit SceneFiles(const SceneLimits& limits) : limits_(limits) {}

  /// The scene itself. `text` must outlive it.
  SceneFile& open(std::string_view name, std::string_view text);
  /// A file that another names; null after an error there. Bytes and values count with those of all
  /// others.
  SceneFile* open(const std::string& path, SceneFile& named_by, NodeId named_at);

  SceneFile& first() { return files_.front(); }
  std::size_t error_count() const;
  bool any_errors() const;
  /// File by file; where a file has mistakes, the place that names it is told too.
  std::vector<Error> errors();
  std::vector<std::string> warnings() const;
  /// Of all but the scene itself.
  std::vector<std::string> names() const;

 private:
  JsonLimits limits_of(std::string_view name) const;

  const SceneLimits& limits_;
  std::deque<SceneFile> files_;
  std::size_t bytes_ = 0, values_ = 0;
};

}  // namespace pantin::detail
