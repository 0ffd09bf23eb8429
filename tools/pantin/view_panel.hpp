#pragma once
// The panel at the right of the window: buttons, sliders, plots, lists. Drawn by Dear ImGui if the
// build includes it; otherwise keys offer the same.
#include <SDL.h>

#include <memory>

#include "tools/pantin/view_desk.hpp"

namespace pantin::program {

using namespace detail;

inline constexpr int kPanelWidth = 320;   // pixels
inline constexpr int kLeastBeside = 320;  // narrower windows have no panel

/// Whether this build has a panel.
bool has_panel();

/// Times for the panel.
struct PanelClock {
  double passed = 0;  // s, since the previous picture
  double cost = 0;    // s, wall time of a picture; 0: not shown
};

class Panel {
 public:
  /// Null without Dear ImGui.
  static std::unique_ptr<Panel> make();
  virtual ~Panel() = default;

  /// Handles an event of the window; returns true if it is the panel's alone. The panel starts at
  /// `left`.
  virtual bool feed(const SDL_Event& event, int left) = 0;
  /// Whether it must be redrawn although nothing else has changed.
  virtual bool is_busy() const = 0;
  /// Draws over the picture of the window from `left` on, and carries out clicks.
  virtual void draw(Desk& desk, Image& window, int left, const PanelClock& clock) = 0;
};

}  // namespace pantin::program
