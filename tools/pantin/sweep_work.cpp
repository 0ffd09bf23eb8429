// The jobs of a sweep in processes of their own, and their results on disk.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <deque>
#include <filesystem>

#include "engine/base/hash.hpp"
#include "engine/base/utf8.hpp"
#include "engine/scene/json/text_file.hpp"
#include "tools/pantin/journal.hpp"
#include "tools/pantin/measure.hpp"
#include "tools/pantin/sweep.hpp"

namespace pantin::program {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = 1u << 30;  // of a result
constexpr useconds_t kPause = 2000;           // us between two looks at the processes

bool is_scene(const std::string& word) {
  return word.ends_with(".json") || word.ends_with(".json5") || word.ends_with(".jsonc");
}

/// A hash of a file; of a scene also of the files that it names.
std::string hash_of_file(const std::string& path) {
  const Result<std::string> text = detail::read_text(path, SceneLimits{}.bytes, "a scene file");
  if (!text) return "-";
  const Result<Scene> scene = read_scene(path, {});
  return hex(hash_of(scene ? *scene : Scene{}, *text));
}

Error error_of(const std::string& path) { return Error{path + ": " + std::strerror(errno)}; }

/// Writes a file beside its place, to the disk, then renames it.
Result<Done> write_safely(const std::string& path, std::string_view text) {
  const std::string part = fmt::format("{}.{}.part", path, getpid());
  const int file = open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) return error_of(part);
  bool is_ok = true;
  for (std::size_t done = 0; is_ok && done < text.size();) {
    const ssize_t n = write(file, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    is_ok = n > 0;
    if (is_ok) done += static_cast<std::size_t>(n);
  }
  is_ok = is_ok && fsync(file) == 0;
  const int fault = errno;
  close(file);
  errno = fault;
  if (is_ok && std::rename(part.c_str(), path.c_str()) == 0) return Done{};
  Error error = error_of(path);
  unlink(part.c_str());
  return error;
}

/// All bytes of a file in memory; closes it.
std::string contents(int file) {
  std::string text;
  char block[65536];
  lseek(file, 0, SEEK_SET);
  for (ssize_t n; (n = read(file, block, sizeof block)) > 0 && text.size() < kMostBytes;)
    text.append(block, static_cast<std::size_t>(n));
  close(file);
  return text;
}

/// A job in a process.
struct Worker {
  std::size_t job = 0;
  pid_t process = 0;
  int out = -1, err = -1;  // files in memory
  double since = 0;        // s
  bool is_late = false;
};

/// What a finished process left.
struct Ended {
  int status = 0;  // of wait4()
  rusage used = {};
};

class Gang {
 public:
  Gang(const std::vector<Job>& jobs, const Shelf& shelf, const Crew& crew)
      : jobs_(jobs), shelf_(shelf), crew_(crew), attempts_(jobs.size()), progress_("sweep") {}
  ~Gang() { stop(); }
  Gang(const Gang&) = delete;
  Gang& operator=(const Gang&) = delete;

  Result<std::map<std::string, Json>> make();

 private:
  Result<Done> start(std::size_t job);
  Result<Done> finish(const Worker& worker, const Ended& ended);
  Result<Done> look();
  void stop();

  const std::vector<Job>& jobs_;
  const Shelf& shelf_;
  const Crew& crew_;
  std::deque<std::size_t> waiting_;
  std::vector<Worker> workers_;
  std::vector<int> attempts_;
  std::map<std::string, Json> results_;
  Progress progress_;
};

/// In the new process: becomes the command, which ends with its parent.
[[noreturn]] void become(std::vector<char*>& words, const Worker& w, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kInterrupted);  // it has ended already
  const int none = open("/dev/null", O_RDONLY);
  if (none < 0 || dup2(none, 0) < 0 || dup2(w.out, 1) < 0 || dup2(w.err, 2) < 0) _exit(kUnwritable);
  std::signal(SIGPIPE, SIG_DFL);
  execv("/proc/self/exe", words.data());
  _exit(kUnwritable);
}

