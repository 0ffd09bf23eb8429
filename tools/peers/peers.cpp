// Measures the exact solver beside other engines, in one run.
#include <dlfcn.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <random>

#include "tools/peers/measure.hpp"

using namespace pantin::peers;

namespace {

constexpr const char* kUsage = R"(usage: peers [OPTION...]

Lets a chain of ball joints fall from level for a second, by the exact solver of pantin and by the
engines that were found, and prints for each method and step: error, CPU time, energy, open joints;
then what each method costs at equal error. Errors are distances of link centres from a reference,
about which all engines are asked. Pinocchio has no integrators of its own: it is stepped by
semi-implicit Euler, by Runge-Kutta of order 4, and by the 5(4) pair that pantin has too.

  --links LIST        chains to measure, by their links (default 10,50; at most 100)
  --cost LIST         chains of which the cost of a step alone is measured (default 100)
  --rounds N          rounds through all methods, at least 1 (default 5)
  --finest N          steps in a second, at most (default 15360)
  --longest S         runs that would take more CPU seconds are left out (default 3)
  --only WORDS        only methods whose name has one of these in it, as "ours rk4"; commas between
  --engine NAME=FILE  one more module; a name that begins with "ours" counts as ours
  --csv FILE          write all points to FILE too
  --json              print JSON, not tables
  --small             ten links, few steps, two rounds: to try it out in seconds
  --help              this text

Examples:
  peers --small
  peers --links 10 --only rk4,rk54 --rounds 9
  peers --engine ours_before=/tmp/before/bin/peers_ours.so --only "ours" --cost ""

Every round goes through all methods in another order; figures are medians of the rounds.
Exit code: 0, or 2 for a wrong call, 4 where a file could not be written.
)";

struct Choices {
  std::vector<int> links{10, 50}, cost{100};
  int rounds = 5, finest = 15360;
  double longest = 3;
  std::vector<std::string> only;
  std::vector<std::pair<std::string, std::string>> modules;
  std::string csv;
  bool json = false, small = false;
};

[[noreturn]] void refuse(const std::string& why) {
  std::fprintf(stderr, "peers: %s; see peers --help\n", why.c_str());
  std::exit(2);
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t to = std::min(text.find(',', from), text.size());
    if (to > from) parts.push_back(text.substr(from, to - from));
    from = to + 1;
  }
  return parts;
}

/// The number that `text` is, as a whole, between `low` and `high`.
double number_of(const std::string& option, const std::string& text, double low, double high,
                 bool whole) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !(value >= low && value <= high) ||
      (whole && value != std::floor(value))) {
    char expected[80];
    std::snprintf(expected, sizeof expected, "%s from %g to %g",
                  whole ? "a whole number" : "a number", low, high);
    refuse(option + ": found \"" + text + "\", expected " + expected);
  }
  return value;
}

std::vector<int> sizes(const std::string& option, const std::string& text) {
  std::vector<int> numbers;
  // Pinocchio's data grow with the cube of the links.
  for (const std::string& part : split(text))
    numbers.push_back(static_cast<int>(number_of(option, part, 1, 100, true)));
  return numbers;
}

Choices read_choices(int argc, char** argv) {
  Choices c;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--help" || word == "-h") std::fputs(kUsage, stdout), std::exit(0);
    if (word == "--json") {
      c.json = true;
    } else if (word == "--small") {
      c.small = true;
    } else {
      static constexpr const char* kKnown[] = {"--links",   "--cost", "--rounds", "--finest",
                                               "--longest", "--only", "--engine", "--csv"};
      if (std::find(std::begin(kKnown), std::end(kKnown), word) == std::end(kKnown))
        refuse("found \"" + word + "\", expected an option");
      if (i + 1 >= argc) refuse(word + ": expected a value behind it");
      const std::string value = argv[++i];
      if (word == "--links") c.links = sizes(word, value);
      if (word == "--cost") c.cost = sizes(word, value);
      if (word == "--rounds") c.rounds = static_cast<int>(number_of(word, value, 1, 1000, true));
      if (word == "--finest")
        c.finest = static_cast<int>(number_of(word, value, kFrames, 1e6, true));
      if (word == "--longest") c.longest = number_of(word, value, 0.01, 1e4, false);
      if (word == "--only") c.only = split(value);
      if (word == "--csv") c.csv = value;
      if (word == "--engine") {
        const std::size_t equals = value.find('=');
        if (equals == 0 || equals == std::string::npos)
          refuse("--engine: found \"" + value + "\", expected NAME=FILE");
        c.modules.emplace_back(value.substr(0, equals), value.substr(equals + 1));
      }
    }
  }
  if (c.small) c.links = {10}, c.cost = {}, c.rounds = 2, c.finest = 960;
  std::erase_if(
      c.cost, [&](int n) { return std::find(c.links.begin(), c.links.end(), n) != c.links.end(); });
  return c;
}

