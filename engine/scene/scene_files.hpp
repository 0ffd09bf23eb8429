#pragma once
/// The files of a scene: its own, and those of its prefabs.
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/json/diagnostics.hpp"
#include "engine/scene/scene.hpp"

namespace pantin::detail {

/// One file, with its diagnostics. Its address is stable.
struct SceneFile {
  SceneFile(std::string named, std::string_view in_memory, const JsonLimits& limits);
  SceneFile(std::string named, std::string from_disk, const JsonLimits& limits);
  SceneFile(const SceneFile&) = delete;
  SceneFile& operator=(const SceneFile&) = delete;

  /// Returns false if the text is not JSON.
  bool is_json() const;

  std::string name;
  std::string owned;  // the text, unless it is owned elsewhere
  JsonDocument json;
  Diagnostics diagnostics;
  SceneFile* named_by = nullptr;  // the file and position that name it
  NodeId named_at = kNoNode;
};

class SceneFiles {
 public:
  explicit SceneFiles(const SceneLimits& limits) : limits_(limits) {}

  /// The scene itself. `text` must outlive it.
  SceneFile& open(std::string_view name, std::string_view text);
  /// A file that another file names; null after an error there. Its bytes and values count towards
  /// the common limits.
  SceneFile* open(const std::string& path, SceneFile& named_by, NodeId named_at);

  SceneFile& first() { return files_.front(); }
  std::size_t error_count() const;
  bool any_errors() const;
  /// File by file; an error also lists the position that names its file.
  std::vector<Error> errors();
  std::vector<std::string> warnings() const;
  /// The names of all files but the scene itself.
  std::vector<std::string> names() const;

 private:
  JsonLimits limits_of(std::string_view name) const;

  const SceneLimits& limits_;
  std::deque<SceneFile> files_;
  std::size_t bytes_ = 0, values_ = 0;
};

}  // namespace pantin::detail