Result<Done> Gang::start(std::size_t job) {
  std::vector<std::string> words = jobs_[job].words;
  bool has_folder = false;
  for (std::string& word : words)
    for (std::size_t at; (at = word.find("{folder}")) != std::string::npos; has_folder = true)
      word.replace(at, 8, shelf_.folder_of(jobs_[job]));
  if (has_folder)
    if (auto made = make_folder(shelf_.folder_of(jobs_[job])); !made) return made;
  static char name[] = "pantin";
  std::vector<char*> arguments{name};
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  Worker w;
  w.job = job, w.since = wall_seconds();
  w.out = memfd_create("out", MFD_CLOEXEC), w.err = memfd_create("err", MFD_CLOEXEC);
  const pid_t parent = getpid();
  w.process = w.out < 0 || w.err < 0 ? -1 : fork();
  if (w.process == 0) become(arguments, w, parent);
  if (w.process < 0) return Error{fmt::format("no process: {}", std::strerror(errno))};
  ++attempts_[job];
  workers_.push_back(w);
  return Done{};
}

/// The word for the end of a process, as in results.
std::string word_of(const Worker& w, int status) {
  if (w.is_late) return "late";
  if (!WIFEXITED(status)) return "killed";
  switch (WEXITSTATUS(status)) {
    case kOk:
      return "ok";
    case kFailed:
      return "failed";
    case kUsage:
      return "refused";
    case kDiverged:
      return "diverged";
    case kUnwritable:
      return "unwritable";
    default:
      return "killed";
  }
}

/// The printable lines of a text, without the last line break.
std::string lines_of(std::string text) {
  while (text.ends_with('\n')) text.pop_back();
  return text;
}

Result<Done> Gang::finish(const Worker& w, const Ended& ended) {
  const Job& job = jobs_[w.job];
  const std::string status = word_of(w, ended.status), out = contents(w.out), err = contents(w.err);
  const bool is_final = status != "killed" && status != "unwritable" && status != "late";
  if (!is_final && status != "late" && attempts_[w.job] <= crew_.retries) {
    waiting_.push_back(w.job);
    return Done{};
  }
  Json result{{"id", job.id}, {"command", job.words}, {"status", status}};
  result["errors"] = lines_of(err);
  const Json told = Json::parse(out, nullptr, false);
  result["result"] = told.is_discarded() ? Json(lines_of(out)) : told;
  Json machine = take_machine(result["result"]);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  result["machine"] = {{"wall_s", wall_seconds() - w.since},
                       {"cpu_s", seconds(ended.used.ru_utime) + seconds(ended.used.ru_stime)},
                       {"memory_kb", ended.used.ru_maxrss},
                       {"attempts", attempts_[w.job]},
                       {"host", host},
                       {"result", std::move(machine)}};
  results_[job.id] = result;
  return is_final ? shelf_.keep(job, std::move(result)) : Done{};
}

/// Finishes a process that has ended, if there is one; ends one that takes too long.
Result<Done> Gang::look() {
  for (std::size_t i = 0; i < workers_.size(); ++i) {
    Ended ended;
    const pid_t done = wait4(workers_[i].process, &ended.status, WNOHANG, &ended.used);
    if (done == workers_[i].process) {
      const Worker worker = workers_[i];
      workers_.erase(workers_.begin() + static_cast<std::ptrdiff_t>(i));
      return finish(worker, ended);
    }
    if (crew_.limit > 0 && wall_seconds() - workers_[i].since > crew_.limit) {
      workers_[i].is_late = true;
      kill(workers_[i].process, SIGKILL);
    }
  }
  usleep(kPause);
  return Done{};
}

void Gang::stop() {
  for (const Worker& w : workers_) kill(w.process, SIGKILL);
  for (const Worker& w : workers_) {
    while (waitpid(w.process, nullptr, 0) < 0 && errno == EINTR) continue;
    close(w.out), close(w.err);
  }
  workers_.clear();
}

