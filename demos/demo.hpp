#pragma once
// What the example programs share: arguments, the loop, and the line they print.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <pantin/pantin.hpp>
#include <pantin/scene.hpp>
#include <string>
#ifdef PANTIN_HAS_RENDER
#include <pantin/render.hpp>
#endif

namespace pantin::demos {

/// Reads a scene of assets/scenes, or ends the program with the loader's complaints.
inline Scene load(const std::string& name) {
  Result<Scene> scene = load_scene(std::string(PANTIN_ASSETS "/scenes/") + name + ".json");
  if (scene) return std::move(*scene);
  for (const Error& e : scene.errors()) std::fprintf(stderr, "%s\n", e.message.c_str());
  std::exit(2);
}

/// What happens besides the steps: called before each step with its number.
using Script = std::function<void(Simulation&, int)>;

struct Outcome {
  std::uint64_t hash = 0;
  Real worst_gap = 0;        // part of the island's size
  Real worst_violation = 0;  // rad, of what joints allow
  Real worst_depth = 0;      // m, at contacts
  Real worst_residual = 0;   // m, of pins, cables and loops
  bool sound = true;         // every step could be taken
  StepReport last;           // of the last step
};

/// Numbers found at the end of a demo beside those expected.
struct Findings {
  std::string text;  // a line each
  bool as_expected = true;

  void expect(const char* what, Real found, Real least, Real most) {
    const bool good = found >= least && found <= most;
    char line[200];
    std::snprintf(line, sizeof line, "%s%s: found %.6g, expected %.6g to %.6g\n",
                  good ? "  " : "FAILED: ", what, found, least, most);
    text += line;
    as_expected = as_expected && good;
  }
};

/// What must hold when a demo has run for its whole duration.
using Check = std::function<void(const World&, const Outcome&, Findings&)>;

/// What a demo may add to its scene.
struct Extras {
  Check check = {};
  bool joints = false;                         // mark joints and their ranges in pictures
  int columns = 4, width = 360, height = 300;  // of the strip, and pixels of each of its pictures
  Real last_picture = 0;                       // s; 0: at the end
};

/// A scene with what happens in it, by the name of its program.
struct Demo {
  const char* name;
  const Scene& scene;
  Script script = {};
  Extras extras = {};
};

/// Sees the World before the first step and after every step.
using Watcher = std::function<void(const World&, int)>;

inline Outcome play(const Scene& scene, int steps, const Script& script,
                    const Watcher& watch = {}) {
  Simulation sim(scene.world, {scene.step, scene.substeps, 1, true});
  Outcome done;
  if (watch) watch(sim.world, 0);
  for (int i = 0; i < steps && done.sound; ++i) {
    if (script) script(sim, i);
    const StepReport report = sim.step();
    done.worst_gap = std::max(done.worst_gap, report.measures.worst_gap_rel);
    done.worst_violation = std::max(done.worst_violation, report.measures.worst_violation);
    done.worst_depth = std::max(done.worst_depth, report.worst_depth);
    done.worst_residual = std::max(done.worst_residual, report.worst_residual);
    done.sound = report.status == Status::ok;
    done.last = report;
    if (watch) watch(sim.world, i + 1);
  }
  done.hash = state_hash(sim.world);
  return done;
}

/// Plays a demo and leaves pictures of it side by side in a PNG. Returns the exit code.
inline int draw_strip(const Demo& demo, int steps, const std::string& path) {
#ifdef PANTIN_HAS_RENDER
  const Scene& scene = demo.scene;
  const Extras& extras = demo.extras;
  auto renderer = Renderer::create({extras.width, extras.height});
  if (!renderer) {
    for (const Error& e : renderer.errors()) std::fprintf(stderr, "%s\n", e.message.c_str());
    return 1;
  }
  View view = scene.view;
  if (view.camera.automatic)
    view.camera = framing_camera(scene.world, view, Real(extras.width) / extras.height);
  Strip strip(extras.columns, 1, extras.width, extras.height);
  Image image;
  play(scene, steps, demo.script, [&](const World& world, int step) {
    const auto frames = static_cast<std::size_t>(steps) + 1;
    if (strip.filled() == strip.cells() ||
        strip.frame_of(strip.filled(), frames) != static_cast<std::size_t>(step))
      return;
    Overlay overlay;
    char time[32];
    std::snprintf(time, sizeof time, "t = %.2f s", world.time);
    overlay.lines = {time};
    overlay.joints = extras.joints;
    (*renderer)->draw({.world = world, .view = view, .overlay = &overlay}, image);
    strip.add(image);
  });
  const Result<Done> written = write_png(path, strip.image());
  if (written) return 0;
  std::fprintf(stderr, "%s\n", written.errors().front().message.c_str());
  return 4;
#else
  static_cast<void>(demo), static_cast<void>(steps);
  std::fprintf(stderr, "%s: this build has no pictures\n", path.c_str());
  return 1;
#endif
}

/// Plays a demo, for its whole duration or for `--steps N`, and prints how it went. With --steps
/// it is played twice: the second time must end in the same bits. Without, the extras' check is
/// made at the end. Returns the exit code.
inline int run(int argc, char** argv, const Demo& demo) {
  const Scene& scene = demo.scene;
  int steps = static_cast<int>(std::lround(scene.duration / scene.step));
  const bool twice = argc == 3 && std::strcmp(argv[1], "--steps") == 0;
  const bool draw = argc == 3 && std::strcmp(argv[1], "--strip") == 0;
  if (argc != 1 && !twice && !draw) {
    std::fprintf(stderr, "usage: %s [--steps N | --strip F.png]\n", argv[0]);
    return 2;
  }
  if (draw && demo.extras.last_picture > 0)
    steps = static_cast<int>(std::lround(demo.extras.last_picture / scene.step));
  if (draw) return draw_strip(demo, steps, argv[2]);
  if (twice) steps = std::atoi(argv[2]);
  if (steps < 1) {
    std::fprintf(stderr, "%s: found --steps %s, expected a number from 1\n", argv[0], argv[2]);
    return 2;
  }
  World end;
  const Outcome first = play(scene, steps, demo.script, [&](const World& w, int step) {
    if (step == steps) end = w;
  });
  const bool stable = !twice || play(scene, steps, demo.script).hash == first.hash;
  const bool tight = first.worst_gap <= scene.drift_bound;
  std::printf("%-12s %5d steps  %4zu bodies  worst joint gap %.1e of size  hash %016llx%s%s%s\n",
              demo.name, steps, scene.world.bodies.size(), first.worst_gap,
              static_cast<unsigned long long>(first.hash), first.sound ? "" : "  DIVERGED",
              tight ? "" : "  DRIFTED", stable ? "" : "  NOT REPEATABLE");
  Findings findings;
  if (demo.extras.check && !twice && first.sound) demo.extras.check(end, first, findings);
  std::printf("%s", findings.text.c_str());
  return first.sound && tight && stable && findings.as_expected ? 0 : 3;
}

}  // namespace pantin::demos
