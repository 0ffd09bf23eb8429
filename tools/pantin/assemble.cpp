// Brings the parts of a scene together, or tells which joints contradict one another.
#include "engine/assembly/assemble.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "engine/base/utf8.hpp"
#include "engine/scene/json/text_file.hpp"
#include "engine/scene/json/words.hpp"
#include "tools/pantin/assemble.hpp"
#include "tools/pantin/command_line.hpp"
#include "tools/pantin/program.hpp"

namespace pantin::program {

using namespace detail;
using namespace detail::assembly;

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostTold = 8;

struct AssembleChoices {
  std::string scene, method = "auto", out, trace;
  std::vector<std::string> hold, free;
  double tolerance = 1e-12;
  std::optional<double> scatter;
  std::optional<std::string> jacobians;
  int iterations = 400, starts = 24, seed = 1, trials = 0, threads = 1;
  PictureChoices pictures;
  bool json = false;
};

/// One row of the trace, and the poses then.
struct TraceRow {
  int iteration;
  double seconds, residual, merit, damping;
};

/// A scene, its World before, and what its assembly reports.
struct Assembled {
  const AssembleChoices& c;
  Scene& scene;
  World start;
  std::vector<SceneFree> free;
  AssemblyReport report;
  std::vector<TraceRow> trace;
  AssemblyFilm film;
  double seconds = 0;
};

std::vector<std::string> method_words() {
  std::vector<std::string> words;
  for (const Method& m : methods()) words.emplace_back(m.name);
  return words;
}

const Method* method_of(const std::string& word) {
  for (const Method& m : methods())
    if (m.name == word) return &m;
  return nullptr;
}

/// The bodies of --hold; a name of a chain or an instance stands for all of its bodies.
std::optional<std::vector<Entity>> held_bodies(const World& world,
                                               const std::vector<std::string>& names) {
  std::vector<Entity> held;
  std::vector<std::string> known;
  for (const Entity e : world.bodies.owners()) known.push_back(world.name_of(e));
  for (const std::string& name : names) {
    const std::size_t before = held.size();
    for (std::size_t i = 0; i < known.size(); ++i)
      if (known[i] == name || known[i].starts_with(name + "/"))
        held.push_back(world.bodies.owners()[i]);
    if (held.size() > before) continue;
    const std::vector<std::string_view> views(known.begin(), known.end());
    complain(fmt::format("--hold: found {}, expected the name of a body{}", quoted_name(name),
                         hint(name, views)));
    return std::nullopt;
  }
  return held;
}

/// The design variables of the scene and of --free.
std::optional<std::vector<SceneFree>> free_of(const AssembleChoices& c, const Scene& scene) {
  auto found = free_numbers(c.scene, scene.world, {"--free", c.free});
  if (!found) {
    for (const Error& e : found.errors())
      e.message.starts_with("--free") ? complain(e.message) : print_error(e.message);
    return std::nullopt;
  }
  if (found->empty() || method_of(c.method)->changes_design) return *found;
  std::vector<std::string_view> able;
  for (const Method& m : methods())
    if (m.changes_design) able.push_back(m.name);
  complain(fmt::format("--method: found \"{}\", which changes no design variables, expected {}",
                       c.method, listed(able)));
  return std::nullopt;
}

AssemblyChoices choices_of(const AssembleChoices& c, std::vector<Entity> held,
                           const std::vector<SceneFree>& free) {
  AssemblyChoices choices;
  choices.method = method_of(c.method);
  choices.effort = {c.tolerance, c.iterations, c.threads};
  choices.held = std::move(held), choices.starts = c.starts;
  choices.seed = static_cast<std::uint64_t>(c.seed);
  for (const SceneFree& f : free) choices.free.push_back(f.variable);
  return choices;
}

/// s: CPU time of this thread, which other programs do not lengthen.
double spent() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void run_once(Assembled& a, AssemblyChoices choices) {
  const EndsAtOnce while_nothing_is_written;
  const bool draws = a.c.pictures.wanted();
  World seen = a.scene.world;
  const Clock::time_point begin = Clock::now();
  const double spent_before = spent();
  choices.watch = [&](const Iteration& i) {
    a.trace.push_back({i.number, spent() - spent_before, i.residual, i.merit, i.damping});
    if (!draws) return;
    write_poses(*i.part, seen);
    a.film.residuals.push_back(i.residual);
    a.film.poses.emplace_back();
    for (const Body& b : seen.bodies.values()) a.film.poses.back().push_back(b.pose);
  };
  a.report = assemble(a.scene.world, choices);
  a.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  if (!draws || a.free.empty()) return;
  // The least change of the design follows the iterations.
  a.film.residuals.push_back(a.report.residual);
  a.film.poses.emplace_back();
  for (const Body& b : a.scene.world.bodies.values()) a.film.poses.back().push_back(b.pose);
}

std::vector<std::string> names_of(const World& world, const std::vector<Entity>& all) {
  std::vector<std::string> names;
  for (const Entity e : all) names.push_back(world.name_of(e));
  return names;
}

Json to_json(const Assembled& a) {
  const AssemblyReport& r = a.report;
  const World& w = a.scene.world;
  Json j;
  j["scene"] = a.c.scene, j["title"] = a.scene.title;
  j["status"] = r.assembled ? "assembled" : "cannot be assembled";
  j["method"] = a.c.method, j["tolerance"] = a.c.tolerance;
  j["residual"] = r.residual, j["iterations"] = r.iterations;
  j["restarts"] = r.starts, j["perturbations"] = r.perturbations, j["seed"] = r.seed;
  j["turned_over"] = r.turned_over, j["brought_into_contact"] = r.brought;
  j["bodies"] = r.bodies, j["rows"] = r.rows, j["rank"] = r.rank, j["mobility"] = r.mobility;
  j["moved_m"] = r.moved, j["turned_rad"] = r.turned, j["seconds"] = a.seconds;
  j["design"] = design_to_json(w, a.free, r.design);
  j["residuals"] = Json::array();
  for (const LawResidual& l : r.residuals)
    j["residuals"].push_back(
        {{"law", w.name_of(l.law)}, {"residual", l.residual}, {"limit", l.is_limit}});
  j["redundant"] = Json::array();
  for (const RedundantLaw& l : r.redundant)
    j["redundant"].push_back({{"law", w.name_of(l.law)}, {"rows", l.rows}});
  j["wrong_branch"] = names_of(w, r.wrong_branch);
  j["at_limits"] = names_of(w, r.reached_limits);
  j["contradictory"] = names_of(w, r.contradictory);
  return j;
}

void print_report(const Assembled& a) {
  const AssemblyReport& r = a.report;
  const World& w = a.scene.world;
  fmt::print("{}\n", bold(a.scene.title));
  fmt::print("  {}   largest residual {:.1e} (m or rad), {} iterations of {}, {:.3g} ms\n",
             r.assembled ? "assembled" : "NOT assembled: pose of least squares", r.residual,
             r.iterations, a.c.method, 1e3 * a.seconds);
  fmt::print("  moved       by up to {:.4g} m and {:.4g} degrees\n", r.moved, 180 / kPi * r.turned);
  if (r.starts > 0 || r.perturbations > 0 || r.turned_over > 0)
    fmt::print(
        "  branch      {} perturbed starts, {} perturbations at saddles (seed {}), {} bodies "
        "turned over\n",
        r.starts, r.perturbations, r.seed, r.turned_over);
  fmt::print("  freedoms    {}: {} bodies, {} rows of rank {}\n", r.mobility, r.bodies, r.rows,
             r.rank);
  const auto print_list = [](const char* what, const std::vector<std::string>& words) {
    if (words.empty()) return;
    const std::size_t told = std::min(words.size(), kMostTold);
    fmt::print(
        "  {:<11} {}{}\n", what,
        printable(fmt::format("{}", fmt::join(words.begin(), words.begin() + told, ", "))),
        words.size() > told ? fmt::format(" and {} more, see --json", words.size() - told) : "");
  };
  std::vector<std::string> redundant, residuals;
  for (const RedundantLaw& l : r.redundant)
    redundant.push_back(fmt::format("{} ({})", w.name_of(l.law), l.rows));
  for (std::size_t i = 0; i < std::min(a.free.size(), r.design.size()); ++i)
    fmt::print("  design      {}\n", printable(words_of(w, a.free[i], r.design[i])));
  print_list("redundant", redundant);
  print_list("at limits", names_of(w, r.reached_limits));
  print_list("opposed", names_of(w, r.wrong_branch));
  if (r.assembled) return;
  for (const LawResidual& l : r.residuals)
    if (l.residual > a.c.tolerance)
      residuals.push_back(
          fmt::format("{}{} {:.3g}", w.name_of(l.law), l.is_limit ? " (limit)" : "", l.residual));
  print_list("residuals", residuals);
  print_list("contradict", names_of(w, r.contradictory));
}

/// Why a scene could not be assembled.
std::string words_of_failure(const Assembled& a) {
  const std::vector<std::string> names = names_of(a.scene.world, a.report.contradictory);
  std::vector<std::string> bounded;
  for (std::size_t i = 0; i < std::min(a.free.size(), a.report.design.size()); ++i)
    if (a.report.design[i].is_at_bound) bounded.push_back(a.free[i].path);
  const std::string at_bounds =
      bounded.empty() ? "" : fmt::format("; at a bound: {}", fmt::join(bounded, ", "));
  if (!names.empty())
    return fmt::format("found a contradiction of {}, expected laws that can hold together{}",
                       fmt::join(names, ", "), at_bounds);
  return fmt::format(
      "found a residual of {:.3g} after {} iterations of {}, expected at most {:g}; "
      "the laws do not contradict one another",
      a.report.residual, a.report.iterations, a.c.method, a.c.tolerance);
}

int write_trace(const Assembled& a) {
  std::string text = "iteration,seconds,residual,merit,damping\n";
  for (const TraceRow& t : a.trace)
    text +=
        fmt::format("{},{:.9f},{},{},{}\n", t.iteration, t.seconds, t.residual, t.merit, t.damping);
  return write_or_complain(a.c.trace, text);
}

/// Writes the scene with its new poses and reads it again.
int write_scene(const Assembled& a) {
  const auto text = read_text(a.c.scene, SceneLimits{}.bytes, "a scene file");
  if (!text) {
    for (const Error& e : text.errors()) print_error(e.message);
    return kUsage;
  }
  for (const SceneFree& f : a.free)
    if (!f.element)
      print_error(fmt::format(
          "warning: {}: found {} in a prefab or generator, expected it in the scene itself: it "
          "is not written",
          a.c.scene, quoted_name(f.path)));
  const auto written =
      with_poses(with_design(*text, a.scene.world, a.free), a.start, a.scene.world);
  if (!written) {
    for (const Error& e : written.errors()) print_error(a.c.scene + ": " + e.message);
    return kUsage;
  }
  if (const int code = write_or_complain(a.c.out, *written); code != kOk) return code;
  const Result<Scene> again = load_scene(a.c.out);
  if (again) return kOk;
  for (const Error& e : again.errors()) print_error(e.message);
  return kFailed;
}

/// Files that a scene refers to are found from its folder.
std::string stray_folder(const AssembleChoices& c, const Scene& scene) {
  std::error_code ignored;
  const fs::path from = fs::weakly_canonical(fs::path(c.scene), ignored).parent_path(),
                 to = fs::weakly_canonical(fs::path(c.out), ignored).parent_path();
  if (c.out.empty() || scene.files.empty() || from == to) return {};
  return fmt::format(
      "--out: found the folder {}, expected that of the scene, for the scene refers "
      "to other files from there",
      to.string());
}

/// Assembles from many random starts and tells the share and the iterations.
int try_often(const AssembleChoices& c, const Scene& scene, const std::vector<Entity>& held,
              const std::vector<SceneFree>& free) {
  std::vector<double> iterations, seconds;
  int assembled = 0, at_once = 0;
  Json failed = Json::array();
  for (int i = 0; i < c.trials; ++i) {
    if (interrupted()) return kInterrupted;
    World world = scene.world;
    scatter(world, static_cast<std::uint64_t>(c.seed) + static_cast<std::uint64_t>(i),
            c.scatter.value_or(1), held);
    AssemblyChoices choices = choices_of(c, held, free);
    choices.finds_contradictions = false;
    const Clock::time_point begin = Clock::now();
    const AssemblyReport r = assemble(world, choices);
    seconds.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
    assembled += r.assembled, at_once += r.assembled && r.starts == 0;
    if (r.assembled)
      iterations.push_back(r.iterations);
    else
      failed.push_back({{"seed", c.seed + i}, {"residual", r.residual}});
  }
  const double median = percentile(iterations, 0.5), worst = percentile(iterations, 1);
  const double ms = 1e3 * percentile(seconds, 0.5);
  if (c.json)
    print_json({{"scene", c.scene},
                {"method", c.method},
                {"trials", c.trials},
                {"scatter_m", c.scatter.value_or(1)},
                {"assembled", assembled},
                {"from_first_start", at_once},
                {"iterations_median", median},
                {"iterations_worst", worst},
                {"ms_median", ms},
                {"failed", failed}});
  else
    fmt::print(
        "{}\n  {} of {} random starts assembled, {} without restarts; iterations: median "
        "{:g}, most {:g}; median {:.3g} ms\n",
        bold(scene.title), assembled, c.trials, at_once, median, worst, ms);
  return assembled == c.trials ? kOk : kDiverged;
}

int assemble_scene(const AssembleChoices& c) {
  if (const std::string idle = c.pictures.idle_option(); !idle.empty()) {
    complain(idle);
    return kUsage;
  }
  SolverChoices solver;
  if (c.jacobians) solver.jacobians = jacobians_named(*c.jacobians);
  Result<Scene> loaded = load_scene_in_parts(c.scene, solver);
  if (!loaded) {
    for (const Error& e : loaded.errors()) print_error(e.message);
    return kUsage;
  }
  Scene& scene = *loaded;
  if (const std::string idle = c.jacobians ? idle_jacobians(scene.world) : ""; !idle.empty()) {
    complain(c.scene + ": " + idle);
    return kUsage;
  }
  const auto held = held_bodies(scene.world, c.hold);
  if (!held) return kUsage;
  const auto free = free_of(c, scene);
  if (!free) return kUsage;
  if (const std::string stray = stray_folder(c, scene); !stray.empty()) {
    complain(stray);
    return kUsage;
  }
  if (c.trials > 0) return try_often(c, scene, *held, *free);
  Assembled a{c, scene, scene.world, *free, {}, {}, {}, 0};
  if (c.scatter) scatter(scene.world, static_cast<std::uint64_t>(c.seed), *c.scatter, *held);
  run_once(a, choices_of(c, *held, *free));
  if (c.json)
    print_json(to_json(a));
  else
    print_report(a);
  int code = a.report.assembled ? kOk : kDiverged;
  if (!a.report.assembled) complain(c.scene + ": " + words_of_failure(a));
  for (const int failed :
       {c.out.empty() ? kOk : write_scene(a), c.trace.empty() ? kOk : write_trace(a),
        c.pictures.wanted() ? draw_assembly(c.pictures, scene, a.film) : kOk})
    if (failed != kOk) code = failed;
  return code;
}

constexpr const char* kExamples =
    R"(Moves the bodies of a scene, from wherever they are, to poses at which all laws hold: joints of
all kinds, pins, gears, belts, cables, limits, surfaces and curves in contact. Fixed and kinematic
bodies stay, and those of --hold. The result is near the start where that is possible; otherwise
perturbed starts are tried, of growing size and with a fixed seed.

If the laws contradict one another, the bodies end in the pose of least squares. The report names
the residuals by joint, the largest first, and a set of laws that cannot hold together, each of
which is needed for that: without any one of them the others can hold.

Design variables, the numbers of "free" in the scene and of --free, are solved for together with the
poses: lengths of distance joints and cables, anchors and axes of joints, pitches of screws, radii of
pulleys, ratios of gears, control points and weights of surfaces and curves in contact. They change as little as possible, relative to their size, so that parts that do not fit get
the lengths that fit. --out writes them where the scene has them.

Examples:
  pantin assemble assets/scenes/stewart.json --scatter 1 --out out/stewart.json
  pantin assemble assets/scenes/four_bar.json --scatter 1 --trace out/trace.csv --method gradient
  pantin assemble assets/scenes/stewart.json --scatter 1 --trials 1000
  pantin assemble assets/scenes/four_bar.json --scatter 1 --free joints/knee/anchor_b --json
  pantin assemble assets/scenes/marionette.json --scatter 0.3 --video out/assembled.mp4

--out writes the scene with "poses", in full precision; it loads and checks. --trace writes
iteration, seconds (CPU time), residual (the largest, m or rad), merit (half the weighted sum of
squares) and damping, one row an iteration.

--json prints scene, title, status, method, tolerance, residual, iterations, restarts,
perturbations, seed, turned_over (bodies turned off a spurious branch), brought_into_contact,
bodies, rows, rank, mobility (degrees of freedom left), moved_m, turned_rad, seconds, design (of,
law, before, after, at_bound, in_file), residuals, redundant, wrong_branch, at_limits and contradictory.

Exit codes: 0 assembled, 2 usage or bad input, 3 cannot be assembled, 4 could not write.)";

}  // namespace