void tell(const std::string& what) {
  if (isatty(STDERR_FILENO)) std::fprintf(stderr, "\r\033[K%s", what.c_str());
}

double seconds_of(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}
double cpu_seconds() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }

double load() {
  double average = NAN;
  return getloadavg(&average, 1) == 1 ? average : NAN;
}

/// The engine of a module, or null and a line that says so.
const Engine* open(const std::string& name, const std::string& file) {
  void* const module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  using Ask = const Engine*();
  Ask* const ask = module ? reinterpret_cast<Ask*>(dlsym(module, "pantin_peer")) : nullptr;
  if (ask) return ask();
  std::fprintf(stderr, "peers: without %s: %s\n", name.c_str(), dlerror());
  return nullptr;
}

std::vector<Peer> find_peers(const Choices& choices) {
  const auto folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  std::vector<Peer> peers;
  const auto add = [&](const std::string& name, const std::string& file) {
    const Engine* const engine = open(name, file);
    if (engine) peers.push_back({name, engine});
    return engine != nullptr;
  };
  for (const char* name : {"ours", "ours_native", "pinocchio", "simbody"}) {
    const auto file = folder / (std::string("peers_") + name + ".so");
    if (std::filesystem::exists(file))
      add(name, file);
    else
      std::fprintf(stderr, "peers: without %s: it was not built\n", name);
  }
  for (const auto& [name, file] : choices.modules)
    if (!add(name, std::filesystem::absolute(file))) std::exit(2);
  return peers;
}

double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

struct State {
  double energy = 0, gap = 0;
  bool finite = true;
};

State look(const Chain& chain, const std::vector<LinkState>& links) {
  State s;
  double end[3] = {0, 0, 0};
  const double along = chain.inertia_along(), across = chain.inertia_across();
  for (const LinkState& l : links) {
    const double turning = dot(l.spin, l.axis);
    s.energy += chain.mass() * (dot(l.velocity, l.velocity) / 2 + chain.gravity * l.centre[1]) +
                (across * dot(l.spin, l.spin) + (along - across) * turning * turning) / 2;
    double gap2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double half = chain.length / 2 * l.axis[k], off = l.centre[k] - half - end[k];
      gap2 += off * off;
      end[k] = l.centre[k] + half;
    }
    s.gap = std::max(s.gap, std::sqrt(gap2));
    s.finite = s.finite && std::isfinite(gap2);
  }
  s.finite = s.finite && std::isfinite(s.energy);
  return s;
}

double distance(const std::vector<LinkState>& links, const Reference& reference) {
  double worst = 0;
  for (std::size_t i = 0; i < links.size(); ++i) {
    double d2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double off = links[i].centre[k] - reference.centres[i][static_cast<std::size_t>(k)];
      d2 += off * off;
    }
    if (!(d2 <= worst)) worst = d2;
  }
  return std::sqrt(worst);
}

Chain chain_of(int links) {
  Chain chain;
  chain.links = links;
  return chain;
}

