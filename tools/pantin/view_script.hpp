#pragma once
// A file of mouse and key events that simulates a user.
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

enum class Act : std::uint8_t {
  mouse_down,
  mouse_move,
  mouse_up,
  wheel,
  key,
  knob,    // sets a knob
  open,    // opens another scene
  resize,  // of the window
  quit
};

/// The position of the mouse at an event.
enum class Spot : std::uint8_t {
  same,   // unchanged
  pixel,  // at x, y
  shift,  // moved by x, y
  body    // at the pixel of a body's point
};

struct ScriptEvent {
  double time = 0;  // s, from the start of the run
  Act act = Act::quit;
  Spot spot = Spot::same;
  double x = 0, y = 0;    // pixels; the wheel's clicks, sideways in x; a knob's value in x
  Vec3 at{0};             // in the body's own frame
  bool is_centre = true;  // the mass centre instead of `at`
  int button = 0;         // index in kButtons
  bool shift = false, alt = false;  // the keys are held
  std::size_t key = 0;              // index in kKeys
  std::string name;                 // of a knob, of a body, of a scene file
};

inline constexpr std::string_view kButtons[]{"left", "middle", "right"};
/// Reads a script, and looks up its bodies in a World. Errors are lines as for scene files.
Result<std::vector<ScriptEvent>> load_script(const std::string& path, const World& world);

}  // namespace pantin::program