Result<std::map<std::string, Json>> Gang::make() {
  for (std::size_t i = 0; i < jobs_.size(); ++i) {
    if (std::optional<Json> known = shelf_.find(jobs_[i]))
      results_[jobs_[i].id] = std::move(*known);
    else
      waiting_.push_back(i);
  }
  while (!interrupted() && (!waiting_.empty() || !workers_.empty())) {
    progress_.show(static_cast<double>(results_.size()) / static_cast<double>(jobs_.size()));
    if (!waiting_.empty() && workers_.size() < static_cast<std::size_t>(crew_.jobs)) {
      const std::size_t next = waiting_.front();
      waiting_.pop_front();
      if (auto started = start(next); !started) return started.errors();
    } else if (auto looked = look(); !looked) {
      return looked.errors();
    }
  }
  return std::move(results_);
}

bool is_of_machine(std::string_view key) {
  constexpr std::string_view kKeys[] = {"cpu",     "cores",   "load",  "clock",
                                        "seconds", "kernels", "front", "compiler"};
  constexpr std::string_view kStarts[] = {"ns_per_", "frame_ms",  "cpu_ms",
                                          "cost_",   "stages_ns", "took_"};
  return std::ranges::find(kKeys, key) != std::end(kKeys) ||
         std::ranges::any_of(kStarts,
                             [&](std::string_view start) { return key.starts_with(start); });
}

}  // namespace

Json take_machine(Json& result) {
  Json taken;
  if (result.is_array()) {
    for (std::size_t i = 0; i < result.size(); ++i)
      if (Json part = take_machine(result[i]); !part.is_null())
        taken[std::to_string(i)] = std::move(part);
    return taken;
  }
  if (!result.is_object()) return taken;
  for (auto member = result.begin(); member != result.end();) {
    if (is_of_machine(member.key())) {
      taken[member.key()] = *member;
      member = result.erase(member);
      continue;
    }
    if (Json part = take_machine(*member); !part.is_null()) taken[member.key()] = std::move(part);
    ++member;
  }
  return taken;
}

Result<Done> Shelf::open(const std::string& folder) {
  folder_ = folder;
  return make_folder(folder + "/jobs");
}

std::string Shelf::path_of(const Job& job) const { return folder_ + "/jobs/" + job.id + ".json"; }

std::string Shelf::folder_of(const Job& job) const { return folder_ + "/jobs/" + job.id; }

std::string Shelf::inputs_of(const Job& job) const {
  Hash hash;
  for (std::size_t i = 0; i < job.words.size(); ++i) {
    const std::string& word = job.words[i];
    if (!is_scene(word) || (i > 0 && job.words[i - 1] == "--out")) continue;
    auto [known, is_new] = known_.try_emplace(word);
    if (is_new) known->second = hash_of_file(word);
    hash.add(std::string_view(known->second));
  }
  hash.add(hash_of(Scene{}, ""));  // of the program
  return hex(hash.value());
}

std::optional<Json> Shelf::find(const Job& job) const {
  if (!fs::exists(path_of(job))) return std::nullopt;
  const Result<std::string> text = detail::read_text(path_of(job), kMostBytes, "a result");
  if (!text) return std::nullopt;
  Json entry = Json::parse(*text, nullptr, false);
  if (!entry.is_object() || entry.value("inputs", "") != inputs_of(job)) return std::nullopt;
  return entry;
}

Result<Done> Shelf::keep(const Job& job, Json result) const {
  result["inputs"] = inputs_of(job);
  return write_safely(path_of(job),
                      result.dump(-1, ' ', true, Json::error_handler_t::replace) + '\n');
}

Result<std::map<std::string, Json>> work(const std::vector<Job>& jobs, const Shelf& shelf,
                                         const Crew& crew) {
  return Gang(jobs, shelf, crew).make();
}

}  // namespace pantin::program
