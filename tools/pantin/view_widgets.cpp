#ifdef PANTIN_HAS_PANEL
#include "tools/pantin/view_widgets.hpp"

#include <fmt/core.h>
#include <imgui.h>

#include <filesystem>

#include "tools/pantin/findings.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr float kNames = 138;  // pixels from the left to a slider's name

void line(const std::string& text) { ImGui::TextUnformatted(text.c_str()); }

/// A button in a row of `of` equal buttons.
bool row_button(const char* name, int of) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const float room = ImGui::GetWindowContentRegionMax().x - style.WindowPadding.x;
  return ImGui::Button(
      name,
      {(room - style.ItemSpacing.x * static_cast<float>(of - 1)) / static_cast<float>(of), 0});
}

void lay_out_time(Desk& desk, const PanelClock& clock) {
  const World& world = desk.panes[0]->world();
  line(std::filesystem::path(desk.path()).filename().string());
  std::string now = fmt::format("{:.2f} s, step {}", world.time, world.tick);
  if (clock.cost > 0) now += fmt::format(", picture {:.0f} ms", 1e3 * clock.cost);
  line(now);
  if (row_button(desk.paused || desk.is_posing() ? "Run" : "Pause", 4)) desk.key("space");
  ImGui::SameLine();
  if (row_button("Step", 4)) desk.single_step();
  ImGui::SameLine();
  if (row_button("Restart", 4)) desk.restart();
  ImGui::SameLine();
  if (row_button("Reload", 4)) desk.reload();
  ImGui::SetNextItemWidth(kNames);
  auto speed = static_cast<float>(desk.speed);
  if (ImGui::SliderFloat("speed", &speed, 1 / 16.0f, 4, "%.3g x", ImGuiSliderFlags_Logarithmic))
    desk.faster(static_cast<double>(speed) / desk.speed);
}

/// A list of solvers for a pane, with the entry "none" if `has_none`.
void lay_out_solver(Desk& desk, const char* name, std::size_t pane) {
  const bool is_there = pane < desk.panes.size();
  const std::string now = is_there ? desk.panes[pane]->solver() : "none";
  ImGui::SetNextItemWidth(kNames);
  if (!ImGui::BeginCombo(name, now.c_str())) return;
  if (pane > 0 && ImGui::Selectable("none", !is_there)) desk.compare(std::nullopt);
  for (const Solver solver : kOfferedSolvers) {
    const char* word = pantin::name_of(solver);
    if (!ImGui::Selectable(word, now == word)) continue;
    if (is_there)
      desk.choose(solver, pane);
    else
      desk.compare(solver);
  }
  ImGui::EndCombo();
}

void lay_out_posing(Desk& desk) {
  bool poses = desk.is_posing();
  if (ImGui::Checkbox("pose mode", &poses)) desk.toggle_posing();
  ImGui::SameLine(112);
  if (ImGui::Button("Keep pose")) desk.wants_pose = true;
  ImGui::SameLine(190);
  if (ImGui::Button("Keep sliders")) desk.wants_tuned = true;
}

void lay_out_looks(Desk& desk) {
  ImGui::Checkbox("joints", &desk.overlay);
  ImGui::SameLine(112);
  ImGui::Checkbox("forces", &desk.forces);
  ImGui::SameLine(210);
  ImGui::Checkbox("wires", &desk.wireframe);
  bool follows = static_cast<bool>(desk.followed);
  if (ImGui::Checkbox("follow", &follows)) desk.toggle_follow();
  ImGui::SameLine(112);
  if (ImGui::Button("Camera back")) desk.reset_camera();
  ImGui::SameLine(210);
  ImGui::Checkbox("help", &desk.help);
}

void lay_out_tools(Desk& desk) {
  ImGui::TextUnformatted("left button:");
  for (std::size_t i = 0; i < std::size(kTools); ++i) {
    if (i > 0) ImGui::SameLine();
    if (ImGui::RadioButton(kTools[i], desk.tool == static_cast<Tool>(i)))
      desk.tool = static_cast<Tool>(i);
  }
  if (desk.tool != Tool::ball) return;
  const auto slider = [](const char* name, double& value, double low, double high) {
    ImGui::SetNextItemWidth(kNames);
    ImGui::SliderScalar(name, ImGuiDataType_Double, &value, &low, &high, "%.3g",
                        ImGuiSliderFlags_Logarithmic);
  };
  slider("ball radius, m", desk.gun.radius, 1e-3, 10);
  slider("ball mass, kg", desk.gun.mass, 1e-3, 1e4);
  slider("ball speed, m/s", desk.gun.speed, 0.1, 200);
}

