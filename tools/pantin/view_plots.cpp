// The plots of the panel.
#ifdef PANTIN_HAS_PANEL
#include <fmt/core.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "tools/pantin/view_widgets.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr float kHeight = 40, kSecondColumn = 160;  // pixels
constexpr ImU32 kInks[]{IM_COL32(255, 186, 73, 255), IM_COL32(96, 190, 255, 255)};
constexpr ImU32 kFaint = IM_COL32(150, 154, 162, 150), kBack = IM_COL32(24, 26, 30, 255);

/// The area of one plot.
struct Frame {
  ImVec2 low, high;  // pixels
  Span span;
  double from = 0, to = 0;  // s
};

template <class T>
void draw_curve(const Frame& frame, const Ring<T>& trace, double T::*what, ImU32 ink) {
  if (trace.size() < 2 || !(frame.to > frame.from)) return;
  std::vector<ImVec2> points;
  const auto draw = [&] {
    ImGui::GetWindowDrawList()->AddPolyline(points.data(), static_cast<int>(points.size()), ink, 0,
                                            1.5f);
    points.clear();
  };
  const double width = static_cast<double>(frame.high.x - frame.low.x);
  const double height = static_cast<double>(frame.high.y - frame.low.y) - 4;
  const double range = std::max(frame.span.high - frame.span.low, 1e-300);
  for (std::size_t i = 0; i < trace.size(); ++i) {
    if (std::isnan(trace[i].*what)) {  // a gap in the curve
      draw();
      continue;
    }
    const double across = (trace[i].time - frame.from) / (frame.to - frame.from);
    const double up = std::clamp((trace[i].*what - frame.span.low) / range, 0.0, 1.0);
    points.emplace_back(frame.low.x + static_cast<float>(across * width),
                        frame.high.y - 2 - static_cast<float>(up * height));
  }
  draw();
}

/// A plot below its name and latest values; its bounds are at the right if there is room.
Frame begin_plot(const std::string& name, Span span, const char* unit) {
  ImGui::TextUnformatted(name.c_str());
  const std::string bounds = fmt::format("{:.2g} to {:.2g} {}", span.low, span.high, unit);
  const float width = ImGui::GetContentRegionAvail().x;
  const float needs = ImGui::CalcTextSize(bounds.c_str()).x;
  if (ImGui::GetItemRectSize().x + needs + 8 < width) {
    ImGui::SameLine(ImGui::GetCursorPosX() + width - needs);
    ImGui::TextDisabled("%s", bounds.c_str());
  }
  Frame frame;
  frame.low = ImGui::GetCursorScreenPos();
  frame.high = {frame.low.x + width, frame.low.y + kHeight};
  ImGui::Dummy({width, kHeight});
  ImGui::GetWindowDrawList()->AddRectFilled(frame.low, frame.high, kBack, 3);
  frame.span = span;
  return frame;
}

/// Sets the same time range for all panes.
void set_times(Frame& frame, const Desk& desk) {
  bool any = false;
  for (const auto& pane : desk.panes) {
    if (pane->trace.size() == 0) continue;
    const double first = pane->trace[0].time, last = pane->trace.last().time;
    frame.from = any ? std::min(frame.from, first) : first;
    frame.to = any ? std::max(frame.to, last) : last;
    any = true;
  }
}

Span span_in_all(const Desk& desk, double Sample::*what) {
  Span span;
  bool any = false;
  for (const auto& pane : desk.panes) {
    if (pane->trace.size() == 0) continue;
    const Span own = span_of(pane->trace, what);
    if (!any) span = own;
    span.cover(own.low), span.cover(own.high);
    any = true;
  }
  return span;
}

std::string heading(const Desk& desk, const char* name, double Sample::*what, const char* unit) {
  std::string text = name;
  for (const auto& pane : desk.panes)
    if (pane->trace.size() > 0)
      text += fmt::format("{} {:.3g} {}", &pane == &desk.panes[0] ? ":" : " |",
                          pane->trace.last().*what, unit);
  return text;
}

void plot(const Desk& desk, const char* name, double Sample::*what, const char* unit) {
  Span span = span_in_all(desk, what);
  span.cover(0);
  Frame frame = begin_plot(heading(desk, name, what, unit), span, unit);
  set_times(frame, desk);
  for (std::size_t i = 0; i < desk.panes.size(); ++i)
    draw_curve(frame, desk.panes[i]->trace, what, kInks[i % 2]);
}

/// Kinetic and potential energy oscillate about their sum, so they are drawn faintly.
void plot_energy(const Desk& desk) {
  Span span = span_in_all(desk, &Sample::sum);
  for (double Sample::*part : {&Sample::kinetic, &Sample::potential}) {
    const Span own = span_in_all(desk, part);
    span.cover(own.low), span.cover(own.high);
  }
  Frame frame = begin_plot(heading(desk, "energy", &Sample::sum, "J"), span, "J");
  set_times(frame, desk);
  for (double Sample::*part : {&Sample::kinetic, &Sample::potential})
    draw_curve(frame, desk.panes[0]->trace, part, kFaint);
  for (std::size_t i = 0; i < desk.panes.size(); ++i)
    draw_curve(frame, desk.panes[i]->trace, &Sample::sum, kInks[i % 2]);
}

}  // namespace

namespace {

/// The same quantity of the chosen object in every pane that has it.
void plot_quantity(const Desk& desk, std::size_t index) {
  const Plotted& first = desk.panes[0]->focus.quantities()[index];
  std::vector<const Ring<Value>*> all;
  for (const auto& pane : desk.panes)
    if (index < pane->focus.quantities().size())
      all.push_back(&pane->focus.quantities()[index].values);
  Span span = span_of(*all[0], &Value::value);
  std::string head = short_name(desk.panes[0]->focus, first);
  for (const Ring<Value>* values : all) {
    if (values->size() == 0) continue;
    const Span own = span_of(*values, &Value::value);
    span.cover(own.low), span.cover(own.high);
    head += fmt::format("{} {:.4g} {}", values == all[0] ? ":" : " |", values->last().value,
                        first.reading.unit);
  }
  Frame frame = begin_plot(head, span, first.reading.unit.c_str());
  set_times(frame, desk);
  for (std::size_t i = 0; i < all.size(); ++i)
    draw_curve(frame, *all[i], &Value::value, kInks[i % 2]);
}

/// What of the chosen object is plotted, to choose from.
void lay_out_focus(Desk& desk) {
  Focus& focus = desk.panes[0]->focus;
  if (focus.name().empty()) return ImGui::TextDisabled("click a joint or a body: its plots");
  ImGui::TextUnformatted(focus.name().c_str());
  const auto& quantities = focus.quantities();
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    bool is_shown = quantities[i].is_shown;
    if (i % 2 > 0) ImGui::SameLine(kSecondColumn);
    if (ImGui::Checkbox(short_name(focus, quantities[i]).c_str(), &is_shown)) focus.toggle(i);
  }
  for (std::size_t i = 0; i < quantities.size(); ++i)
    if (quantities[i].is_shown) plot_quantity(desk, i);
}

}  // namespace

void lay_out_plots(Desk& desk) {
  lay_out_focus(desk);
  plot_energy(desk);
  plot(desk, "gap", &Sample::gap, "m");
  plot(desk, "contacts", &Sample::contact, "N");
}

}  // namespace pantin::program
#endif
