#include "tools/peers/rounds.hpp"

#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <random>

namespace pantin::peers {

namespace {

/// Starts this program anew, with `input` to read from; returns what it prints, or null.
std::FILE* start_again(char** argv, std::FILE* input, pid_t& child) {
  int ends[2];
  if (pipe(ends) != 0) return nullptr;
  child = fork();
  if (child == 0) {
    dup2(fileno(input), STDIN_FILENO), dup2(ends[1], STDOUT_FILENO);
    close(ends[0]), close(ends[1]);
    std::vector<char*> words;
    for (; *argv; ++argv) words.push_back(*argv);
    words.push_back(const_cast<char*>(kServe)), words.push_back(nullptr);
    execv("/proc/self/exe", words.data());
    _exit(127);
  }
  close(ends[1]);
  if (child > 0) return fdopen(ends[0], "r");
  close(ends[0]);
  return nullptr;
}

/// One pass through the tasks that `order` lists.
struct Round {
  std::vector<Task>& tasks;
  const Report& report;
  std::vector<std::size_t> order;

  bool time(char** argv, const std::string& title) const;
};

bool Round::time(char** argv, const std::string& title) const {
  std::FILE* const list = std::tmpfile();
  if (!list) return false;
  for (const std::size_t i : order) {
    const Point& p = tasks[i].point;
    std::fprintf(list, "%zu %td %d %.17g %d\n", p.peer,
                 p.method - report.peers[p.peer].engine->methods, p.links, p.setting,
                 tasks[i].repeats);
  }
  std::rewind(list);
  pid_t child = -1;
  std::FILE* const answers = start_again(argv, list, child);
  std::fclose(list);
  if (!answers) return false;
  std::size_t done = 0;
  for (double ms = 0; done < order.size() && std::fscanf(answers, "%lf", &ms) == 1; ++done) {
    tasks[order[done]].point.ms.push_back(ms);
    tell(title + std::to_string(done + 1) + " of " + std::to_string(order.size()));
  }
  std::fclose(answers);
  int status = 0;
  return waitpid(child, &status, 0) == child && status == 0 && done == order.size();
}

}  // namespace

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double time_once(Run& run) {
  run.reset();
  const double from = cpu_seconds();
  run.advance(kFrames);
  return 1e3 * (cpu_seconds() - from);
}

bool time_rounds(int rounds, char** argv, std::vector<Task>& tasks, const Report& report) {
  std::mt19937 dice(1);
  Round pass{tasks, report, std::vector<std::size_t>(tasks.size())};
  std::vector<std::size_t>& order = pass.order;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::erase_if(order, [&](std::size_t i) { return tasks[i].point.failed(); });
  bool good = true;
  for (int round = 1; round <= rounds && good; ++round) {
    std::shuffle(order.begin(), order.end(), dice);
    good =
        pass.time(argv, "round " + std::to_string(round) + " of " + std::to_string(rounds) + ": ");
  }
  tell("");
  return good;
}

void serve_round(const std::vector<Peer>& peers) {
  std::size_t peer = 0, method = 0;
  Chain chain;
  double setting = 0;
  int repeats = 1;
  while (std::scanf("%zu %zu %d %lf %d", &peer, &method, &chain.links, &setting, &repeats) == 5) {
    const Method& m = peers.at(peer).engine->methods[method];
    const std::unique_ptr<Run> run = m.start(chain, setting);
    run->advance(m.stride);  // fetches code and data
    double sum = 0;
    for (int n = 0; n < repeats; ++n) sum += time_once(*run);
    std::printf("%.9g\n", sum / repeats);
    std::fflush(stdout);
  }
}

}  // namespace pantin::peers
