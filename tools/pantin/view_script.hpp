#pragma once
// A file of mouse and key events that stands for a user's hands.
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
  knob,    // turns one
  open,    // another scene
  resize,  // the window
  quit
};

/// Where the mouse is at an event.
enum class Spot : std::uint8_t {
  same,   // where it was
  pixel,  // at x, y
  shift,  // x, y farther on
  body    // where a point of a body is seen
};

struct ScriptEvent {
  double time = 0;  // s, from the start of the run
  Act act = Act::quit;
  Spot spot = Spot::same;
  double x = 0, y = 0;    // pixels; the wheel's clicks, sideways in x; a knob's value in x
  Vec3 at{0};             // in the body's own frame
  bool is_centre = true;  // the mass centre instead of `at`
  int button = 0;         // place in kButtons
  bool shift = false, alt = false;  // the keys are held
  std::size_t key = 0;              // place in kKeys
  std::string name;                 // of a knob, of a body, of a scene file
};

inline constexpr std::string_view kButtons[]{"left", "middle", "right"};
/// Reads a script against the bodies of a world. Complaints are lines as of scene files.
Result<std::vector<ScriptEvent>> load_script(const std::string& path, const World& world);

}  // namespace pantin::program
