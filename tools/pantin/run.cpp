#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/utf8.hpp"
#include "engine/runtime/save.hpp"
#include "engine/solvers/articulated/island.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/solvers/takeover.hpp"
#include "engine/world/lamina.hpp"
#include "tools/pantin/command_line.hpp"
#include "tools/pantin/findings.hpp"
#include "tools/pantin/gltf.hpp"
#include "tools/pantin/pictures.hpp"
#include "tools/pantin/program.hpp"
#include "tools/pantin/record.hpp"
#include "tools/pantin/run_help.hpp"

namespace pantin::program {

using namespace detail;

namespace {

struct RunChoices {
  std::string scene, record, gltf, load, save;
  SceneChoices how;
  PictureChoices pictures;
  RecordChoices recorded;
  int threads = 1;
  bool hash = false, json = false, strict = false;
};

/// A lamina that switched to dynamics, or back to modes.
struct HandOver {
  double time = 0;          // s
  std::string lamina, why;  // why: "" for the switch back
};

/// The results of a run.
struct Summary {
  std::string status = "ok";
  std::uint64_t steps = 0;
  double worst_gap = 0, worst_gap_rel = 0;                  // m, fraction of the size
  double energy_start = 0, energy_end = 0, energy_max = 0;  // J
  double worst_residual = 0;                                // m, of pins and cables
  int most_sweeps = 0;
  double worst_violation = 0, worst_depth = 0;  // rad, m
  int contacts_now = 0, stops_now = 0, most_contacts = 0, most_stops = 0, most_capped = 0;
  double acceleration2 = 0;  // sum over the last second, (m/s^2)^2, of mass centres
  std::uint64_t still_samples = 0;
  std::vector<Vec3> velocities;       // of the previous step
  double energy_removed = 0;          // J, by the energy limiter
  std::uint64_t shortened_steps = 0;  // for the budget
  int left_out = 0, hurried = 0;      // islands that took no step, or followed no impacts, at most
  double given_up = 0;                // at most, of the substeps of a group
  std::uint64_t limited_steps = 0, rescued_steps = 0, allocations = 0, timed_steps = 0;
  std::vector<double> step_seconds;
  std::size_t frames = 0;
  double strip_period = 0;                             // s; 0: the strip shows the whole run
  std::uint64_t mode_switches = 0, dynamic_steps = 0;  // of laminas
  std::vector<HandOver> hand_overs;
  std::vector<Entity> taken;            // islands with another solver than requested
  std::vector<std::string> taken_over;  // messages about them
  std::string lost_body;
  double lost_time = 0, lost_gap = 0;  // s, m
  double cpu_seconds = 0;              // of all threads, in the loop
};

using Clock = std::chrono::steady_clock;

bool has_laminas(const World& world) {
  const Store<Lamina>* all = laminas_of(world);
  return all && all->size() > 0;
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Sums the accelerations of mass centres over the last second of the run, as a measure of rest.
void note_quiet(const Simulation& sim, double until, Summary& s) {
  const auto bodies = sim.world.bodies.values();
  const bool late = sim.world.time > until - 1 && s.velocities.size() == bodies.size();
  for (std::size_t i = 0; late && i < bodies.size(); ++i) {
    if (bodies[i].motion != Motion::dynamic) continue;
    const Vec3 a = (bodies[i].velocity - s.velocities[i]) / sim.settings.h;
    s.acceleration2 += glm::dot(a, a), ++s.still_samples;
  }
  s.velocities.clear();
  for (const Body& b : bodies) s.velocities.push_back(b.velocity);
}

/// Takes a step, timed without its measures, and collects its results.
StepReport timed_step(Simulation& sim, double until, Summary& s) {
  const std::uint64_t allocated = allocations();
  const Clock::time_point start = Clock::now();
  StepReport report = sim.step();
  s.step_seconds.push_back(seconds_since(start));
  if (s.steps > 0)
    s.allocations += allocations() - allocated, ++s.timed_steps;  // the first is a warm-up
  report.measures = measure(sim.world);
  const Measures& m = report.measures;
  s.worst_gap = std::max(s.worst_gap, m.worst_gap);
  s.worst_gap_rel = std::max(s.worst_gap_rel, m.worst_gap_rel);
  s.energy_end = m.energy();
  s.energy_max = std::max(s.energy_max, s.energy_end);
  s.worst_residual = std::max(s.worst_residual, report.worst_residual);
  s.most_sweeps = std::max(s.most_sweeps, report.sweeps_used);
  s.energy_removed += report.energy_removed;
  s.shortened_steps += report.shortened > 0, s.left_out = std::max(s.left_out, report.left_out);
  s.hurried = std::max(s.hurried, report.hurried);
  s.given_up = std::max(s.given_up, report.given_up);
  s.limited_steps += report.limited > 0, s.rescued_steps += report.rescued > 0;
  s.worst_violation = std::max(s.worst_violation, m.worst_violation);
  s.worst_depth = std::max(s.worst_depth, report.worst_depth);
  s.most_contacts = std::max(s.most_contacts, report.contacts);
  s.most_stops = std::max(s.most_stops, report.stops_hit);
  s.most_capped = std::max(s.most_capped, report.drives_capped);
  s.contacts_now = report.contacts, s.stops_now = report.stops_hit;
  s.mode_switches += static_cast<std::uint64_t>(report.mode_switches);
  s.dynamic_steps += report.handed_over > 0;
  if (report.lamina)
    s.hand_overs.push_back({report.time, sim.world.name_of(report.lamina), report.changed});
  note_quiet(sim, until, s);
  ++s.steps;
  return report;
}

Json to_json(const RunChoices& c, const Scene& scene, const Simulation& sim, Summary& s) {
  Json j;
  const auto links = static_cast<double>(std::max<std::size_t>(1, sim.world.links.size()));
  j["scene"] = c.scene;
  j["title"] = scene.title;
  j["status"] = s.status;
  j["solver"] = solver_in_use(sim.world);
  j["solvers"] = solvers_json(sim.world);
  j["step_s"] = scene.step;
  j["substeps"] = scene.substeps;
  j["steps"] = s.steps;
  j["simulated_s"] = sim.world.time;
  j["bodies"] = sim.world.bodies.size();
  j["joints"] = sim.world.links.size();
  j["cables"] = sim.world.cables.size();
  j["articulated_islands"] = articulated::islands_of(sim.world).size();
  j["worst_gap_m"] = s.worst_gap;
  j["worst_gap_rel"] = s.worst_gap_rel;
  j["energy_start_j"] = s.energy_start;
  j["energy_end_j"] = s.energy_end;
  j["energy_max_j"] = s.energy_max;
  const double median = percentile(s.step_seconds, 0.5), p99 = percentile(s.step_seconds, 0.99);
  j["ns_per_link_step_median"] = 1e9 * median / links;
  j["ns_per_link_step_p99"] = 1e9 * p99 / links;
  j["frame_ms_median"] = 1e3 * median;
  j["frame_ms_p99"] = 1e3 * p99;
  j["allocations_per_step"] =
      s.timed_steps ? static_cast<double>(s.allocations) / static_cast<double>(s.timed_steps) : 0.0;
  j["hash"] = hex(state_hash(sim.world));
  j["frames_written"] = s.frames;
  j["cpu_ms_per_frame"] = s.frames ? 1e3 * s.cpu_seconds / static_cast<double>(s.frames) : 0.0;
  j["worst_residual_m"] = s.worst_residual;
  j["sweeps_max"] = s.most_sweeps;
  j["budget_ms"] = scene.budget_ms;
  j["shortened_steps"] = s.shortened_steps;
  j["given_up_max"] = s.given_up;
  j["left_out_max"] = s.left_out;
  j["hurried_max"] = s.hurried;
  j["limited_steps"] = s.limited_steps;
  j["energy_removed_j"] = s.energy_removed;
  j["rescued_steps"] = s.rescued_steps;
  j["contacts"] = s.contacts_now;
  j["contacts_max"] = s.most_contacts;
  j["contact_depth_m"] = s.worst_depth;
  j["limit_hits"] = s.stops_now;
  j["limit_hits_max"] = s.most_stops;
  j["limit_violation_rad"] = s.worst_violation;
  j["drives_capped_max"] = s.most_capped;
  j["final_acceleration_rms"] =
      s.still_samples ? std::sqrt(s.acceleration2 / static_cast<double>(s.still_samples)) : 0.0;
  j["unreached"] = Json::array();
  for (const Unreached& u : unreached(sim.world))
    j["unreached"].push_back({{"name", u.name},
                              {"kind", u.kind},
                              {"residual_m", u.residual},
                              {"reachable", u.reachable}});
  for (const lagrangian::Island& m : lagrangian::islands_of(sim.world)) {
    Json one = {{"bodies", m.count()},        {"integrator", name_of(m.settings.integrator)},
                {"equations", m.equations()}, {"rank", m.rank},
                {"redundant", Json::array()}, {"residual", m.residual},
                {"substeps", m.substeps}};
    for (const lagrangian::Fault& f : m.faults)
      if (f.kind == lagrangian::Fault::redundant)
        one["redundant"].push_back(
            {{"joint", sim.world.name_of(lagrangian::joint_of(sim.world, m.blocks[f.block]))},
             {"rows", f.rows}});
    j["lagrangian_islands"].push_back(one);
  }
  if (has_laminas(sim.world)) {
    j["mode_switches"] = s.mode_switches;
    j["steps_by_dynamics"] = s.dynamic_steps;
    j["hand_overs"] = Json::array();
    for (const HandOver& h : s.hand_overs)
      j["hand_overs"].push_back({{"time_s", h.time},
                                 {"lamina", h.lamina},
                                 {"to", h.why.empty() ? "modes" : "dynamics"},
                                 {"why", h.why}});
  }
  if (!s.lost_body.empty())
    j["lost"] = {{"body", s.lost_body}, {"time_s", s.lost_time}, {"residual_m", s.lost_gap}};
  j["taken_over"] = s.taken_over;
  j["beyond_auto"] = lines_beyond_auto(sim.world);
  j["findings"] = findings_json(sim.world, sim.findings());
  j["energy_unchecked"] = unchecked_bodies(sim);
  j["sensors"] = sensors_json(scene, sim.world);
  j["warnings"] = scene.warnings;
  return j;
}

/// Notes each island once, with its first message.
void note_takeovers(const World& world, Summary& s) {
  const std::vector<Takeover>& now = world.memory.of<Takeovers>().list;
  const auto is_known = [&](const Takeover& t) {
    return std::find(s.taken.begin(), s.taken.end(), t.body) != s.taken.end();
  };
  if (std::all_of(now.begin(), now.end(), is_known)) return;
  const std::vector<std::string> lines = takeover_lines(world);
  for (std::size_t i = 0; i < std::min(now.size(), lines.size()); ++i)
    if (!is_known(now[i])) s.taken.push_back(now[i].body), s.taken_over.push_back(lines[i]);
}

void print_hand_overs(const Summary& s) {
  constexpr std::size_t kMostTold = 6;
  fmt::print("  modes       {} switches; dynamics moved laminas in {} of {} steps\n",
             s.mode_switches, s.dynamic_steps, s.steps);
  for (std::size_t i = 0; i < std::min(kMostTold, s.hand_overs.size()); ++i) {
    const HandOver& h = s.hand_overs[i];
    fmt::print("  at {:<9} {} {}\n", fmt::format("{:.4g} s", h.time), printable(h.lamina),
               h.why.empty() ? "moves by modes again" : "is left to dynamics: " + h.why);
  }
  if (s.hand_overs.size() > kMostTold)
    fmt::print("              and {} more, see --json\n", s.hand_overs.size() - kMostTold);
}

void print_summary(const RunChoices& c, const Scene& scene, const Simulation& sim, Summary& s) {
  const Json j = to_json(c, scene, sim, s);
  fmt::print("{}\n", bold(scene.title));
  fmt::print("  solver      {}, {} steps of {:.6g} s\n", describe_solvers(sim.world), s.steps,
             scene.step);
  fmt::print("  bodies      {} with {} joints, {} cables\n", sim.world.bodies.size(),
             sim.world.links.size(), sim.world.cables.size());
  fmt::print("  worst gap   {:.2e} m, {:.1e} of the size\n", s.worst_gap, s.worst_gap_rel);
  const std::size_t unchecked = unchecked_bodies(sim);
  fmt::print("  energy      {:.6g} J to {:.6g} J, at most {:.6g} J{}\n", s.energy_start,
             s.energy_end, s.energy_max,
             unchecked ? fmt::format("; not balanced for {} bodies", unchecked) : "");
  fmt::print("  time        {:.4f} ms per step (p99 {:.4f}), {:.0f} ns per link and step\n",
             j["frame_ms_median"].get<double>(), j["frame_ms_p99"].get<double>(),
             j["ns_per_link_step_median"].get<double>());
  for (const Unreached& u : unreached(sim.world))
    fmt::print("  unreached   {} {}: {:.4g} m from its target{}\n", u.kind, printable(u.name),
               u.residual, u.reachable ? "" : ", out of reach");
  if (s.shortened_steps > 0)
    fmt::print("  budget      substeps were left out in {} steps, at most {:.0f} % of a group's\n",
               s.shortened_steps, 100 * s.given_up);
  if (s.left_out + s.hurried > 0)
    fmt::print("  budget      up to {} islands at once took longer steps, {} followed no impacts\n",
               s.left_out, s.hurried);
  if (s.limited_steps > 0)
    fmt::print("  limited     {:.6g} J of energy were removed, in {} steps\n", s.energy_removed,
               s.limited_steps);
  if (s.rescued_steps > 0)
    fmt::print("  rescued     {} steps failed in the integrator and fell back to Euler's method\n",
               s.rescued_steps);
  if (has_laminas(sim.world)) print_hand_overs(s);
  for (const std::string& line : s.taken_over) fmt::print("  taken over  {}\n", printable(line));
  for (const std::string& line : lines_beyond_auto(sim.world))
    fmt::print("  beyond auto {}\n", printable(line));
  print_findings(sim);
  if (s.strip_period > 0) fmt::print("  strip       the last period of {:.6g} s\n", s.strip_period);
  if (s.frames > 0)
    fmt::print("  frames      {}, {:.1f} ms of CPU each, steps and writing included\n", s.frames,
               j["cpu_ms_per_frame"].get<double>());
  if (c.hash) fmt::print("  hash        {}\n", j["hash"].get<std::string>());
}

int fail(const std::vector<Error>& errors, int exit_code) {
  for (const Error& e : errors) complain(e.message);
  return exit_code;
}

/// The state of a run.
struct Run {
  const RunChoices& choices;
  const Scene& scene;
  Simulation& sim;
  Summary& summary;
};

/// What a run writes while it goes on; null: not that.
struct Writers {
  Pictures* pictures;
  Record* record;
  GltfFilm* gltf;
};

/// The loop: step, record, draw. Stores the reason for its end in the summary; returns the exit
/// code.
int step_through(const Run& run, const Writers& writers) {
  const auto& [c, scene, sim, s] = run;
  const auto& [pictures, record, gltf] = writers;
  const std::uint64_t steps = steps_of(scene);
  s.step_seconds.reserve(steps);
  Progress progress(scene.title);
  // A row that could not be written is reported when the record is closed.
  const Real until = sim.world.time + scene.duration;
  const auto write_row = [&](const Measures& m) -> bool {
    if (writers.gltf && !writers.gltf->add(run.sim.world)) return false;
    return !writers.record || static_cast<bool>(writers.record->add(run.sim.world, m));
  };
  if (record) compile_if_changed(sim.world);  // the first row needs all columns
  if (gltf) gltf->start(sim.world, scene.title);
  if (!write_row(measure(sim.world))) return kUnwritable;
  for (std::uint64_t i = 0; i < steps; ++i) {
    if (interrupted()) {
      s.status = "interrupted";
      return kInterrupted;
    }
    if (pictures) pictures->before_step(sim.world);
    const StepReport report = timed_step(sim, until, s);
    note_takeovers(sim.world, s);
    if (report.status == Status::diverged) {
      s.status = "diverged";
      s.lost_body = sim.world.name_of(report.body), s.lost_time = report.time;
      s.lost_gap = report.residual;
      complain(
          fmt::format("{}: diverged at {:.6g} s: body {} could not continue or left all bounds "
                      "(worst joint gap {:.3g} m)",
                      c.scene, report.time, s.lost_body, s.worst_gap));
      return kDiverged;
    }
    if (report.status == Status::aborted) {
      s.status = "aborted";
      complain(fmt::format("{}: aborted at {:.6g} s: memory ran out", c.scene, report.time));
      return kFailed;
    }
    if (report.status == Status::contact_lost) {
      s.status = "contact_lost";
      s.lost_body = sim.world.name_of(report.body), s.lost_time = report.time;
      complain(fmt::format("{}: contact lost at {:.6g} s: {}", c.scene, report.time,
                           words_of_lost_contact(sim.world, report)));
      return kDiverged;
    }
    if (report.status == Status::energy_grew) {
      s.status = "energy_grew";
      s.lost_body = sim.world.name_of(report.body), s.lost_time = report.time;
      s.lost_gap = report.measures.worst_gap;
      complain(
          fmt::format("{}: energy grew severalfold without work at {:.6g} s, from {:.4g} J to "
                      "{:.4g} J: body {}; the solver \"{}\" does not keep it",
                      c.scene, report.time, s.energy_start, s.energy_end, s.lost_body,
                      solver_in_use(sim.world)));
      return kDiverged;
    }
    if (report.status == Status::inconsistent) {
      s.status = "inconsistent";
      complain(fmt::format("{}: inconsistent at {:.6g} s: {}", c.scene, report.time,
                           words_of_inconsistency(sim.world, report)));
      return kDiverged;
    }
    if (!write_row(report.measures)) return kUnwritable;
    if (pictures && !pictures->after_step(sim.world, report.measures.worst_gap)) return kUnwritable;
    progress.show(static_cast<double>(i + 1) / static_cast<double>(steps));
  }
  return kOk;
}

int run(const RunChoices& c) {
  std::string idle = c.pictures.idle_option();
  if (c.record.empty() && (!c.recorded.columns.empty() || c.recorded.digits > 0))
    idle = fmt::format("{}: found no record to write, expected --record with it",
                       c.recorded.columns.empty() ? "--digits" : "--columns");
  const bool is_piped = c.record == "-";  // standard output has nothing else then
  if (is_piped && c.json) idle = "--json: found --record - with it, expected one of them";
  if (!idle.empty()) {
    complain(idle);
    return kUsage;
  }
  std::optional<Scene> scene = open_scene(c.scene, c.how);
  if (!scene) return kUsage;
  if (!c.json) print_warnings(*scene);
  if (!c.load.empty()) {
    Result<World> loaded = load_world(c.load);
    if (!loaded) return fail(loaded.errors(), kUsage);
    scene->world = std::move(*loaded);
  }
  Record record;
  if (!c.record.empty())
    if (const auto fits = record.check(
            scene->world, {c.recorded.columns, c.recorded.digits, scene->step, scene->sensors});
        !fits)
      return fail(fits.errors(), kUsage);
  std::unique_ptr<Pictures> pictures;
  if (c.pictures.wanted()) {
    auto opened = Pictures::open(c.pictures, *scene, steps_of(*scene));
    if (auto* f = std::get_if<PictureFailure>(&opened)) return fail(f->errors, f->exit_code);
    pictures = std::move(std::get<0>(opened));
  }
  if (!c.record.empty())
    if (const auto opened = record.open(is_piped ? "/dev/stdout" : c.record); !opened)
      return fail(opened.errors(), kUnwritable);

  if (c.threads > 1 && !has_threads())
    complain("--threads: this build has one thread (built without oneTBB); continuing with it");
  StepSettings how = settings_of(*scene, c.threads);
  how.watch = true;
  Simulation sim = Simulation::copy_of(scene->world, how);
  Summary s;
  s.energy_start = s.energy_max = measure(sim.world).energy();
  const double cpu_before = cpu_seconds();
  GltfFilm gltf;
  int exit_code = step_through(
      {c, *scene, sim, s},
      {pictures.get(), c.record.empty() ? nullptr : &record, c.gltf.empty() ? nullptr : &gltf});
  if (!c.gltf.empty())
    if (const auto written = gltf.write(c.gltf); !written)
      exit_code = fail(written.errors(), kUnwritable);
  if (!c.record.empty()) {
    const auto closed = record.close();
    if (!closed)
      exit_code = fail(closed.errors(), kUnwritable);
    else if (exit_code == kInterrupted)
      complain(c.record + ": contains the steps up to the interruption");
  }
  if (pictures) {
    const auto finished = pictures->finish();
    if (const auto* f = std::get_if<PictureFailure>(&finished))
      exit_code = fail(f->errors, f->exit_code);
    else
      s.frames = std::get<std::size_t>(finished), s.strip_period = pictures->strip_period();
  }
  s.cpu_seconds = cpu_seconds() - cpu_before;
  if (exit_code == kOk && !sim.findings().empty()) {
    s.status = "doubtful";
    if (c.strict) exit_code = kDiverged;
  }
  if (!c.save.empty() && (exit_code == kOk || s.status == "doubtful"))
    if (const auto saved = save_world(sim.world, c.save); !saved)
      exit_code = fail(saved.errors(), kUnwritable);
  if (exit_code == kUnwritable) s.status = "unwritable";
  if (c.json)
    print_json(to_json(c, *scene, sim, s));
  else if (!is_piped)
    print_summary(c, *scene, sim, s);
  return exit_code;
}

}  // namespace

void add_run(CommandLine& program) {
  auto c = std::make_shared<RunChoices>();
  const Subcommand command = program.add("run", "Runs a scene; writes frames, video, a record");
  command.option("scene", c->scene, "scene file, - for standard input").required().type(kSceneType);
  add_scene_choices(command, c->how);
  add_threads(command, c->threads);
  command
      .option("--record", c->record,
              "CSV file, .npz for numpy, - for standard output: poses, velocities, gaps, energy, "
              "momentum")
      .type(kFileType);
  command
      .option("--gltf", c->gltf,
              "glTF model, .glb, with a node for each body that moves as the run does")
      .type("FILE:.glb");
  command
      .option("--columns", c->recorded.columns,
              "of the record: names with * and ?, separated by commas; also readings of joints "
              "(angle, travel, speeds, reaction), cables, pins, contacts")
      .separated_by(',')
      .type("NAMES")
      .one_at_a_time();
  command.option("--digits", c->recorded.digits, "significant digits of the record; by default all")
      .within(1, 17);
  command
      .option("--load", c->load, "continues from a state written by --save, with this scene's step")
      .type(kFileType);
  command.option("--save", c->save, "file for the final state, to continue from with --load")
      .type(kFileType);
  add_picture_options(command, c->pictures);
  command.flag("--hash", c->hash, "print the 64-bit hash of the final state");
  command.flag("--strict", c->strict, "exit code 3 where there are findings");
  command.flag("--json", c->json, "print one JSON object instead of text");
  command.footer(kRunFooter);
  command.runs([c] { return run(*c); });
}

}  // namespace pantin::program
