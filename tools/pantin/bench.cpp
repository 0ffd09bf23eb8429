#include "tools/pantin/bench.hpp"

#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>

#include "engine/base/atomic_file.hpp"
#include "engine/base/compiler.hpp"
#include "engine/base/utf8.hpp"
#include "engine/solvers/articulated/kernels.hpp"
#include "tools/pantin/command_line.hpp"

namespace pantin::program {

using namespace detail;

namespace {

/// One repetition: the times of all steps, and its counters.
struct Lap {
  std::vector<double> seconds;
  double allocations_per_step = 0;
  std::uint64_t hash = 0;  // of the state after the last step
};

constexpr int kWarmUp = 10;  // untimed steps

Lap lap(const Scene& scene, int threads, bool& sound) {
  Lap l;
  const std::uint64_t steps = steps_of(scene);
  l.seconds.reserve(steps);
  Simulation sim = Simulation::copy_of(scene.world, settings_of(scene, threads));
  for (int i = 0; i < kWarmUp; ++i) sim.step();
  const std::uint64_t before = allocations();
  double last = cpu_seconds();
  for (std::uint64_t i = 0; i < steps && sound && !interrupted(); ++i) {
    sound = sim.step().status == Status::ok;
    const double now = cpu_seconds();
    l.seconds.push_back(now - last);
    last = now;
  }
  l.allocations_per_step = static_cast<double>(allocations() - before) / static_cast<double>(steps);
  l.hash = state_hash(sim.world);
  return l;
}

/// Measures accuracy, energy and stages in a separate pass, so that they do not disturb the timing.
void measure_beside(const Scene& scene, int threads, double links, Json& row) {
  const std::uint64_t bytes_before = live_bytes();
  StepSettings how = settings_of(scene, threads);
  how.measure = true;
  Simulation sim = Simulation::copy_of(scene.world, how);
  double depth = 0, violation = 0, residual = 0;
  int contacts = 0, stops = 0;
  double worst = 0, worst_rel = 0, most_energy = measure(sim.world).energy();
  const double start_energy = most_energy;
  StepReport report;
  std::uint64_t bytes = 0;
  using Clock = std::chrono::steady_clock;
  double seconds = 0;  // of the steps whose stages are timed, on the same clock
  const std::uint64_t steps = steps_of(scene);
  for (std::uint64_t i = 0; i < steps && !interrupted(); ++i) {
    sim.timing = i >= kWarmUp;
    const auto from = Clock::now();
    report = sim.step();
    if (sim.timing) seconds += std::chrono::duration<double>(Clock::now() - from).count();
    if (i == 0) bytes = live_bytes() - bytes_before;
    worst = std::max(worst, report.measures.worst_gap);
    worst_rel = std::max(worst_rel, report.measures.worst_gap_rel);
    most_energy = std::max(most_energy, report.measures.energy());
    depth = std::max(depth, report.worst_depth);
    violation = std::max(violation, report.measures.worst_violation);
    residual = std::max(residual, report.worst_residual);
    contacts = std::max(contacts, report.contacts), stops = std::max(stops, report.stops_hit);
    if (report.status == Status::diverged || report.status == Status::energy_grew ||
        report.status == Status::contact_lost)
      break;
  }
  const double per =
      1e9 / (links * static_cast<double>(std::max<std::uint64_t>(1, steps - kWarmUp)));
  row["stages_ns_per_link"] = {
      {"drive", per * sim.times.drive},
      {"update", per * sim.times.update},
      {"adjust", per * sim.times.adjust},
      {"touch", per * sim.times.contacts},
      {"rest", per * (seconds - sim.times.drive - sim.times.update - sim.times.adjust -
                      sim.times.contacts - sim.times.measure)}};
  row["bytes_per_link"] = static_cast<double>(bytes) / links;
  row["contacts_max"] = contacts;
  row["contact_depth_m"] = depth;
  row["limit_hits_max"] = stops;
  row["limit_violation_rad"] = violation;
  row["worst_residual_m"] = residual;
  row["worst_gap_m"] = worst;
  row["worst_gap_rel"] = worst_rel;
  row["energy_start_j"] = start_energy;
  row["energy_end_j"] = report.measures.energy();
  row["energy_max_j"] = most_energy;
  row["hash"] = hex(state_hash(sim.world));
}

std::optional<Json> bench_scene(const std::string& path, const BenchChoices& c, bool& sound) {
  const std::optional<Scene> scene = open_scene(path, c.how);
  if (!scene) return std::nullopt;
  const auto links = static_cast<double>(std::max<std::size_t>(1, scene->world.links.size()));
  std::vector<double> medians, tails, steps;
  double most = 0, allocated = 0;
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < c.repeat.value_or(3) && sound && !interrupted(); ++i) {
    Lap l = lap(*scene, c.threads, sound);
    hashes.push_back(l.hash);
    steps.insert(steps.end(), l.seconds.begin(), l.seconds.end());
    medians.push_back(percentile(l.seconds, 0.5)), tails.push_back(percentile(l.seconds, 0.99));
    most = std::max(most, l.seconds.empty() ? 0 : l.seconds.back());
    allocated = std::max(allocated, l.allocations_per_step);
  }
  Json row;
  row["scene"] = path;
  row["title"] = scene->title;
  // Of one and the same motion, unless a budget makes it depend on the machine.
  const bool is_repeated = std::ranges::count(hashes, hashes.empty() ? 0 : hashes[0]) ==
                           static_cast<std::ptrdiff_t>(hashes.size());
  row["status"] = !sound ? "diverged" : is_repeated || scene->budget_ms > 0 ? "ok" : "varies";
  row["solver"] = solver_in_use(scene->world);
  row["solvers"] = solvers_json(scene->world);
  row["step_s"] = scene->step;
  row["steps"] = steps_of(*scene);
  row["repeats"] = medians.size();
  row["bodies"] = scene->world.bodies.size();
  row["joints"] = scene->world.links.size();
  const double median = percentile(medians, 0.5), tail = percentile(tails, 0.5);
  row["frame_ms_median"] = 1e3 * median;
  row["frame_ms_mean"] = steps.empty() ? 0.0
                                       : 1e3 * std::accumulate(steps.begin(), steps.end(), 0.0) /
                                             static_cast<double>(steps.size());
  row["frame_ms_p95"] = 1e3 * percentile(steps, 0.95);
  row["frame_ms_p99"] = 1e3 * tail;
  row["frame_ms_max"] = 1e3 * most;
  const auto is_late = [&](double seconds) { return seconds > scene->step; };
  row["late_steps"] = std::ranges::count_if(steps, is_late);
  row["step_part_p99"] = tail / scene->step;
  row["ns_per_link_step_median"] = 1e9 * median / links;
  row["ns_per_link_step_p99"] = 1e9 * tail / links;
  row["ns_per_link_step_repeats"] = {1e9 * percentile(medians, 0) / links,
                                     1e9 * percentile(medians, 1) / links};
  row["allocations_per_step"] = allocated;
  row["timed_hash"] = hashes.empty() ? "" : hex(hashes[0]);
  measure_beside(*scene, c.threads, links, row);
  row["warnings"] = scene->warnings;
  return row;
}

std::string first_line_with(const char* file, const std::string& key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(key)) return line.substr(std::min(line.size(), line.find(':') + 2));
  return "unknown";
}

