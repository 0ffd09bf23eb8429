#pragma once
// The panel at the right of the window: buttons, sliders, plots, lists. Drawn by Dear ImGui where
// the build has it; without it the keys do the same.
#include <SDL.h>

#include <memory>

#include "tools/pantin/view_desk.hpp"

namespace pantin::program {

using namespace detail;

inline constexpr int kPanelWidth = 320;   // pixels
inline constexpr int kLeastBeside = 320;  // in narrower windows there is no panel

/// Whether this build has a panel.
bool has_panel();

/// What the panel is told of the time.
struct PanelClock {
  double passed = 0;  // s, since the last picture
  double cost = 0;    // s, wall time of a picture; 0: not to be shown
};

class Panel {
 public:
  /// Null without Dear ImGui.
  static std::unique_ptr<Panel> make();
  virtual ~Panel() = default;

  /// An event of the window; true if it is the panel's alone. `left` is where the panel begins.
  virtual bool feed(const SDL_Event& event, int left) = 0;
  /// Whether it must be drawn again though nothing else has changed.
  virtual bool is_busy() const = 0;
  /// Draws itself over the picture of the window from `left` on, and does what was clicked.
  virtual void draw(Desk& desk, Image& window, int left, const PanelClock& clock) = 0;
};

}  // namespace pantin::program
