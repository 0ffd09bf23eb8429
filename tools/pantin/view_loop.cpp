#include "tools/pantin/view_loop.hpp"

#ifdef PANTIN_HAS_VIEW
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "engine/base/utf8.hpp"
#include "tools/pantin/findings.hpp"
#include "tools/pantin/program.hpp"
#include "tools/pantin/view_session.hpp"

namespace pantin::program {

using namespace detail;

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kFrame = 1.0 / 60;      // s, of a scripted frame; minimum of a live one
constexpr double kLongestFrame = 0.25;   // s of wall time, upper bound of catching up
constexpr double kStepBudget = 0.05;     // s of wall time for the steps of a live frame
constexpr double kFastest = 4;           // the highest speed
constexpr double kAfterScript = 1;       // s that a run continues after its last event
constexpr double kWatch = 0.2;           // s between checks of the scene's file
constexpr std::uint64_t kLookEvery = 4;  // frames between updates of the body under the mouse
constexpr double kSlack = 1e-9;

double seconds_between(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

GlPath gl_path(const std::string& name) {
  if (name == "surfaceless") return GlPath::surfaceless;
  if (name == "device") return GlPath::device;
  return name == "osmesa" ? GlPath::osmesa : GlPath::automatic;
}

/// The width of the picture beside the panel.
int picture_width(int window, int panel) {
  return panel > 0 && window >= panel + kLeastBeside ? window - panel : window;
}

DeskChoices desk_choices(const SessionChoices& choices) {
  DeskChoices desk = choices.desk;
  desk.width = picture_width(choices.width, choices.has_panel && has_panel() ? kPanelWidth : 0);
  desk.height = choices.height;
  return desk;
}

}  // namespace

SessionReport show(Scene scene, SessionChoices choices) {
  return Session(std::move(scene), std::move(choices)).run();
}

Session::Session(Scene scene, SessionChoices choices)
    : choices_(std::move(choices)),
      desk_(std::move(scene), desk_choices(choices_)),
      width_(choices_.width),
      height_(choices_.height) {}

void Session::fail(const std::vector<Error>& errors, int exit_code, const char* status) {
  for (const Error& e : errors) complain(e.message);
  report_.exit_code = exit_code, report_.status = status;
}

bool Session::open() {
  std::error_code trouble;
  std::filesystem::create_directories(choices_.frames, trouble);
  if (!std::filesystem::is_directory(choices_.frames, trouble)) {
    fail({Error{choices_.frames +
                ": found no folder and could not create it, expected a folder for frames"}},
         kUnwritable, "unwritable");
    return false;
  }
  RenderOptions options;
  options.width = choices_.width, options.height = choices_.height;
  options.path = gl_path(choices_.gl);
  auto renderer = Renderer::create(options);
  if (!renderer) {
    fail(renderer.errors(), kFailed, "failed");
    return false;
  }
  renderer_ = std::move(*renderer);
  report_.gl = renderer_->report().path;
  auto window =
      Window::open(printable(desk_.scene().title) + " - pantin", choices_.width, choices_.height,
                   choices_.is_scripted ? Window::Display::optional : Window::Display::required);
  if (!window) {
    fail(window.errors(), kFailed, "failed");
    return false;
  }
  window_ = std::move(*window);
  report_.driver = window_->driver();
  panel_ = Panel::make();
  desk_.panel = choices_.has_panel && panel_;
  desk_.help = !desk_.panel;  // the help covers the picture
  return true;
}

SessionReport Session::run() {
  if (!open()) return report_;
  const Clock::time_point start = Clock::now();
  choices_.is_scripted ? run_script() : run_live();
  if (!choices_.is_scripted)
    report_.frames_a_second =
        static_cast<double>(report_.frames) / std::max(seconds_between(start, Clock::now()), 1e-9);
  finish();
  return report_;
}

void Session::finish() {
  if (desk_.wants_picture) draw(), save();  // requested just before quitting
  end_film();
  end_run();
  Pane& pane = *desk_.panes[0];
  for (const auto& each : desk_.panes) each->hand.let_go(each->world());
  if (desk_.status != "ok" && report_.exit_code == kOk)
    report_.exit_code = kDiverged, report_.status = desk_.status;
  report_.scene = desk_.path(), report_.title = desk_.scene().title;
  report_.warnings = desk_.scene().warnings, report_.notes = desk_.notes;
  for (const Finding& f : pane.sim.findings())
    report_.findings.push_back(words_of(pane.world(), f));
  report_.step = pane.sim.settings.h;
  report_.drags = pane.hand.drags();
  report_.solver = pane.solver();
  if (desk_.panes.size() > 1) report_.beside = desk_.panes[1]->solver();
  report_.is_paused = desk_.paused, report_.speed = desk_.speed;
  report_.is_posing = desk_.is_posing();
  report_.has_panel = panel_ && desk_.width() < width_;
  report_.plots = pane.focus.quantities();
  report_.restarts = desk_.restarts, report_.steps = pane.steps, report_.time = pane.world().time;
  report_.worst_gap = pane.worst_gap, report_.worst_gap_rel = pane.worst_gap_rel;
  report_.hash = state_hash(pane.world());
}

bool Session::may_go_on() {
  if (interrupted() && report_.exit_code == kOk)
    report_.exit_code = kInterrupted, report_.status = "interrupted";
  if (choices_.duration > 0 && desk_.panes[0]->simulated >= choices_.duration - kSlack)
    desk_.quits = true;
  return !desk_.quits && !interrupted();
}

void Session::run_live() {
  Clock::time_point last = Clock::now();
  while (may_go_on()) {
    handle_all();
    const Clock::time_point now = Clock::now();
    const double passed = seconds_between(last, now);
    watched_ += passed;
    if (watched_ > kWatch) desk_.watch(), watched_ = 0;
    frame(std::min(passed, kLongestFrame));
    last = now;
    const double rest = kFrame - seconds_between(now, Clock::now());
    if (rest > 0) SDL_Delay(static_cast<std::uint32_t>(1e3 * rest));
  }
}

void Session::run_script() {
  auto next = choices_.script.begin();
  const auto last = choices_.script.end();
  const double end = (next == last ? 0 : choices_.script.back().time) + kAfterScript;
  for (std::uint64_t k = 0; may_go_on(); ++k) {
    const double time = static_cast<double>(k) * kFrame;
    if (next == last && time > end - kSlack) break;
    for (; next != last && next->time <= time + kSlack && !desk_.quits; ++next) {
      play(*next);
      handle_all();
    }
    handle_all();
    if (!desk_.quits) frame(kFrame);
  }
}

/// A script takes all due steps, a live session as many as time permits.
int Session::most_steps() const {
  if (choices_.is_scripted)
    return 1 + static_cast<int>(std::ceil(kFrame * kFastest / desk_.panes[0]->sim.settings.h));
  double cost = 0;
  for (const auto& pane : desk_.panes) cost += pane->step_cost;
  return cost > 0 ? static_cast<int>(std::clamp(kStepBudget / cost, 1.0, 1e4)) : 4;
}

/// Fits the picture to the window, beside the panel.
void Session::fit_window() {
  window_->size(width_, height_);
  const int width = picture_width(width_, panel_ && desk_.panel ? kPanelWidth : 0);
  if (width != desk_.width() || height_ != desk_.height()) desk_.resize(width, height_);
}

void Session::frame(double wall) {
  fit_window();
  watch_run();
  desk_.advance(wall, most_steps());
  if (beats_++ % kLookEvery == 0) {
    const Entity before = desk_.under;
    desk_.look_under_mouse();
    if (desk_.under != before) desk_.stale = true;
  }
  const bool is_busy = panel_ && desk_.width() < width_ && panel_->is_busy();
  if (desk_.stale || desk_.wants_picture || film_ || is_busy) draw();
  if (desk_.wants_picture) save();
  if (desk_.wants_pose) keep_pose();
  if (desk_.wants_tuned) keep_tuned();
  const std::string title = fmt::format("{} - {:.1f} s - pantin", printable(desk_.scene().title),
                                        desk_.panes[0]->world().time);
  if (title != window_title_) window_->set_title(window_title_ = title);
  if (desk_.wants_film) toggle_film();
  film(wall);
}

}  // namespace pantin::program
#endif
