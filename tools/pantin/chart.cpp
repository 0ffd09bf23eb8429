#include "tools/pantin/chart.hpp"

#include <fmt/format.h>

#include <memory>

#include "engine/base/atomic_file.hpp"
#include "tools/pantin/command_line.hpp"

namespace pantin::program {
namespace {

int complain_of(const std::vector<Error>& errors, int exit_code) {
  for (const Error& e : errors) print_error(e.message);
  return exit_code;
}

int chart(const ChartChoices& c) {
  if (!c.against.empty() && c.scenes.size() > 1) {
    complain("--against: found " + std::to_string(c.scenes.size()) +
             " scenes, expected the one that the file belongs to");
    return kUsage;
  }
  if (!c.peers.empty())  // before anything is measured
    if (const auto read = read_peers(c.peers, ""); !read) return complain_of(read.errors(), kUsage);
  if (const auto made = make_folder(c.out); !made) return complain_of(made.errors(), kUnwritable);
  Journal journal;
  if (const auto opened = journal.open(
          c.out + "/runs.jsonl", c.afresh ? Journal::Earlier::discarded : Journal::Earlier::kept);
      !opened)
    return complain_of(opened.errors(), kUnwritable);
  Json all = build_and_machine();
  all["cost"] = "CPU time of the steps, ns for each dynamic body and simulated second";
  all["scenes"] = Json::array();
  for (const std::string& path : c.scenes) {
    Result<Json> scene = chart_scene(path, c, journal);
    if (interrupted()) {
      complain("interrupted; the same command goes on from here");
      return kInterrupted;
    }
    if (!scene) return complain_of(scene.errors(), kUsage);
    if (!c.peers.empty()) {
      Result<Json> peers = read_peers(c.peers, path);
      if (!peers) return complain_of(peers.errors(), kUsage);
      add_peers(*scene, std::move(*peers));
    }
    if (!c.json) print_chart(*scene);
    all["scenes"].push_back(std::move(*scene));
  }
  const std::string text = all.dump(1, ' ', true, Json::error_handler_t::replace) + "\n";
  if (const int code = write_or_complain(c.out + "/chart.json", text); code != kOk) return code;
  if (const int code = write_or_complain(c.out + "/chart.csv", chart_csv(all)); code != kOk)
    return code;
  if (c.json) print_json(all);
  const bool drawn = draw_results("chart", c.out);
  if (!c.json) fmt::print("{}/{}chart.json, chart.csv\n", c.out, drawn ? "index.html, " : "");
  return kOk;
}

constexpr const char* kExamples =
    R"(Runs scenes under every solver and integrator that applies, over a ladder of steps, and charts
what each run costs against its error. The motion of reference is a run that is refined until it
agrees with itself, or with --against a file, for instance of a closed form; a scene that has one,
as exact/NAME.csv beside it (tools/exact), is measured against that. Runs that fail or are
refused are in the chart, too. All files are in the folder of --out: chart.json and chart.csv with
all numbers, a picture of each scene (.svg, .png) and index.html with all of them, drawn by
python3 with matplotlib. Interrupted, the same command goes on where it was.

Examples:
  pantin chart assets/scenes/chain10.json --time 5 --rungs 3
  pantin chart assets/scenes/chain10.json --methods auto,lagrangian/rk4 --duration 1 --time 5
  pantin chart assets/scenes/pendulum.json --coarsest 0.05 --rungs 5 --time 5 --json

Error: the greatest distance of any point of a body from the reference, m: of its mass centre, plus
the angle between its rotations times its radius (to the farthest point of its shapes; without shapes,
the radius of gyration). A file without rotations has its positions compared alone. It is looked at
after every step, at 200 times or more (samples; of a file, at its rows); of a body that moves so fast
that a cubic between the steps misses a tenth of its way, also between them. Orientation (rad), the
origins of the bodies' frames alone (m) and energy (J) likewise; joints and contact depth: the greatest
gap and overlap after any step. The reference's own error is the difference of its last two
refinements; that of a file is unknown. Where refinements part by more than 1e-4 of the size of the
motion, as chaotic motions do (horizon_s), errors are those of the first half of the time until then
(compared_s); unseen_event_s is an event after that. A run follows the reference while it is within
1e-2 of the size (follows_s). Size: the diagonal of the box around all positions, or the diameter of
the largest body if that is longer. Cost: CPU time of the steps alone, ns for each dynamic body and
simulated second, without the first step of a run, in place of which one more is timed at its end;
median, least and greatest of the rounds, each of which times all runs.

--peers draws other engines, too, from a file that tools/peers/motion writes for the same scene and
duration: the same errors at its own times, CPU time of the steps. Rows of other scenes are left out.
The best choices (front) are then those of all, by the errors of origins, which alone are known there.

--json prints chart.json: the build and machine, and scenes; a scene has scene, title, bodies,
joints, duration_s, samples, substeps, own_solver, own_step_s, size_m, real_time_ns,
tenth_of_frame_ns (costs at which it runs in real time, and in a tenth of a frame of 60 Hz),
reference, refused (method, reason) and runs; a run has method, step_s, tolerance, status, reason,
ended_at_s, follows_s, position_m, origin_m, orientation_rad, energy_j, joints_m, depth_m, steps, factorisations,
iterations, substeps, sweeps, unsolved_steps, rescued_steps, findings, cost_ns, cost_low_ns,
cost_high_ns, rounds, cost_measured_ns, front (no other run is better in cost and error). With --peers also peers: runs of other engines.

Exit codes: 0 ok, 2 usage or bad input, 4 could not write, 130 interrupted.)";

}  // namespace

void add_chart(CommandLine& program) {
  auto c = std::make_shared<ChartChoices>();
  std::vector<std::string> names;
  for (const Method& method : all_methods()) names.push_back(method.name);
  const Subcommand command =
      program.add("chart", "Charts cost against error for every way to run a scene");
  command.option("scene", c->scenes, "scene files").required().type(kSceneType);
  command.option("--out", c->out, "folder of all results; default out/chart").type(kFolderType);
  command.option("--methods", c->methods, "these only, commas between")
      .separated_by(',')
      .one_of(names)
      .one_at_a_time();
  command
      .option("--against", c->against, "CSV file with the exact motion, as run --record writes it")
      .type(kFileType)
      .ends_in({".csv"});
  command
      .option("--peers", c->peers,
              "CSV file of tools/peers/motion: other engines on the same scenes")
      .type(kFileType)
      .ends_in({".csv"});
  command.option("--coarsest", c->coarsest, "the longest step, s; default: twice that of the scene")
      .between(1e-6, 1.0);
  command.option("--rungs", c->rungs, "number of steps, each half of the one before; default 6")
      .within(1, 20);
  command.option("--duration", c->duration, "simulated seconds").between(1e-6, 1e6);
  command.option("--repeat", c->repeat, "rounds of timing; default 3").within(1, 1000);
  command.option("--time", c->time, "seconds for each scene; default 60").between(0.1, 1e6);
  command.flag("--afresh", c->afresh, "discard the results of earlier runs in that folder");
  command.flag("--json", c->json, "print chart.json instead of a table");
  command.footer(kExamples);
  command.runs([c] { return chart(*c); });
}

}  // namespace pantin::program
