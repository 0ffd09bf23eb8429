#include "tools/pantin/view_files.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

namespace pantin::program {

namespace fs = std::filesystem;

std::vector<FileWatch::Stamp> FileWatch::look() const {
  std::vector<Stamp> stamps;
  for (const std::string& path : paths_) {
    std::error_code trouble;
    Stamp now;
    now.time = fs::last_write_time(path, trouble);
    if (!trouble) now.bytes = fs::file_size(path, trouble);
    now.is_there = !trouble;
    stamps.push_back(now.is_there ? now : Stamp{});
  }
  return stamps;
}

void FileWatch::start(std::vector<std::string> paths) {
  paths_ = std::move(paths);
  known_ = seen_ = look();
}

bool FileWatch::changed() {
  std::vector<Stamp> now = look();
  const bool is_settled = now == seen_;
  seen_ = now;
  const bool all_there =
      std::all_of(now.begin(), now.end(), [](const Stamp& stamp) { return stamp.is_there; });
  if (!is_settled || !all_there || now == known_) return false;
  known_ = std::move(now);
  return true;
}

std::vector<std::string> scenes_beside(const std::string& path) {
  std::error_code trouble;
  fs::path folder = fs::path(path).parent_path();
  std::vector<std::string> found;
  for (fs::directory_iterator at(folder.empty() ? "." : folder, trouble), end;
       !trouble && at != end; at.increment(trouble))
    if (at->path().extension() == ".json")
      found.push_back((folder / at->path().filename()).string());
  if (place_of(path, found) == found.size()) found.push_back(path);
  std::sort(found.begin(), found.end());
  return found;
}

std::size_t place_of(const std::string& path, const std::vector<std::string>& scenes) {
  const auto same = [&](const std::string& other) { return fs::path(other) == fs::path(path); };
  return static_cast<std::size_t>(std::find_if(scenes.begin(), scenes.end(), same) -
                                  scenes.begin());
}

std::string free_name(const std::string& folder, const std::string& stem, const std::string& ext,
                      std::size_t least) {
  std::error_code trouble;
  fs::path path;
  do path = fs::path(folder) / (stem + "_" + std::to_string(++least) + ext);
  while (fs::exists(path, trouble));
  return path.string();
}

}  // namespace pantin::program