void add_assemble(CommandLine& program) {
  auto c = std::make_shared<AssembleChoices>();
  const Subcommand command =
      program.add("assemble", "Brings the parts of a scene together, from anywhere");
  command.option("scene", c->scene, "scene file").required().type(kSceneType);
  std::string about;
  for (const Method& m : methods())
    about += fmt::format("{}{}: {}", about.empty() ? "" : "; ", m.name, m.about);
  command.option("--method", c->method, about).one_of(method_words());
  command
      .option("--jacobians", c->jacobians,
              fmt::format("of surface joints: {}; for comparison, instead of those of the scene",
                          fmt::join(jacobian_words(), ", ")))
      .one_of(jacobian_words());
  command
      .option("--tolerance", c->tolerance,
              "largest residual that counts as closed, m or rad; 1e-12 by default")
      .between(1e-15, 1);
  command
      .option("--hold", c->hold,
              "name of a body that stays where it is, or of a chain or instance; may be repeated")
      .type("NAME")
      .one_at_a_time();
  command
      .option("--free", c->free,
              "number that may change too: joints/3/length; besides \"free\" of the scene; may be "
              "repeated")
      .type("PATH")
      .one_at_a_time();
  command.option("--iterations", c->iterations, "at most, for one start, 400 by default")
      .within(1, 1000000);
  command
      .option("--starts", c->starts,
              "perturbed starts that are tried if the first one fails, 24 by default")
      .within(0, 1000);
  command.option("--seed", c->seed, "of perturbations and of --scatter").within(0, 2147483647);
  command
      .option("--scatter", c->scatter,
              "throw all bodies about first: random rotations, and displacements of this many m")
      .between(0, 1e6);
  command.option("--trials", c->trials, "count successes from this many random starts instead")
      .within(1, 1000000);
  command.option("--threads", c->threads, "threads for the rows of gradient methods; same result")
      .within(1, 256);
  command.option("--out", c->out, "scene file to write").type(kSceneType);
  command.option("--trace", c->trace, "CSV file of the residuals")
      .type(kFileType)
      .ends_in({".csv"});
  command.option("--frames", c->pictures.frames, "folder for pictures of the iterations")
      .type(kFolderType);
  command
      .option("--video", c->pictures.video, "film of the iterations, .mp4 or .mkv (needs ffmpeg)")
      .type(kFileType)
      .ends_in({".mp4", ".mkv"});
  command.option("--gif", c->pictures.gif, "moving picture of the iterations (needs ffmpeg)")
      .type(kFileType)
      .ends_in({".gif"});
  command.option("--strip", c->pictures.strip, "PNG file of pictures in rows, 6 x 2 by default")
      .type(kFileType)
      .ends_in({".png"});
  command.option("--strip-columns", c->pictures.strip_columns, "pictures in a row of the strip")
      .within(1, 20);
  command.option("--strip-rows", c->pictures.strip_rows, "rows of the strip").within(1, 20);
  command.option("--fps", c->pictures.fps, "frames per second; by default the scene's")
      .between(0.1, 1000.0);
  command.option("--size", c->pictures.size, "in pixels; by default the scene's")
      .type("WIDTHxHEIGHT");
  command.flag("--json", c->json, "print one JSON object instead of text");
  command.footer(kExamples);
  command.runs([c] { return assemble_scene(*c); });
}

}  // namespace pantin::program