/// A second in the finest way that an engine has: Runge-Kutta of order 4, or the least tolerance.
std::vector<LinkState> finest_run(const Engine& engine, int links, std::string& how) {
  const Method* method = nullptr;
  for (const Method& m : methods_of(engine)) {
    if (std::strcmp(m.name, "rk4") == 0) method = &m;
    if (!method && m.adaptive) method = &m;
  }
  std::vector<LinkState> end;
  if (!method) return end;
  constexpr int kStepsInFrame = 512;
  const double setting = method->adaptive ? method->tightest : kStepsInFrame;
  how = std::string(" ") + method->name +
        (method->adaptive ? "" : " of 1/" + std::to_string(kFrames * kStepsInFrame) + " s");
  const std::unique_ptr<Run> run = method->start(chain_of(links), setting);
  if (!run->advance(kFrames)) return end;
  end.resize(static_cast<std::size_t>(links));
  run->read(end.data());
  return end;
}

/// From a peer if there is one; the others are asked too. Two builds of ours are no two witnesses.
Reference find_reference(const std::vector<Peer>& peers, int links) {
  struct Witness {
    std::string name;
    bool ours;
    std::vector<LinkState> end;
  };
  std::vector<Witness> witnesses;
  bool have_ours = false;
  for (const Peer& peer : peers) {
    if (peer.ours() && have_ours) continue;
    have_ours = have_ours || peer.ours();
    tell("reference of " + std::to_string(links) + " links: " + peer.name);
    std::string how;
    std::vector<LinkState> end = finest_run(*peer.engine, links, how);
    if (!end.empty()) witnesses.push_back({peer.name + how, peer.ours(), std::move(end)});
  }
  Reference reference;
  reference.links = links;
  if (witnesses.empty()) refuse("no engine is left to measure");
  std::stable_partition(witnesses.begin(), witnesses.end(),
                        [](const Witness& w) { return !w.ours; });
  reference.from = witnesses.front().name;
  for (const LinkState& l : witnesses.front().end)
    reference.centres.push_back({l.centre[0], l.centre[1], l.centre[2]});
  for (std::size_t i = 1; i < witnesses.size(); ++i)
    reference.apart.emplace_back(witnesses[i].name, distance(witnesses[i].end, reference));
  tell("");
  return reference;
}

/// A point and the run that measures it.
struct Task {
  Point point;
  std::unique_ptr<Run> run;
  int repeats = 1;
};

/// CPU ms of one second of motion, the reset not counted.
double time_once(Run& run) {
  run.reset();
  const double from = cpu_seconds();
  run.advance(kFrames);
  return 1e3 * (cpu_seconds() - from);
}

/// Goes frame by frame, and once in one go for the error. Returns the CPU ms of the latter.
double judge(Task& task, const Reference* reference) {
  Point& p = task.point;
  const Chain chain = chain_of(p.links);
  std::vector<LinkState> links(static_cast<std::size_t>(p.links));
  task.run->reset();
  for (int frame = 0; frame < kFrames && !p.failed(); frame += p.method->stride) {
    const bool going = task.run->advance(p.method->stride);
    task.run->read(links.data());
    const State s = look(chain, links);
    const double gain = s.energy / chain.energy();
    if (!going || !s.finite || s.gap >= chain.length * p.links || gain > 10)
      p.failed_at = double(frame + p.method->stride) / kFrames;
    p.gap = std::max(p.gap, s.gap);
    if (std::abs(gain) > std::abs(p.energy)) p.energy = gain;
  }
  if (p.failed()) return 0;
  const double ms = time_once(*task.run);
  p.counts = task.run->counts();
  task.run->read(links.data());
  p.error = reference ? distance(links, *reference) : NAN;
  return ms;
}

bool is_wanted(const Choices& choices, const Peer& peer, const Method& method) {
  const std::string name = peer.name + " " + method.name;
  return choices.only.empty() ||
         std::any_of(choices.only.begin(), choices.only.end(),
                     [&](const std::string& word) { return name.find(word) != std::string::npos; });
}

std::vector<double> settings_of(const Choices& choices, const Method& method, bool cost_only) {
  std::vector<double> settings;
  if (cost_only) return method.adaptive ? settings : std::vector<double>{16, 64};
  if (method.adaptive)
    for (double t = method.loosest; t > 0.5 * method.tightest; t /= choices.small ? 1000 : 10)
      settings.push_back(t);
  else
    for (int n = 1; n * kFrames <= choices.finest; n *= 2) settings.push_back(n);
  return settings;
}

