#pragma once
// Options and results of a viewer session.
#include <string>
#include <vector>

#include "engine/scene/scene.hpp"
#include "tools/pantin/view_desk.hpp"
#include "tools/pantin/view_script.hpp"

namespace pantin::program {

using namespace detail;

struct SessionChoices {
  std::string frames = ".";  // folder for pictures and films
  std::string gl = "auto";
  int width = 1280, height = 720;  // of the window, pixels
  double duration = 0;             // s, simulated; 0: until the window is closed
  bool is_scripted = false;
  bool has_panel = false;  // from the start
  std::vector<ScriptEvent> script;
  DeskChoices desk;  // its size follows from the window's
};

/// The results of a session. Scene, solver, steps and drags are those of the first pane.
struct SessionReport {
  std::string status = "ok";  // ok, diverged, energy_grew, interrupted, failed, unwritable
  std::string scene, title, solver, beside, driver, gl;
  double step = 0;                      // s
  std::uint64_t frames = 0, steps = 0;  // drawn; taken, including restarts
  int restarts = 0;
  bool is_paused = false, has_panel = false;  // the panel was visible at the end
  bool is_posing = false;                     // pose mode, at the end
  double speed = 1, time = 0;                 // time: s, simulated since the last restart
  double worst_gap = 0, worst_gap_rel = 0;    // m, fraction of the size
  double frames_a_second = 0;                 // drawn, per second of wall time; 0 with a script
  std::uint64_t hash = 0;
  std::vector<Drag> drags;
  std::vector<Plotted> plots;
  std::vector<std::string> saved, notes, findings, warnings;
  int exit_code = 0;
};

/// Shows a scene until the window is closed or the script has ended. Errors go to stderr.
SessionReport show(Scene scene, SessionChoices choices);

}  // namespace pantin::program
