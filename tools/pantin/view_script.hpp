#pragma once
// A file of mouse and key events that stands for a user's hands.
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

enum class Act : std::uint8_t { mouse_down, mouse_move, mouse_up, wheel, key, quit };

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
  double x = 0, y = 0;  // pixels; the wheel's clicks in y
  Entity body;
  Vec3 at{0};             // in the body's own frame
  bool is_centre = true;  // the mass centre instead of `at`
  int button = 0;         // place in kButtons
  bool shift = false;     // the key is held
  std::size_t key = 0;    // place in kKeys
};

inline constexpr std::string_view kButtons[]{"left", "middle", "right"};
/// Names of the keys that mean something, as scripts spell them.
inline constexpr std::string_view kKeys[]{"space", ".", "[", "]", "1", "2", "3",     "4",
                                          "5",     "o", "r", "s", "h", "q", "escape"};

/// Reads a script against the bodies of a world. Complaints are lines as of scene files.
Result<std::vector<ScriptEvent>> load_script(const std::string& path, const World& world);

}  // namespace pantin::program
