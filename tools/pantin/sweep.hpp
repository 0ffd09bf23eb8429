#pragma once
// Independent commands of this program, run in processes of their own: what `pantin sweep` does.
#include <map>
#include <nlohmann/json.hpp>

#include "tools/pantin/program.hpp"

namespace pantin::program {

struct SweepChoices {
  std::vector<std::string> scenes, over;
  std::vector<std::string> words;  // after "--": the command
  std::string list, out = "out/sweep", emit;
  int jobs = 0;  // at the same time; 0: one for each core
  int retries = 2;
  std::optional<double> limit;  // s of a job
  bool one = false, json = false;
};

/// A command of this program. Its id is a hash of its words alone, so that it is the same on every
/// machine and in any order.
struct Job {
  std::string id;
  std::vector<std::string> words;  // after the program's name; "{folder}" is a folder of the job
  Json set = Json::object();       // what an axis of the sweep set, by its name
};

/// The jobs of a command line, without repetitions, in the order in which they were asked for.
Result<std::vector<Job>> jobs_of(const SweepChoices& choices);
/// The words of a line for a shell, and of such a line.
std::string line_of(const std::vector<std::string>& words);
Result<std::vector<std::string>> words_of_line(std::string_view line);

/// The results of jobs as files of a folder, one for each job. A file is complete or absent,
/// whatever is killed; several processes may write the same one.
class Shelf {
 public:
  /// Creates the folder.
  Result<Done> open(const std::string& folder);
  /// The result of a job that was run by this program on the same files, or nothing.
  std::optional<Json> find(const Job& job) const;
  Result<Done> keep(const Job& job, Json result) const;
  /// A folder of its own for files that a job writes.
  std::string folder_of(const Job& job) const;

 private:
  std::string path_of(const Job& job) const;
  /// A hash of this program and of the scenes that a job names.
  std::string inputs_of(const Job& job) const;

  std::string folder_;
  mutable std::map<std::string, std::string> known_;  // hashes of files, by name
};

/// How jobs are run.
struct Crew {
  int jobs = 1, retries = 2;
  double limit = 0;  // s; 0: none
};
/// Runs the jobs that have no result yet, and returns the results of all by id; fewer if it was
/// interrupted. What was killed, ran out of time or could not write is tried again, and not kept.
Result<std::map<std::string, Json>> work(const std::vector<Job>& jobs, const Shelf& shelf,
                                         const Crew& crew);

/// Moves the members that depend on the machine out of a result, at any depth, and returns them.
Json take_machine(Json& result);

/// Adds the command. `words` are those after "--" on the command line.
void add_sweep(CommandLine& program, std::vector<std::string> words);

}  // namespace pantin::program