/// Its height is constant, so that the rest does not jump.
void lay_out_body(const Desk& desk) {
  constexpr int kLines = 6;
  ImGui::BeginChild("body", {0, kLines * ImGui::GetTextLineHeightWithSpacing()});
  const auto lines = describe(desk.pane_at_mouse().world(), desk.under);
  if (lines.empty()) ImGui::TextDisabled("nothing yet: move the mouse over a body");
  for (const std::string& text : lines) ImGui::TextWrapped("%s", text.c_str());
  ImGui::EndChild();
}

/// The findings so far, latest first.
void lay_out_findings(const Desk& desk) {
  constexpr int kLines = 5;
  const Pane& pane = desk.pane_at_mouse();
  const std::span<const Finding> found = pane.sim.findings();
  if (found.empty()) return ImGui::TextDisabled("no findings");
  ImGui::BeginChild("findings", {0, kLines * ImGui::GetTextLineHeightWithSpacing()});
  for (auto f = found.rbegin(); f != found.rend(); ++f) {
    ImGui::TextWrapped("%s", words_of(pane.world(), *f).c_str());
    if (ImGui::IsItemHovered())
      ImGui::SetTooltip("%s", std::string(info_of(f->kind).change).c_str());
  }
  ImGui::EndChild();
}

void lay_out_knobs(Desk& desk, const std::vector<Knob>& knobs, KnobGroup group) {
  for (const Knob& knob : knobs) {
    if (knob.group != group) continue;
    const std::string name = knob.name + (knob.unit.empty() ? "" : ", " + knob.unit);
    // Long names stand above their sliders.
    const bool is_above = name.size() > 20;
    if (is_above) ImGui::TextWrapped("%s", name.c_str());
    ImGui::SetNextItemWidth(is_above ? -1 : kNames);
    const ImGuiSliderFlags how =
        (knob.is_logarithmic ? ImGuiSliderFlags_Logarithmic : ImGuiSliderFlags_None) |
        ImGuiSliderFlags_AlwaysClamp;
    const std::string shown = is_above ? "##" + name : name;
    double value = knob.value;
    bool turned = false;
    if (knob.is_whole) {
      int whole = static_cast<int>(value);
      turned = ImGui::SliderInt(shown.c_str(), &whole, static_cast<int>(knob.low),
                                static_cast<int>(knob.high), "%d", how);
      value = whole;
    } else {
      turned = ImGui::SliderScalar(shown.c_str(), ImGuiDataType_Double, &value, &knob.low,
                                   &knob.high, "%.4g", how);
    }
    if (turned) desk.turn(knob.name, value);
  }
}

void lay_out_scenes(Desk& desk) {
  if (ImGui::Button("< before")) desk.leaf(-1);
  ImGui::SameLine();
  if (ImGui::Button("next >")) desk.leaf(1);
  ImGui::BeginChild("scenes", {0, 9 * ImGui::GetTextLineHeightWithSpacing()}, true);
  std::string wanted;
  for (const std::string& path : desk.scenes()) {
    const std::string name = std::filesystem::path(path).stem().string();
    if (ImGui::Selectable(name.c_str(), path == desk.path())) wanted = path;
  }
  ImGui::EndChild();
  if (!wanted.empty()) desk.open(wanted);
}

}  // namespace

void lay_out(Desk& desk, const PanelClock& clock) {
  lay_out_time(desk, clock);
  lay_out_solver(desk, "solver", 0);
  lay_out_solver(desk, "beside it", 1);
  ImGui::Separator();
  lay_out_looks(desk);
  lay_out_tools(desk);
  lay_out_posing(desk);
  if (row_button("Picture", 3)) desk.wants_picture = true;
  ImGui::SameLine();
  if (row_button("Film", 3)) desk.wants_film = true;
  ImGui::SameLine();
  if (row_button("Record", 3)) desk.wants_run = RunWish::from_now;
  const auto section = [](const char* name, ImGuiTreeNodeFlags how = ImGuiTreeNodeFlags_None) {
    return ImGui::CollapsingHeader(name, how);
  };
  if (section("Under the mouse", ImGuiTreeNodeFlags_DefaultOpen)) lay_out_body(desk);
  if (section("Plots", ImGuiTreeNodeFlags_DefaultOpen)) lay_out_plots(desk);
  if (section("Findings", ImGuiTreeNodeFlags_DefaultOpen)) lay_out_findings(desk);
  const std::vector<Knob> knobs = desk.knobs();
  if (section("Step and gravity")) lay_out_knobs(desk, knobs, KnobGroup::world);
  if (section("Motors, drives, springs, limits")) lay_out_knobs(desk, knobs, KnobGroup::motors);
  if (section("Solver settings")) lay_out_knobs(desk, knobs, KnobGroup::solver);
  if (section("Scenes")) lay_out_scenes(desk);
}

}  // namespace pantin::program
#endif
