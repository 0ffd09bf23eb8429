#pragma once
// Files of the viewer: its scene, and the other scenes in its folder.
#include <filesystem>
#include <string>
#include <vector>

namespace pantin::program {

/// Detects changes of several files.
class FileWatch {
 public:
  /// Starts watching; the present state counts as known.
  void start(const std::vector<std::string>& paths);
  /// Reports each change once, as soon as the file is unchanged between two calls, because editors
  /// write in pieces. A missing file is waited for.
  bool changed();

 private:
  struct Stamp {
    std::filesystem::file_time_type time{};
    std::uintmax_t bytes = 0;
    bool is_there = false;
    bool operator==(const Stamp&) const = default;
  };
  struct Watched {
    std::string path;
    Stamp known, seen;
  };
  static Stamp look(const std::string& path);

  std::vector<Watched> files_;
};

/// The scene files in the folder of a scene, itself included, sorted by name.
std::vector<std::string> scenes_beside(const std::string& path);

/// The index of `path` in a list of such files; the size of the list if it is missing.
std::size_t place_of(const std::string& path, const std::vector<std::string>& scenes);

/// `stem_1.ext`, or the first free number above `least` in a folder.
std::string free_name(const std::string& folder, const std::string& stem, const std::string& ext,
                      std::size_t least);

}  // namespace pantin::program
