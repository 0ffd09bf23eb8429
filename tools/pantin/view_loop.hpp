#pragma once
// The session of a viewer: its loop, its keys, what it leaves behind.
#include <string>
#include <vector>

#include "engine/scene/scene.hpp"
#include "tools/pantin/view_hand.hpp"
#include "tools/pantin/view_script.hpp"

namespace pantin::program {

using namespace detail;

struct SessionChoices {
  std::string frames = ".";  // folder for saved frames
  std::string gl = "auto";
  int width = 1280, height = 720;  // pixels
  int threads = 1;
  double duration = 0;  // s, simulated; 0: until the window is closed
  bool is_scripted = false;
  std::vector<ScriptEvent> script;
};

/// What a session has to tell.
struct SessionReport {
  std::string status = "ok";  // ok, diverged, interrupted, failed, unwritable
  std::string solver, driver, gl;
  std::uint64_t frames = 0, steps = 0;  // drawn; taken, restarts included
  int restarts = 0;
  bool is_paused = false;
  double speed = 1, time = 0;               // time: s, simulated since the last restart
  double worst_gap = 0, worst_gap_rel = 0;  // m, part of the size
  std::uint64_t hash = 0;
  std::vector<Drag> drags;
  std::vector<std::string> saved, notes;
  int exit_code = 0;
};

/// Shows a scene until the window is closed or the script has ended. Complaints go to stderr.
SessionReport show(const Scene& scene, const SessionChoices& choices);

}  // namespace pantin::program