/// The rows as CSV.
std::string csv_of(const Json& head, const Json& rows) {
  std::string text;
  for (const auto& [key, value] : head.items())
    text +=
        fmt::format("# {}: {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
  const std::string_view columns[] = {"scene",
                                      "solver",
                                      "step_s",
                                      "bodies",
                                      "joints",
                                      "frame_ms_median",
                                      "frame_ms_p95",
                                      "frame_ms_p99",
                                      "frame_ms_max",
                                      "late_steps",
                                      "step_part_p99",
                                      "ns_per_link_step_median",
                                      "ns_per_link_step_p99",
                                      "allocations_per_step",
                                      "bytes_per_link",
                                      "worst_gap_m",
                                      "worst_gap_rel",
                                      "contacts_max",
                                      "contact_depth_m",
                                      "limit_hits_max",
                                      "limit_violation_rad",
                                      "worst_residual_m",
                                      "energy_start_j",
                                      "energy_end_j",
                                      "energy_max_j",
                                      "status",
                                      "hash",
                                      "timed_hash"};
  text += fmt::format("{}\n", fmt::join(columns, ","));
  for (const Json& row : rows) {
    std::vector<std::string> cells;
    for (const std::string_view column : columns) {
      const Json& cell = row[std::string(column)];
      cells.push_back(cell.is_string() ? cell.get<std::string>() : cell.dump());
    }
    text += fmt::format("{}\n", fmt::join(cells, ","));
  }
  return text;
}

/// Which scenes keep up with real time, and which comes closest to not doing so.
void print_budget(const Json& rows) {
  std::size_t kept = 0;
  const Json* worst = nullptr;
  for (const Json& r : rows) {
    kept += r["late_steps"] == 0;
    if (!worst || r["step_part_p99"].get<double>() > (*worst)["step_part_p99"].get<double>())
      worst = &r;
  }
  if (!worst) return;
  fmt::print(
      "real time: {} of {} scenes have no step that takes longer than it simulates; most is "
      "{:.1f} % of the step, {} (p99)\n",
      kept, rows.size(), 100 * (*worst)["step_part_p99"].get<double>(),
      printable((*worst)["scene"].get<std::string>()));
}

void print_table(const Json& head, const Json& rows) {
  fmt::print("pantin {}  {}  {} kernels  {} x {}  load {:.1f}\n",
             head["version"].get<std::string>(), head["compiler"].get<std::string>(),
             head["kernels"].get<std::string>(), head["cores"].get<long>(),
             head["cpu"].get<std::string>(), head.value("load", 0.0));
  fmt::print("{}\n", bold(fmt::format(
                         "{:<24} {:>7} {:>6} {:>9} {:>9} {:>9} {:>9} {:>7} {:>8} {:>8} {:>7} "
                         "{:>8} {:>9}",
                         "scene", "solver", "joints", "median ms", "p95 ms", "p99 ms", "max ms",
                         "of step", "ns/link", "p99", "allocs", "B/link", "gap/size")));
  for (const Json& r : rows) {
    const auto scene = printable(r["scene"].get<std::string>());
    const std::size_t slash = scene.rfind('/');
    fmt::print(
        "{:<24} {:>7} {:>6} {:>9.4f} {:>9.4f} {:>9.4f} {:>9.4f} {:>5.1f} % {:>8.1f} {:>8.1f} "
        "{:>7.2f} {:>8.0f} {:>9.1e}{}\n",
        slash == std::string::npos ? scene : scene.substr(slash + 1),
        r["solver"].get<std::string>(), r["joints"].get<std::size_t>(),
        r["frame_ms_median"].get<double>(), r["frame_ms_p95"].get<double>(),
        r["frame_ms_p99"].get<double>(), r["frame_ms_max"].get<double>(),
        100 * r["step_part_p99"].get<double>(), r["ns_per_link_step_median"].get<double>(),
        r["ns_per_link_step_p99"].get<double>(), r["allocations_per_step"].get<double>(),
        r["bytes_per_link"].get<double>(), r["worst_gap_rel"].get<double>(),
        r["status"] == "diverged" ? "  DIVERGED"
        : r["status"] == "varies" ? "  VARIES"
                                  : "");
  }
  print_budget(rows);
}

int bench(const BenchChoices& c) {
  if (!c.against.empty()) return bench_against(c);
  const Json head = build_and_machine();
  Json rows = Json::array();
  int exit_code = kOk;
  for (const std::string& path : c.scenes) {
    if (interrupted()) return kInterrupted;
    bool sound = true;
    const std::optional<Json> row = bench_scene(path, c, sound);
    if (!row) return kUsage;
    rows.push_back(*row);
    if ((*row)["status"] == "varies") {
      complain(fmt::format("{}: the same run had different results", path));
      exit_code = kFailed;
    }
    if (sound) continue;
    complain(fmt::format("{}: diverged", path));
    exit_code = kDiverged;
  }
  if (!c.csv.empty())
    if (const auto written = write_file(c.csv, csv_of(head, rows)); !written) {
      complain(written.errors().front().message);
      return kUnwritable;
    }
  if (!c.history.empty() && !interrupted())
    if (const auto kept = append_history(c.history, head, rows); !kept) {
      complain(kept.errors().front().message);
      return kUnwritable;
    }
  if (c.json) {
    Json j = head;
    j["rows"] = rows;
    print_json(j);
  } else {
    print_table(head, rows);
  }
  return interrupted() ? kInterrupted : exit_code;
}

constexpr const char* kExamples =
    R"(Measures the CPU time of the steps of each scene, without drawing; accuracy, energy and stages
are measured in a separate pass. Each speed is printed with its drift. "of step" is the p99 as a part
of the time that a step simulates: below 100 % it runs in real time.

--against PROGRAM times another build in turns with this one, at least eight times (--repeat,
default 12), each in a process of its own, and says whether this one is faster, slower, or no
difference is seen: the change of the mean step, with the interval that holds 99 % (Wilcoxon's signed
ranks of the paired log ratios, Hodges-Lehmann's estimate). "results differ": so do the hashes of the
end states, and the two do not do the same work. --history appends a line for each scene to a file.

Examples:
  pantin bench assets/scenes/chain.json assets/scenes/marionette.json
  pantin bench assets/scenes/bench_chain200.json --solver sweep --repeat 9
  pantin bench assets/scenes/chain10.json --solver lagrangian --integrator euler
  pantin bench assets/scenes/*.json --csv out/bench.csv --json
  pantin bench assets/scenes/chain10.json --history out/history.csv
  pantin bench assets/scenes/chain10.json --repeat 8 --against $(command -v pantin)

--json prints version, commit, compiler, flags, kernels, cpu, cores, load, clock and rows; a row has
scene, title, status, solver, solvers, step_s, steps, repeats, bodies, joints, frame_ms_median (median of the
repeats' medians), frame_ms_p95, frame_ms_p99, frame_ms_max, ns_per_link_step_median,
ns_per_link_step_p99, ns_per_link_step_repeats (least and largest median), allocations_per_step,
frame_ms_mean, late_steps (those that took longer than they simulate), step_part_p99 (p99 as a part of
the step), timed_hash (end of the timed runs; status "varies": not the same for all),
stages_ns_per_link (drive, update, adjust, touch, rest), bytes_per_link, worst_gap_m, worst_gap_rel,
contacts_max, contact_depth_m, limit_hits_max, limit_violation_rad, worst_residual_m,
energy_start_j, energy_end_j, energy_max_j, hash, warnings. With --against a row has verdict (faster,
slower, no difference seen), results (same, differ), change (-0.1: a tenth less time),
change_interval, words, scene, ratios (ours by theirs, of each pair).

Exit codes: 0 ok, 1 the same run had different results, or the other program failed, 2 usage or bad
input, 3 diverged, 4 could not write, 130 interrupted.)";

}  // namespace

Json build_and_machine() {
  Json j;
  j["version"] = PANTIN_VERSION;
#ifdef PANTIN_COMMIT
  j["commit"] = PANTIN_COMMIT;
#endif
  j["compiler"] = PANTIN_COMPILER;
#ifdef PANTIN_FLAGS
  j["flags"] = PANTIN_FLAGS;
#endif
  j["kernels"] = articulated::kernels().name;
  j["cpu"] = first_line_with("/proc/cpuinfo", "model name");
  j["cores"] = sysconf(_SC_NPROCESSORS_ONLN);
  double load[1] = {0};
  if (getloadavg(load, 1) == 1) j["load"] = load[0];
  j["clock"] = "process CPU time, all threads";
  return j;
}

void add_bench(CommandLine& program) {
  auto c = std::make_shared<BenchChoices>();
  const Subcommand command =
      program.add("bench", "Measures step times of scenes, with their drift");
  command.option("scene", c->scenes, "scene files").required().type(kSceneType);
  add_scene_choices(command, c->how);
  add_threads(command, c->threads);
  command
      .option("--repeat", c->repeat, "number of runs of each scene; default 3, with --against 12")
      .within(1, 1000);
  command.option("--csv", c->csv, "CSV file for the rows").type(kFileType);
  command.option("--history", c->history, "CSV file to append a line for each scene to")
      .type(kFileType);
  command.option("--against", c->against, "another build of this program, timed in turns with it")
      .type("PROGRAM");
  command.flag("--json", c->json, "print one JSON object instead of a table");
  command.footer(kExamples);
  command.runs([c] { return bench(*c); });
}

}  // namespace pantin::program
