#include "tools/pantin/view_files.hpp"

#include <algorithm>
#include <system_error>

namespace pantin::program {

namespace fs = std::filesystem;

FileWatch::Stamp FileWatch::look(const std::string& path) {
  std::error_code trouble;
  Stamp now;
  now.time = fs::last_write_time(path, trouble);
  if (!trouble) now.bytes = fs::file_size(path, trouble);
  now.is_there = !trouble;
  return now.is_there ? now : Stamp{};
}

void FileWatch::start(const std::vector<std::string>& paths) {
  files_.clear();
  for (const std::string& path : paths) {
    const Stamp now = look(path);
    files_.push_back({path, now, now});
  }
}

bool FileWatch::changed() {
  bool any = false;
  for (Watched& file : files_) {
    const Stamp now = look(file.path);
    const bool is_settled = now == file.seen;
    file.seen = now;
    if (!is_settled || !now.is_there || now == file.known) continue;
    file.known = now;
    any = true;
  }
  return any;
}

namespace {

/// Excludes schemas, which `pantin new` writes beside scenes.
bool is_scene_file(const fs::path& name) {
  const std::string ending = name.extension().string();
  if (ending != ".json" && ending != ".json5" && ending != ".jsonc") return false;
  return name.stem().extension() != ".schema";
}

}  // namespace

std::vector<std::string> scenes_beside(const std::string& path) {
  std::error_code trouble;
  fs::path folder = fs::path(path).parent_path();
  std::vector<std::string> found;
  for (fs::directory_iterator at(folder.empty() ? "." : folder, trouble), end;
       !trouble && at != end; at.increment(trouble))
    if (is_scene_file(at->path().filename()))
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
