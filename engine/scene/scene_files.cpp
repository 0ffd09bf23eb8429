#include "engine/scene/scene_files.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "engine/scene/json/text_file.hpp"

namespace pantin::detail {

SceneFile::SceneFile(std::string named, std::string_view in_memory, const JsonLimits& limits)
    : name(std::move(named)), json(parse_json(in_memory, limits)), diagnostics(json, name) {}

SceneFile::SceneFile(std::string named, std::string from_disk, const JsonLimits& limits)
    : name(std::move(named)),
      owned(std::move(from_disk)),
      json(parse_json(owned, limits)),
      diagnostics(json, name) {}

bool SceneFile::is_json() const {
  return std::none_of(json.faults.begin(), json.faults.end(),
                      [](const JsonFault& f) { return f.node == kNoNode; });
}

JsonLimits SceneFiles::limits_of(std::string_view name) const {
  const bool is_json5 = name.ends_with(".json5") || name.ends_with(".jsonc");
  return {limits_.values - std::min(values_, limits_.values), limits_.depth,
          Poll(limits_.is_cancelled), is_json5 ? JsonStyle::json5 : JsonStyle::strict};
}

SceneFile& SceneFiles::open(std::string_view name, std::string_view text) {
  SceneFile& file = files_.emplace_back(std::string(name), text, limits_of(name));
  bytes_ += text.size(), values_ += file.json.nodes.size();
  return file;
}

SceneFile* SceneFiles::open(const std::string& path, SceneFile& named_by, NodeId named_at) {
  const auto refuse = [&](const std::string& why) {
    named_by.diagnostics.error(named_at, why);
    return nullptr;
  };
  std::error_code trouble;
  if (std::filesystem::is_other(path, trouble))  // a pipe may never end
    return refuse(path + ": found a device or a pipe, expected a scene file");
  const std::size_t most = limits_.bytes - std::min(bytes_, limits_.bytes);
  auto text = read_text(path, most, "a scene file");
  if (!text) return refuse(text.errors().front().message);
  bytes_ += text->size();
  SceneFile& file = files_.emplace_back(path, std::move(*text), limits_of(path));
  file.named_by = &named_by, file.named_at = named_at;
  values_ += file.json.nodes.size();
  return &file;
}

std::size_t SceneFiles::error_count() const {
  std::size_t count = 0;
  for (const SceneFile& file : files_) count += file.diagnostics.error_count();
  return count;
}

bool SceneFiles::any_errors() const {
  return std::any_of(files_.begin(), files_.end(),
                     [](const SceneFile& file) { return file.diagnostics.any_errors(); });
}

std::vector<Error> SceneFiles::errors() {
  for (auto file = files_.rbegin(); file != files_.rend(); ++file)
    if (file->named_by && file->diagnostics.any_errors())
      file->named_by->diagnostics.error(
          file->named_at, "found errors in \"" + file->name + "\", expected a valid file");
  std::vector<Error> all;
  for (const SceneFile& file : files_)
    for (Error& error : file.diagnostics.errors()) all.push_back(std::move(error));
  return all;
}

std::vector<std::string> SceneFiles::warnings() const {
  std::vector<std::string> all;
  for (const SceneFile& file : files_)
    for (std::string& line : file.diagnostics.warnings()) all.push_back(std::move(line));
  return all;
}

std::vector<std::string> SceneFiles::names() const {
  std::vector<std::string> names;
  for (std::size_t i = 1; i < files_.size(); ++i) names.push_back(files_[i].name);
  return names;
}

}  // namespace pantin::detail
