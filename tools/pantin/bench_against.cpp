// Two builds of the program timed in turns, and a verdict that knows the noise.
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "engine/base/utf8.hpp"
#include "tools/pantin/bench.hpp"

extern char** environ;

namespace pantin::program {
namespace {

constexpr int kPairs = 12;
constexpr double kTail = 0.005;  // of the distribution beyond each end of the interval

/// What a program prints; its messages go to stderr. An error: it ended with another code than 0.
Result<std::string> output_of(const std::string& program, std::vector<std::string> words) {
  const int out = memfd_create("out", MFD_CLOEXEC);
  if (out < 0) return Error{fmt::format("no memory file: {}", std::strerror(errno))};
  words.insert(words.begin(), program);
  std::vector<char*> arguments;
  for (std::string& w : words) arguments.push_back(w.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out, 1);
  pid_t child = 0;
  const int fault =
      posix_spawnp(&child, program.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  int status = fault;
  while (fault == 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  std::string text;
  char block[65536];
  lseek(out, 0, SEEK_SET);
  for (ssize_t n; (n = read(out, block, sizeof block)) > 0;)
    text.append(block, static_cast<std::size_t>(n));
  close(out);
  if (fault != 0) return Error{fmt::format("{}: {}", program, std::strerror(fault))};
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return Error{fmt::format("{}: bench ended with {}", program,
                             WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status))};
  return text;
}

/// A run of a program on a scene: the mean time of a step, and the hash of its end.
struct Timing {
  double mean = 0;  // ms
  std::string hash;
};

Result<Timing> timing_of(const std::string& program, const std::vector<std::string>& words) {
  const Result<std::string> text = output_of(program, words);
  if (!text) return text.errors();
  const Json told = Json::parse(*text, nullptr, false);
  const Error fault{program +
                    ": found no row with frame_ms_mean and hash, expected the output of "
                    "bench --json"};
  if (!told.is_object() || !told.contains("rows") || !told["rows"].is_array() ||
      told["rows"].size() != 1)
    return fault;
  const Json& row = told["rows"][0];
  if (!row.is_object() || !row.contains("frame_ms_mean") || !row["frame_ms_mean"].is_number() ||
      !row.contains("hash") || !row["hash"].is_string())
    return fault;
  const Timing timing{row["frame_ms_mean"].get<double>(), row["hash"].get<std::string>()};
  if (!(timing.mean > 0)) return fault;
  return timing;
}

/// The command line of a run, for both programs.
std::vector<std::string> words_of(const std::string& scene, const BenchChoices& c) {
  std::vector<std::string> words{
      "bench", scene, "--repeat", "1", "--json", "--threads", std::to_string(c.threads)};
  const auto add = [&](const char* option, const auto& value) {
    if (value) words.insert(words.end(), {option, fmt::format("{}", *value)});
  };
  add("--solver", c.how.solver), add("--integrator", c.how.integrator);
  add("--stabilisation", c.how.stabilisation), add("--jacobians", c.how.jacobians);
  add("--step", c.how.step), add("--duration", c.how.duration);
  add("--tolerance", c.how.tolerance), add("--substeps", c.how.substeps);
  add("--budget", c.how.budget_ms);
  for (const std::string& setting : c.how.set) words.insert(words.end(), {"--set", setting});
  return words;
}

/// The largest k such that P(W < k) <= kTail, where W is the sum of the ranks of n pairs whose
/// signs are equally probable.
std::size_t critical_sum(std::size_t n) {
  std::vector<double> ways{1};  // in which the ranks up to i have a sum
  for (std::size_t i = 1; i <= n; ++i) {
    std::vector<double> more(ways.size() + i);
    for (std::size_t s = 0; s < ways.size(); ++s)
      more[s] += 0.5 * ways[s], more[s + i] += 0.5 * ways[s];
    ways = std::move(more);
  }
  double below = 0;
  std::size_t k = 0;
  while (k < ways.size() && below + ways[k] <= kTail) below += ways[k++];
  return k;
}

std::string percent_of(double log_ratio) {
  return fmt::format("{:+.1f} %", 100 * std::expm1(log_ratio));
}

/// The verdict on a scene. The shift is of log(ours / theirs).
Json judged(const Shift& shift) {
  const bool is_faster = shift.most<0, is_slower = shift.least> 0;
  Json j;
  j["verdict"] = is_faster ? "faster" : is_slower ? "slower" : "no difference seen";
  j["change"] = std::expm1(shift.middle);
  j["change_interval"] = {std::expm1(shift.least), std::expm1(shift.most)};
  j["words"] =
      fmt::format("{}, {} ({} to {})", j["verdict"].get<std::string>(), percent_of(shift.middle),
                  percent_of(shift.least), percent_of(shift.most));
  return j;
}

Result<Json> compared(const std::string& scene, const BenchChoices& c, Progress& progress) {
  const std::vector<std::string> words = words_of(scene, c);
  const int pairs = c.repeat.value_or(kPairs);
  Json ratios = Json::array();
  std::vector<double> differences;
  bool are_equal = true;
  for (int i = 0; i < pairs && !interrupted(); ++i) {
    Result<Timing> ours = Timing{}, theirs = Timing{};
    // Which one is first alternates: what a first run does to a second falls on both.
    for (const bool is_ours : {i % 2 == 0, i % 2 != 0}) {
      Result<Timing>& timing = is_ours ? ours : theirs;
      timing = timing_of(is_ours ? "/proc/self/exe" : c.against, words);
      if (!timing) return timing.errors();
    }
    are_equal = are_equal && ours->hash == theirs->hash;
    differences.push_back(std::log(ours->mean / theirs->mean));
    ratios.push_back(ours->mean / theirs->mean);
    progress.show((i + 1.0) / pairs);
  }
  if (interrupted()) return Json{};
  Json j = judged(shift_of(differences));
  j["results"] = are_equal ? "same" : "differ";
  if (!are_equal) j["words"] = "results differ; " + j["words"].get<std::string>();
  j["scene"] = scene;
  j["ratios"] = std::move(ratios);
  return j;
}

}  // namespace

Shift shift_of(const std::vector<double>& differences) {
  const std::size_t n = differences.size();
  std::vector<double> means;  // of all pairs of differences, each with itself, too
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) means.push_back(0.5 * (differences[i] + differences[j]));
  std::ranges::sort(means);
  const std::size_t m = means.size(), k = critical_sum(n);
  if (k == 0 || m == 0) return {-INFINITY, m == 0 ? 0 : means[m / 2], INFINITY};
  return {means[k - 1], 0.5 * (means[(m - 1) / 2] + means[m / 2]), means[m - k]};
}

int bench_against(const BenchChoices& c) {
  const auto fault = [](const std::string& text) {
    complain(text);
    return kUsage;
  };
  if (c.repeat && *c.repeat < kFewestPairs)
    return fault(fmt::format("--repeat: found {}, expected {} or more with --against", *c.repeat,
                             kFewestPairs));
  if (!c.csv.empty() || !c.history.empty())
    return fault("found --csv or --history with --against, expected it without them");
  Json all = build_and_machine();
  all["against"] = c.against;
  all["rows"] = Json::array();
  for (const std::string& scene : c.scenes) {
    if (!open_scene(scene, c.how)) return kUsage;
    Result<Json> row = Json{};
    {
      Progress progress(scene);
      row = compared(scene, c, progress);
    }
    if (interrupted()) return kInterrupted;
    if (!row) {
      complain(row.errors().front().message);
      return kFailed;
    }
    if (!c.json) fmt::print("{:<32} {}\n", printable(scene), (*row)["words"].get<std::string>());
    all["rows"].push_back(std::move(*row));
  }
  if (c.json) print_json(all);
  return kOk;
}

}  // namespace pantin::program
