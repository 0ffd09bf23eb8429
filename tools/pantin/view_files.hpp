#pragma once
// The files around a viewer: the scene that it shows, its neighbours.
#include <filesystem>
#include <string>
#include <vector>

namespace pantin::program {

/// Tells when one of some files has been written anew.
class FileWatch {
 public:
  /// From now on; what the files are like at present is known.
  void start(std::vector<std::string> paths);
  /// Once for each change, when all files have stayed the same between two calls: editors write in
  /// pieces. A file that is away is waited for.
  bool changed();

 private:
  struct Stamp {
    std::filesystem::file_time_type time{};
    std::uintmax_t bytes = 0;
    bool is_there = false;
    bool operator==(const Stamp&) const = default;
  };
  std::vector<Stamp> look() const;

  std::vector<std::string> paths_;
  std::vector<Stamp> known_, seen_;
};

/// The scene files of a scene's folder, sorted by name, itself included.
std::vector<std::string> scenes_beside(const std::string& path);

/// The place of `path` in a list of such files; the size of the list if it is not in it.
std::size_t place_of(const std::string& path, const std::vector<std::string>& scenes);

/// `stem_1.ext`, or the first number above `least` that is free in a folder.
std::string free_name(const std::string& folder, const std::string& stem, const std::string& ext,
                      std::size_t least);

}  // namespace pantin::program
