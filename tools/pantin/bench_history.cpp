// Rows of `pantin bench` kept over time.
#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>  // join, since fmt 11
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <fstream>

#include "tools/pantin/bench.hpp"

namespace pantin::program {
namespace {

constexpr const char* kHead[] = {"version", "commit", "compiler", "kernels", "cpu", "load"};
constexpr const char* kRow[] = {"scene",         "solver",       "step_s",
                                "steps",         "repeats",      "frame_ms_median",
                                "frame_ms_p95",  "frame_ms_p99", "frame_ms_max",
                                "frame_ms_mean", "late_steps",   "allocations_per_step",
                                "worst_gap_rel", "status",       "timed_hash"};

std::string cell_of(const Json& object, const char* key) {
  if (!object.contains(key)) return {};
  const Json& value = object[key];
  std::string text = value.is_string() ? value.get<std::string>() : value.dump();
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  for (std::size_t at = 0; (at = text.find('"', at)) != std::string::npos; at += 2)
    text.insert(at, 1, '"');
  return '"' + text + '"';
}

std::string first_line() {
  return fmt::format("time,{},{}", fmt::join(kHead, ","), fmt::join(kRow, ","));
}

std::string now_in_utc() {
  const std::time_t now = std::time(nullptr);
  char text[32];
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

}  // namespace

Result<Done> append_history(const std::string& path, const Json& head, const Json& rows) {
  std::string known;
  std::ifstream in(path);
  const bool is_new = !std::getline(in, known) || known.empty();
  if (!is_new && known != first_line())
    return Error{path + ":1: found other columns, expected \"" + first_line() + "\""};
  std::string text = is_new ? first_line() + '\n' : "";
  const std::string now = now_in_utc();
  for (const Json& row : rows) {
    text += now;
    for (const char* key : kHead) text += "," + cell_of(head, key);
    for (const char* key : kRow) text += "," + cell_of(row, key);
    text += '\n';
  }
  // One write at the end of the file, so that two programs do not mix their lines.
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (file < 0) return Error{path + ": " + std::strerror(errno)};
  const ssize_t written = write(file, text.data(), text.size());
  const int fault = written < 0 ? errno : ENOSPC;
  close(file);
  if (written != static_cast<ssize_t>(text.size()))
    return Error{path + ": " + std::strerror(fault)};
  return Done{};
}

}  // namespace pantin::program
