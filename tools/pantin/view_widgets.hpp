#pragma once
// The content of the panel.
#include "tools/pantin/view_panel.hpp"

namespace pantin::program {

/// Lays out everything in the current Dear ImGui window.
void lay_out(Desk& desk, const PanelClock& clock);

/// Plots of the chosen object and of the recorded data; one colour for each pane.
void lay_out_plots(Desk& desk);

}  // namespace pantin::program