/// Everything that is to be timed at one size, judged; what is too slow is left out.
void plan(const Choices& choices, const Report& report, int links, const Reference* reference,
          std::vector<Task>& tasks) {
  constexpr double kEnoughMs = 10, kRounding = 1e-11;
  for (std::size_t i = 0; i < report.peers.size(); ++i)
    for (const Method& method : methods_of(*report.peers[i].engine)) {
      if (!is_wanted(choices, report.peers[i], method)) continue;
      tell(std::to_string(links) + " links: " + report.peers[i].name + " " + method.name);
      double before = 0;
      for (const double setting : settings_of(choices, method, !reference)) {
        if (2 * before > 1e3 * choices.longest) break;
        Task task;
        task.point.peer = i, task.point.method = &method;
        task.point.links = links, task.point.setting = setting;
        task.run = method.start(chain_of(links), setting);
        before = judge(task, reference);
        const bool enough = !task.point.failed() && task.point.error < kRounding;
        task.repeats = static_cast<int>(std::clamp(kEnoughMs / std::max(before, 0.01), 1.0, 20.0));
        if (task.point.failed()) task.run.reset();
        tasks.push_back(std::move(task));
        if (enough) break;
      }
    }
  tell("");
}

/// Rounds through all tasks, each in an order of its own, so that what the machine does between
/// times hits all alike.
void time_all(const Choices& choices, std::vector<Task>& tasks) {
  std::mt19937 dice(1);
  std::vector<Task*> order;
  for (Task& task : tasks)
    if (!task.point.failed()) order.push_back(&task);
  for (int round = 0; round < choices.rounds; ++round) {
    std::shuffle(order.begin(), order.end(), dice);
    for (std::size_t i = 0; i < order.size(); ++i) {
      tell("round " + std::to_string(round + 1) + " of " + std::to_string(choices.rounds) + ": " +
           std::to_string(i) + " of " + std::to_string(order.size()));
      double sum = 0;
      for (int n = 0; n < order[i]->repeats; ++n) sum += time_once(*order[i]->run);
      order[i]->point.ms.push_back(sum / order[i]->repeats);
    }
  }
  tell("");
}

}  // namespace

int main(int argc, char** argv) {
  const Choices choices = read_choices(argc, argv);
  const auto could_not_write = [&] {
    std::fprintf(stderr, "peers: could not write %s\n", choices.csv.c_str());
    return 4;
  };
  // Better told now than after minutes.
  if (std::FILE* file = choices.csv.empty() ? nullptr : std::fopen(choices.csv.c_str(), "a"))
    std::fclose(file);
  else if (!choices.csv.empty())
    return could_not_write();
  Report report;
  report.rounds = choices.rounds;
  report.load_before = load();
  report.peers = find_peers(choices);
  std::vector<Task> tasks;
  for (const int links : choices.links) {
    report.references.push_back(find_reference(report.peers, links));
    plan(choices, report, links, &report.references.back(), tasks);
  }
  for (const int links : choices.cost) plan(choices, report, links, nullptr, tasks);
  if (tasks.empty()) refuse("nothing is left to measure");
  const double cpu = cpu_seconds(), wall = seconds_of(CLOCK_MONOTONIC);
  time_all(choices, tasks);
  report.cpu_seconds = cpu_seconds() - cpu,
  report.wall_seconds = seconds_of(CLOCK_MONOTONIC) - wall;
  report.load_after = load();
  for (Task& task : tasks) report.points.push_back(std::move(task.point));

  if (choices.json)
    print_json(report, stdout);
  else
    print_tables(report, stdout);
  if (choices.csv.empty()) return 0;
  std::FILE* const file = std::fopen(choices.csv.c_str(), "w");
  if (file) print_csv(report, file);
  const bool bad = !file || std::ferror(file) != 0;
  return (file && std::fclose(file) != 0) || bad ? could_not_write() : 0;
}
