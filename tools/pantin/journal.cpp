#include "tools/pantin/journal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "engine/base/atomic_file.hpp"
#include "engine/base/hash.hpp"
#include "engine/scene/json/text_file.hpp"

extern char** environ;

namespace pantin::program {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = 1u << 30;  // of a file that is read

std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A hash of the bytes of this program, once.
std::uint64_t program_hash() {
  static const std::uint64_t kHash = [] {
    Hash hash;
    hash.add(std::string_view(text_of("/proc/self/exe")));
    return hash.value();
  }();
  return kHash;
}

/// The script beside the program: share/pantin/draw.py next to its folder.
fs::path script() {
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none);
  return program.parent_path().parent_path() / "share/pantin/draw.py";
}

}  // namespace

Journal::~Journal() {
  if (file_ >= 0) close(file_);
}

Result<Done> Journal::open(const std::string& path, Earlier earlier) {
  path_ = path;
  std::string whole;
  if (earlier == Earlier::kept && fs::exists(path)) {
    Result<std::string> text = detail::read_text(path, kMostBytes, "results of earlier runs");
    if (!text) return text.errors();
    for (std::size_t at = 0, end; (end = text->find('\n', at)) != std::string::npos; at = end + 1) {
      const std::string line = text->substr(at, end - at);
      Json entry = Json::parse(line, nullptr, false);
      if (!entry.is_object() || !entry.contains("key") || !entry["key"].is_string()) continue;
      results_[entry["key"].get<std::string>()] = std::move(entry["result"]);
      whole += line + '\n';
    }
  }
  // What was read is written again: without lines that were cut off.
  if (auto written = write_file(path, whole); !written) return written;
  file_ = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (file_ < 0) return Error{path + ": " + std::strerror(errno)};
  return Done{};
}

const Json* Journal::find(const std::string& key) const {
  const auto found = results_.find(key);
  return found == results_.end() ? nullptr : &found->second;
}

Result<Done> Journal::add(const std::string& key, Json result) {
  const std::string line =
      Json{{"key", key}, {"result", result}}.dump(-1, ' ', true, Json::error_handler_t::replace) +
      '\n';
  results_[key] = std::move(result);
  for (std::size_t done = 0; done < line.size();) {
    const ssize_t n = write(file_, line.data() + done, line.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return Error{path_ + ": " + std::strerror(errno)};
    done += static_cast<std::size_t>(n);
  }
  return Done{};
}

std::uint64_t hash_of(const Scene& scene, std::string_view text) {
  Hash hash;
  hash.add(program_hash());
  hash.add(text);
  for (const std::string& file : scene.files) hash.add(std::string_view(text_of(file)));
  return hash.value();
}

Result<Done> make_folder(const std::string& path) {
  std::error_code fault;
  fs::create_directories(path, fault);
  if (fault) return Error{path + ": " + fault.message()};
  return Done{};
}

bool draw_results(const std::string& what, const std::string& folder) {
  const std::string file = script().string();
  if (!fs::exists(file)) {
    complain("no pictures: " + file + " was not found");
    return false;
  }
  std::vector<std::string> words{"python3", "-B", file, what, folder};
  std::vector<char*> arguments;
  for (std::string& w : words) arguments.push_back(w.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  if (const int fault =
          posix_spawnp(&child, "python3", nullptr, nullptr, arguments.data(), environ)) {
    complain(fmt::format("no pictures: python3 could not be started: {}", std::strerror(fault)));
    return false;
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  // The script says itself why it drew nothing.
  if (!WIFEXITED(status)) complain("no pictures: the script that draws them was ended");
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace pantin::program
