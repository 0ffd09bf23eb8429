// Measures the exact solver beside other engines, in one run.
#include <dlfcn.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "tools/peers/rounds.hpp"

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

Every round goes through all methods, in another order and in a process of its own; figures are
medians of the rounds. Exit code: 0, or 1 where a round was lost, 2 for a wrong call, 4 where a file could not be written.
)";

struct Choices {
  std::vector<int> links{10, 50}, cost{100};
  int rounds = 5, finest = 15360;
  double longest = 3;
  std::vector<std::string> only;
  std::vector<std::pair<std::string, std::string>> modules;
  std::string csv;
  bool json = false, small = false, serve = false;
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

/// The values that an option takes.
struct Range {
  double low = 0, high = 0;
  bool whole = false;  // without fractions
};

/// The number that `text` is, all of it, in a range.
double number_of(const std::string& option, const std::string& text, const Range& range) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !(value >= range.low && value <= range.high) ||
      (range.whole && value != std::floor(value))) {
    char expected[80];
    std::snprintf(expected, sizeof expected, "%s from %g to %g",
                  range.whole ? "a whole number" : "a number", range.low, range.high);
    refuse(option + ": found \"" + text + "\", expected " + expected);
  }
  return value;
}

std::vector<int> sizes(const std::string& option, const std::string& text) {
  std::vector<int> numbers;
  // Pinocchio's data grow with the cube of the links.
  for (const std::string& part : split(text))
    numbers.push_back(
        static_cast<int>(number_of(option, part, {.low = 1, .high = 100, .whole = true})));
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
    } else if (word == kServe) {
      c.serve = true;
    } else {
      static constexpr const char* kKnown[] = {"--links",   "--cost", "--rounds", "--finest",
                                               "--longest", "--only", "--engine", "--csv"};
      if (std::find(std::begin(kKnown), std::end(kKnown), word) == std::end(kKnown))
        refuse("found \"" + word + "\", expected an option");
      if (i + 1 >= argc) refuse(word + ": expected a value behind it");
      const std::string value = argv[++i];
      if (word == "--links") c.links = sizes(word, value);
      if (word == "--cost") c.cost = sizes(word, value);
      if (word == "--rounds")
        c.rounds =
            static_cast<int>(number_of(word, value, {.low = 1, .high = 1000, .whole = true}));
      if (word == "--finest")
        c.finest =
            static_cast<int>(number_of(word, value, {.low = kFrames, .high = 1e6, .whole = true}));
      if (word == "--longest") c.longest = number_of(word, value, {.low = 0.01, .high = 1e4});
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

double wall_seconds() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// CPU time of the processes that this one started and that ended.
double cpu_seconds_of_children() {
  rusage all{};
  getrusage(RUSAGE_CHILDREN, &all);
  return static_cast<double>(all.ru_utime.tv_sec + all.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(all.ru_utime.tv_usec + all.ru_stime.tv_usec);
}

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
    else if (!choices.serve)
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
    const double turning = dot(l.angular_velocity, l.axis);
    s.energy += chain.mass() * (dot(l.velocity, l.velocity) / 2 + chain.gravity * l.centre[1]) +
                (across * dot(l.angular_velocity, l.angular_velocity) +
                 (along - across) * turning * turning) /
                    2;
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

/// Goes frame by frame, and once in one go for the error. Returns the CPU ms of the latter.
double judge(Point& p, Run& run, const Reference* reference) {
  const Chain chain = chain_of(p.links);
  std::vector<LinkState> links(static_cast<std::size_t>(p.links));
  run.reset();
  for (int frame = 0; frame < kFrames && !p.failed(); frame += p.method->stride) {
    const bool going = run.advance(p.method->stride);
    run.read(links.data());
    const State s = look(chain, links);
    const double gain = s.energy / chain.energy();
    if (!going || !s.finite || s.gap >= chain.length * p.links || gain > 10)
      p.failed_at = double(frame + p.method->stride) / kFrames;
    p.gap = std::max(p.gap, s.gap);
    if (std::abs(gain) > std::abs(p.energy)) p.energy = gain;
  }
  if (p.failed()) return 0;
  const double ms = time_once(run);
  p.counts = run.counts();
  run.read(links.data());
  p.error = reference ? distance(links, *reference) : NAN;
  return ms;
}

bool is_wanted(const Choices& choices, const Peer& peer, const Method& method) {
  const std::string name = peer.name + " " + method.name;
  return choices.only.empty() ||
         std::any_of(choices.only.begin(), choices.only.end(),
                     [&](const std::string& word) { return name.find(word) != std::string::npos; });
}

/// What is measured at one size.
enum class Aim { cost_and_error, cost_only };

std::vector<double> settings_of(const Choices& choices, const Method& method, Aim aim) {
  std::vector<double> settings;
  if (aim == Aim::cost_only) return method.adaptive ? settings : std::vector<double>{16, 64};
  if (method.adaptive)
    for (double t = method.loosest; t > 0.5 * method.tightest; t /= choices.small ? 1000 : 10)
      settings.push_back(t);
  else
    for (int n = 1; n * kFrames <= choices.finest; n *= 2) settings.push_back(n);
  return settings;
}

/// Everything that is to be timed at one size, judged; what is too slow is left out. Without a
/// reference only the cost is measured.
std::vector<Task> plan(const Choices& choices, const Report& report, int links,
                       const Reference* reference) {
  constexpr double kEnoughMs = 10, kRounding = 1e-11;
  const Aim aim = reference ? Aim::cost_and_error : Aim::cost_only;
  std::vector<Task> tasks;
  for (std::size_t i = 0; i < report.peers.size(); ++i)
    for (const Method& method : methods_of(*report.peers[i].engine)) {
      if (!is_wanted(choices, report.peers[i], method)) continue;
      tell(std::to_string(links) + " links: " + report.peers[i].name + " " + method.name);
      double before = 0;
      for (const double setting : settings_of(choices, method, aim)) {
        if (2 * before > 1e3 * choices.longest) break;
        Task task;
        task.point.peer = i, task.point.method = &method;
        task.point.links = links, task.point.setting = setting;
        before = judge(task.point, *method.start(chain_of(links), setting), reference);
        const bool enough = !task.point.failed() && task.point.error < kRounding;
        task.repeats = static_cast<int>(std::clamp(kEnoughMs / std::max(before, 0.01), 1.0, 20.0));
        tasks.push_back(std::move(task));
        if (enough) break;
      }
    }
  tell("");
  return tasks;
}

}  // namespace

void pantin::peers::tell(const std::string& what) {
  if (isatty(STDERR_FILENO)) std::fprintf(stderr, "\r\033[K%s", what.c_str());
}

int main(int argc, char** argv) {
  const Choices choices = read_choices(argc, argv);
  if (choices.serve) {
    serve_round(find_peers(choices));
    return 0;
  }
  const auto could_not_write = [&] {
    std::fprintf(stderr, "peers: could not write %s\n", choices.csv.c_str());
    return 4;
  };
  // Better told now than after minutes. Beside its place until it is whole.
  const std::string part = choices.csv + ".part";
  std::FILE* const file = choices.csv.empty() ? nullptr : std::fopen(part.c_str(), "w");
  if (!file && !choices.csv.empty()) return could_not_write();
  Report report;
  report.rounds = choices.rounds;
  report.load_before = load();
  report.peers = find_peers(choices);
  std::vector<Task> tasks;
  const auto add = [&](const std::vector<Task>& more) {
    tasks.insert(tasks.end(), more.begin(), more.end());
  };
  for (const int links : choices.links) {
    report.references.push_back(find_reference(report.peers, links));
    add(plan(choices, report, links, &report.references.back()));
  }
  for (const int links : choices.cost) add(plan(choices, report, links, nullptr));
  if (tasks.empty()) {
    if (file) std::remove(part.c_str());
    refuse("nothing is left to measure");
  }
  const double from = wall_seconds(), spent = cpu_seconds_of_children();
  if (!time_rounds(choices.rounds, argv, tasks, report)) {
    std::fputs("peers: a round did not come to its end\n", stderr);
    if (file) std::remove(part.c_str());
    return 1;
  }
  report.wall_seconds = wall_seconds() - from,
  report.cpu_seconds = cpu_seconds_of_children() - spent;
  report.load_after = load();
  for (Task& task : tasks) report.points.push_back(std::move(task.point));

  if (choices.json)
    print_json(report, stdout);
  else
    print_tables(report, stdout);
  if (!file) return 0;
  print_csv(report, file);
  const bool bad = std::fflush(file) != 0 || std::ferror(file) != 0;
  if (std::fclose(file) == 0 && !bad && std::rename(part.c_str(), choices.csv.c_str()) == 0)
    return 0;
  std::remove(part.c_str());
  return could_not_write();
}
