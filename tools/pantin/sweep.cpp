#include "tools/pantin/sweep.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "engine/base/atomic_file.hpp"
#include "tools/pantin/command_line.hpp"

namespace pantin::program {
namespace {

std::string dumped(const Json& json) {
  return json.dump(-1, ' ', true, Json::error_handler_t::replace);
}

/// The members of an object that are single values, for the columns of a table.
void add_columns(const Json& object, const std::string& before, std::vector<std::string>& columns) {
  if (!object.is_object()) return;
  for (const auto& [key, value] : object.items())
    if (const std::string name = before + key;
        !value.is_structured() && std::ranges::find(columns, name) == columns.end())
      columns.push_back(name);
}

std::string cell_of(const Json& object, const std::string& key) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  if (found == object.end() || found->is_structured() || found->is_null()) return {};
  if (!found->is_string()) return found->dump();
  std::string text = found->get<std::string>();
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  for (std::size_t at = 0; (at = text.find('"', at)) != std::string::npos; at += 2)
    text.insert(at, 1, '"');
  return '"' + text + '"';
}

/// A row for each job: what was set, and the values of its result.
std::string table_of(const std::vector<Json>& lines) {
  std::vector<std::string> set, result;
  for (const Json& line : lines)
    add_columns(line["set"], "", set), add_columns(line["result"], "", result);
  std::string text = "id,status";
  for (const std::string& name : set) text += ",set:" + name;
  for (const std::string& name : result) text += "," + name;
  text += '\n';
  for (const Json& line : lines) {
    text += line["id"].get<std::string>() + "," + line["status"].get<std::string>();
    for (const std::string& name : set) text += "," + cell_of(line["set"], name);
    for (const std::string& name : result) text += "," + cell_of(line["result"], name);
    text += '\n';
  }
  return text;
}

/// Writes results.jsonl and results.csv, the same on every machine, and times.jsonl.
int gather(const SweepChoices& c, const std::vector<Job>& jobs,
           std::map<std::string, Json>& results) {
  std::map<std::string, const Job*> by_id;
  for (const Job& job : jobs) by_id[job.id] = &job;
  std::string text, times;
  std::vector<Json> lines;
  for (auto& [id, entry] : results) {
    times += dumped({{"id", id}, {"machine", entry["machine"]}}) + '\n';
    Json line{{"id", id},
              {"command", entry["command"]},
              {"set", by_id[id]->set},
              {"status", entry["status"]},
              {"errors", entry["errors"]},
              {"result", std::move(entry["result"])}};
    text += dumped(line) + '\n';
    lines.push_back(std::move(line));
  }
  if (const int code = write_or_complain(c.out + "/results.jsonl", text); code != kOk) return code;
  if (const int code = write_or_complain(c.out + "/results.csv", table_of(lines)); code != kOk)
    return code;
  return write_or_complain(c.out + "/times.jsonl", times);
}

/// The counts of results by status, the most frequent first.
Json counts_of(const std::map<std::string, Json>& results) {
  std::map<std::string, int> counts;
  for (const auto& [id, entry] : results) ++counts[entry["status"].get<std::string>()];
  Json j = Json::object();
  for (const char* word : {"ok", "diverged", "failed", "refused", "late", "killed", "unwritable"})
    if (counts.contains(word)) j[word] = counts[word];
  return j;
}

/// Writes a command for each job, which any shell, anywhere, may run any number of times.
int emit(const SweepChoices& c, const std::vector<Job>& jobs) {
  std::error_code none;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe", none).string();
  std::string text;
  for (const Job& job : jobs) {
    std::vector<std::string> words{program, "sweep", "--one", "--out", c.out};
    if (c.limit) words.insert(words.end(), {"--limit", fmt::format("{}", *c.limit)});
    words.push_back("--");
    words.insert(words.end(), job.words.begin(), job.words.end());
    text += line_of(words) + '\n';
  }
  if (c.emit != "-") return write_or_complain(c.emit, text);
  fmt::print("{}", text);
  return kOk;
}

/// What is wrong with a combination of options, or an empty string.
std::string fault_of(const SweepChoices& c) {
  if (c.one && c.words.empty()) return "--one: found no command after --, expected one";
  if (c.one && !(c.scenes.empty() && c.over.empty() && c.list.empty() && c.emit.empty()))
    return "--one: found scenes, --over, --list or --emit with it, expected a command after --";
  if (!c.list.empty() && !(c.scenes.empty() && c.over.empty() && c.words.empty()))
    return "--list: found scenes, --over or a command with it, expected the list alone";
  if (c.list.empty() && c.scenes.empty() && c.words.empty())
    return "found no scene, expected scenes, --list FILE or a command after --";
  if (!c.words.empty() && c.words.front() == "sweep")
    return "found the command \"sweep\", expected another one";
  return {};
}

int sweep(const SweepChoices& c) {
  if (const std::string fault = fault_of(c); !fault.empty()) {
    complain(fault);
    return kUsage;
  }
  const auto complain_of = [](const std::vector<Error>& errors, int code) {
    for (const Error& e : errors) complain(e.message);
    return code;
  };
  const Result<std::vector<Job>> jobs = jobs_of(c);
  if (!jobs) return complain_of(jobs.errors(), kUsage);
  if (!c.emit.empty()) return emit(c, *jobs);
  Shelf shelf;
  if (const auto opened = shelf.open(c.out); !opened)
    return complain_of(opened.errors(), kUnwritable);
  const int cores = static_cast<int>(std::max(1L, sysconf(_SC_NPROCESSORS_ONLN)));
  auto results = work(*jobs, shelf, {c.jobs > 0 ? c.jobs : cores, c.retries, c.limit.value_or(0)});
  if (!results) return complain_of(results.errors(), kUnwritable);
  if (interrupted()) {
    complain("interrupted; the same command goes on from here");
    return kInterrupted;
  }
  const Json counts = counts_of(*results);
  std::string words;
  for (const auto& [word, count] : counts.items())
    words += fmt::format("{}{} {}", words.empty() ? "" : ", ", count.get<int>(), word);
  for (const auto& [id, entry] : *results)
    if (entry["status"] != "ok" && entry["status"] != "diverged") {
      complain(fmt::format("job {} {}: {}", id, entry["status"].get<std::string>(),
                           entry["errors"].get<std::string>()));
      break;
    }
  if (!c.one)
    if (const int code = gather(c, *jobs, *results); code != kOk) return code;
  if (c.json)
    print_json({{"jobs", jobs->size()}, {"counts", counts}, {"results", c.out + "/results.jsonl"}});
  else if (!c.one)
    fmt::print("{} jobs: {}; {}/results.jsonl, results.csv, times.jsonl\n", jobs->size(), words,
               c.out);
  const bool is_whole =
      !counts.contains("late") && !counts.contains("killed") && !counts.contains("unwritable");
  if (counts.size() == 1 && counts.contains("refused")) return kUsage;
  const bool all_failed = counts.size() == 1 && counts.contains("failed");
  return is_whole && !all_failed ? kOk : kFailed;
}

constexpr const char* kExamples =
    R"(Runs a command of this program for every combination of scenes and values, as independent jobs in
processes of their own. Results do not depend on the number of jobs at the same time, on their order
or on what was killed and repeated: they are written to a file for each job, complete or not at all,
and the same command goes on where it was. Nothing is run twice unless the program or its scenes
changed; change --out, or remove the folder, to run all anew.

Examples:
  pantin sweep assets/scenes/pendulum.json --over /bodies/0/mass=1..10:3 -- run --json --duration 0.5
  pantin sweep assets/scenes/chain10.json --over step=0.002,0.004 --over solver=auto,lagrangian
  pantin sweep assets/scenes/chain10.json --over seed=1..3 -- assemble --json
  pantin sweep assets/scenes/*.json --out out/charts -- chart --json --out {folder} --time 5 --rungs 2
  pantin sweep assets/scenes/pendulum.json --over step=1e-3..1e-2:4 --emit -

After -- stands the command; by default: run --json. It gets the scene, and for each axis a value.
--over NAME=VALUES: a NAME with a slash is a place in the scene, as of --set (/gravity); any other
is an option of the command. Names with commas between have the same value. VALUES: words or JSON
with commas between; A..B, whole numbers; A..B:COUNT, equidistant, or of equal ratio where B is at
least ten times A. {folder} is a folder for files of the job. --list has a command a line instead.

--emit writes a line for each job, for GNU parallel (parallel < jobs.txt), for a Slurm array
(sed -n "${SLURM_ARRAY_TASK_ID}p" jobs.txt | sh) or for tools/farm, which hands them to Dask or Ray.
The lines may be run anywhere in the same folder, in any order and more than once; then the sweep
without --emit finds all results. A job that is killed or cannot write is tried again (--retries);
one that takes longer than --limit is not. Jobs end with the sweep, however it ends.

In the folder of --out: results.jsonl, a line for each job, ordered by id: id (a hash of the
command), command, set (what --over set), status (ok, failed, refused, diverged; not kept: late,
killed, unwritable), errors, result (what the command printed); results.csv, the single values of
these; times.jsonl, what depends on the machine: wall_s, cpu_s, memory_kb, attempts, host and times in
the result (keys such as frame_ms_median, ns_per_link_step_median, cost_ns); jobs, a file each.

--json prints jobs, counts (by status) and results (the file).

Exit codes: 0 every job was run (also where it diverged, or some failed), 1 jobs were late or killed,
or every job failed, 2 usage or bad input, or every job was refused, 4 could not write, 130 interrupted.)";

}  // namespace

void add_sweep(CommandLine& program, std::vector<std::string> words) {
  auto c = std::make_shared<SweepChoices>();
  c->words = std::move(words);
  const Subcommand command =
      program.add("sweep", "Runs a command for many values, in parallel; goes on if it was killed");
  command.option("scene", c->scenes, "scene files").type(kSceneType);
  command.option("--over", c->over, "an axis: NAME=A..B:COUNT, NAME=A..B or NAME=VALUE,VALUE")
      .type("NAME=VALUES")
      .one_at_a_time();
  command.option("--list", c->list, "file with a command a line, - for standard input")
      .type(kFileType);
  command.option("--jobs", c->jobs, "at the same time; default: one for each core")
      .within(1, 10000);
  command.option("--out", c->out, "folder of all results; default out/sweep").type(kFolderType);
  command.option("--retries", c->retries, "of a job that was killed; default 2").within(0, 1000);
  command.option("--limit", c->limit, "seconds of a job").between(1e-3, 1e9);
  command.option("--emit", c->emit, "write a command line for each job instead; - prints them")
      .type(kFileType);
  command.flag("--one", c->one, "one job: the whole command after --");
  command.flag("--json", c->json, "print one JSON object instead of text");
  command.footer(kExamples);
  command.runs([c] { return sweep(*c); });
}

}  // namespace pantin::program
