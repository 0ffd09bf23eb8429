#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "engine/base/utf8.hpp"
#include "tools/pantin/command_line.hpp"
#include "tools/pantin/program.hpp"

#ifdef PANTIN_HAS_VIEW
#include "tools/pantin/view_loop.hpp"
#endif

namespace pantin::program {

using namespace detail;

namespace {

struct ViewOptions {
  std::string scene, script, size, beside, frames = ".", gl = "auto", panel = "auto",
                                           at_end = "go_on";
  SceneChoices how;
  int threads = 1;
  bool json = false;
};

#ifdef PANTIN_HAS_VIEW

Json to_json(const Drag& d) {
  return {{"body", d.body},
          {"grip", d.grip},
          {"at_s", d.at},
          {"held_s", d.held},
          {"distance_moved_m", d.distance_moved},
          {"residual_m", d.residual},
          {"worst_residual_m", d.worst_residual},
          {"worst_elsewhere_m", d.worst_elsewhere},
          {"reachable", d.reachable}};
}

Json to_json(const Plotted& p) {
  const Span span = span_of(p.values, &Value::value);
  Json j = {{"name", p.reading.name}, {"unit", p.reading.unit}, {"samples", p.values.size()}};
  if (p.values.size() > 0) j["last"] = p.values.last().value;
  j["least"] = span.low, j["most"] = span.high;
  return j;
}

Json to_json(const SessionReport& r) {
  Json j;
  j["scene"] = r.scene;
  j["title"] = r.title;
  j["status"] = r.status;
  j["solver"] = r.solver;
  if (!r.beside.empty()) j["beside"] = r.beside;
  j["step_s"] = r.step;
  j["frames"] = r.frames;
  if (r.frames_a_second > 0) j["frames_a_second"] = r.frames_a_second;
  j["steps"] = r.steps;
  j["restarts"] = r.restarts;
  j["simulated_s"] = r.time;
  j["paused"] = r.is_paused;
  j["posing"] = r.is_posing;
  j["speed"] = r.speed;
  j["panel"] = r.has_panel;
  j["picks"] = Json::array();
  for (const Drag& d : r.drags) j["picks"].push_back(to_json(d));
  j["plots"] = Json::array();
  for (const Plotted& p : r.plots) j["plots"].push_back(to_json(p));
  j["worst_gap_m"] = r.worst_gap;
  j["worst_gap_rel"] = r.worst_gap_rel;
  j["hash"] = hex(r.hash);
  j["saved"] = r.saved;
  j["display"] = r.driver;
  j["gl"] = r.gl;
  j["notes"] = r.notes;
  j["findings"] = r.findings;
  j["warnings"] = r.warnings;
  return j;
}

void print_summary(const SessionReport& r) {
  fmt::print("{}\n", bold(r.title));
  fmt::print("  solver      {}, {} steps of {:.6g} s\n",
             r.beside.empty() ? r.solver : r.solver + " beside " + r.beside, r.steps, r.step);
  fmt::print("  frames      {}, by {} into {}{}\n", r.frames, r.gl, r.driver,
             r.frames_a_second > 0 ? fmt::format(", {:.0f} per second", r.frames_a_second) : "");
  fmt::print("  worst gap   {:.2e} m, {:.1e} of the size\n", r.worst_gap, r.worst_gap_rel);
  for (const Drag& d : r.drags) {
    fmt::print(
        "  dragged     {} ({}) at {:.3f} s for {:.3f} s, {:.4g} m far; at most {:.2e} m off{}\n",
        printable(d.body), d.grip, d.at, d.held, d.distance_moved, d.worst_residual,
        d.reachable ? "" : ", out of reach at the end");
    if (d.worst_elsewhere > 1e-3)
      fmt::print("              other pinned points moved by up to {:.3g} m\n", d.worst_elsewhere);
  }
  for (const std::string& path : r.saved) fmt::print("  saved       {}\n", path);
  for (const std::string& line : r.findings) fmt::print("  found       {}\n", line);
  for (const std::string& line : r.notes) fmt::print("  note        {}\n", printable(line));
  fmt::print("  hash        {}\n", hex(r.hash));
}

int view(const ViewOptions& o) {
  std::optional<Scene> scene = open_scene(o.scene, o.how);
  if (!scene) return kUsage;
  if (!o.json) print_warnings(*scene);
  SessionChoices choices;
  choices.width = scene->output.width, choices.height = scene->output.height;
  if (!o.size.empty() && !parse_size(o.size, choices.width, choices.height)) {
    complain(
        fmt::format("--size: found \"{}\", expected WIDTHxHEIGHT, each from 16 to 8192", o.size));
    return kUsage;
  }
  choices.frames = o.frames, choices.gl = o.gl;
  choices.desk.path = o.scene, choices.desk.threads = o.threads;
  choices.desk.load = [how = o.how](const std::string& path) { return read_scene(path, how); };
  if (!o.beside.empty()) solver_from_name(o.beside.c_str(), choices.desk.beside.emplace());
  choices.desk.at_end = static_cast<AtEnd>(std::ranges::find(kAtEnds, o.at_end) - kAtEnds);
  choices.duration = o.how.duration.value_or(0);
  choices.is_scripted = !o.script.empty();
  choices.has_panel = o.panel == "on" || (o.panel == "auto" && !choices.is_scripted);
  if (choices.is_scripted) {
    auto script = load_script(o.script, scene->world);
    if (!script) {
      for (const Error& e : script.errors()) print_error(e.message);
      return kUsage;
    }
    choices.script = std::move(*script);
  }
  SessionReport report = show(std::move(*scene), std::move(choices));
  if (report.status == "failed") return report.exit_code;
  if (!o.script.empty() && report.drags.empty()) report.notes.push_back("nothing was dragged");
  if (o.json)
    print_json(to_json(report));
  else
    print_summary(report);
  return report.exit_code;
}

#else

int view(const ViewOptions&) {
#ifdef PANTIN_HAS_RENDER
  complain("view: this build has no window: it was configured without SDL2 (PANTIN_VIEW)");
#else
  complain("view: this build cannot draw: it was configured without PANTIN_RENDER");
#endif
  return kFailed;
}

#endif

constexpr const char* kHelp =
    R"(Mouse: left drags the body under the cursor exactly, right or shift+left by a spring.
On nothing, with alt, or with the middle button, left turns the camera and right or shift moves it;
the wheel zooms, a sideways one turns.
Keys:
  space pause    . one step    [ ] slower, faster (1/16 to 4)    r restart
  1-5 solver auto, sweep, shake2, procedural, lagrangian; with shift that of the second pane
  c two solvers side by side: same scene, camera and clock
  m pose mode: bodies are dragged without dynamics, right with their rotation kept; joints, limits
    and pins hold; p holds a point; m again, space or . goes on from the pose, at rest
  k keep the poses as a scene file, pose_1.json
  x cut the joint, cable or pin under the mouse    p pin the body there, or release it
  b shoot a ball    l follow the body under the mouse
  n, or a click: plot the joint, cable, pin or body under the mouse
  g measure: the distance of two points under the mouse, with a third the angle at the second
  e front    d right    t top, with shift the opposite side    i from a corner
  home the scene's camera, or one that frames what is there
  arrows turn the camera, with shift move it    + - zoom
  o joints and contacts    f forces    w wireframe    a colours by state    tab panel    h help
  j at the end of the scene: go on, stop, loop
  u write the moved sliders into the scene file: of a joint of a prefab, a chain or a class there, for all
    that share the value
  page up, page down other scenes of the folder    f5 reload the file
  s save a picture    v start or stop a video    q or Esc quit
  y start or stop the record of a run: run_1.csv with all columns of `pantin run --record`, and
    run_1.glb, a glTF model whose nodes move; with shift from a restart to the scene's duration
A changed file is reloaded, and the camera stays; errors are shown in red. The panel has sliders for
step, gravity, motors, joint drives, springs, limits and solver settings, and plots.
Each quantity of the chosen object is a column of `pantin run --record`.

Examples:
  pantin view assets/scenes/marionette.json
  pantin view assets/scenes/chain.json --solver sweep --size 960x540
  pantin view assets/scenes/pendulum.json --beside lagrangian
  pantin view assets/scenes/marionette.json --script events.json --json

--script plays events instead of a user's, with 60 frames per simulated second and the same result
every time; it needs no display, and ends at a quit event or a second after the last one:
  [{"t": 0.5, "type": "mouse_down", "body": "pantin/hand_l", "button": "left"},
   {"t": 1.0, "type": "mouse_move", "dx": 80, "dy": -40},
   {"t": 1.5, "type": "mouse_up"},
   {"t": 2.0, "type": "key", "key": "space"},
   {"t": 3.0, "type": "quit"}]
Types: mouse_down (button left, middle or right; "shift": true, "alt": true), mouse_move, mouse_up,
wheel (dy and dx, clicks), key ("shift": true), knob (name, to: a slider of the panel; "motor NAME",
"stiffness NAME", "damping NAME", "least NAME", "most NAME" for those of a joint; of a cylindrical one
NAME.angle or NAME.travel), open (scene: a file), resize (width, height), quit. The place is x and y in pixels, or body (seen from here, its mass centre or
"at": [x, y, z] in the body's own frame), or dx and dy from the last place.

--json prints one object: scene, title, status (ok, diverged, contact_lost, energy_grew, interrupted, unwritable), solver, beside
(where there are two), step_s, frames, frames_a_second (not of a script), steps, restarts, simulated_s, paused, posing, speed, panel, picks (body, grip, at_s, held_s,
distance_moved_m, residual_m, worst_residual_m, worst_elsewhere_m of other held points, reachable),
plots (of the chosen object: name, unit, samples, last, least, most), worst_gap_m, worst_gap_rel, hash, saved, display, gl, notes, findings (of the last start, a line
each; see `pantin run --help`), warnings.

Exit codes: 0 ok, 1 no window or no OpenGL, 2 usage or bad input, 3 diverged or energy grew, 4 could not write,
130 interrupted.)";

}  // namespace

void add_view(CommandLine& program) {
  auto o = std::make_shared<ViewOptions>();
  const Subcommand command =
      program.add("view", "Shows a scene in a window, where the mouse drags bodies");
  command.option("scene", o->scene, "scene file").required().type(kSceneType);
  add_scene_choices(command, o->how);
  add_threads(command, o->threads);
  command.option("--script", o->script, "JSON file of events instead of a user's")
      .type("FILE:.json");
  command.option("--size", o->size, "in pixels; by default the scene's").type("WIDTHxHEIGHT");
  command.option("--beside", o->beside, "a second solver that runs beside the scene's own")
      .one_of(solver_words());
  command
      .option("--panel", o->panel,
              "buttons, sliders and plots: on, off, or auto: with a user, not with a script")
      .one_of({"auto", "on", "off"});
  command
      .option("--at-end", o->at_end,
              "at the end of the scene's duration: go_on, stop or loop; key j changes it")
      .one_of({"go_on", "stop", "loop"});
  command.option("--frames", o->frames, "folder for saved frames; by default this one")
      .type(kFolderType);
  command.option("--gl", o->gl, "OpenGL context: auto, surfaceless, device or osmesa")
      .one_of({"auto", "surfaceless", "device", "osmesa"});
  command.flag("--json", o->json, "print one JSON object instead of text");
  command.footer(kHelp);
  command.runs([o] { return view(*o); });
}

}  // namespace pantin::program
