#pragma once
// What stands in the panel.
#include "tools/pantin/view_panel.hpp"

namespace pantin::program {

/// All of it, into the window that Dear ImGui has begun.
void lay_out(Desk& desk, const PanelClock& clock);

/// Curves of what the panes have recorded; one colour for each pane.
void lay_out_plots(const Desk& desk);

}  // namespace pantin::program
