#pragma once
// Results of a long command on disk, one line of JSON each, so that it goes on where it was
// interrupted.
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/pantin/program.hpp"

namespace pantin::program {

/// A file of results by key. Each result is written at once, as a whole line; a line that was cut
/// off is dropped when the file is read again.
class Journal {
 public:
  enum class Earlier : std::uint8_t { kept, discarded };
  Journal() = default;
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Reads the results of earlier runs, or discards them; then appends.
  Result<Done> open(const std::string& path, Earlier earlier);
  /// Null: not known yet.
  const Json* find(const std::string& key) const;
  Result<Done> add(const std::string& key, Json result);

 private:
  std::string path_;
  int file_ = -1;
  std::map<std::string, Json> results_;
};

/// A hash of this program and the text of a scene with the files that it names: results are used
/// again only where both are the same.
std::uint64_t hash_of(const Scene& scene, std::string_view text);

/// Creates a folder and those above it.
Result<Done> make_folder(const std::string& path);

/// Runs the script that draws results, with matplotlib, on a folder. Prints one line if it cannot
/// run; the results are complete without pictures. `what` is "chart" or "map". Whether it drew.
bool draw_results(const std::string& what, const std::string& folder);

}  // namespace pantin::program
